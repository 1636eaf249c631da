//! JSON decoder that builds no tree.

use std::fmt;

use serde::Deserializer;
use serde::de::{DeserializeSeed, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};
use uavspec_schema::{Element, Shape};

use super::number::NumberSeed;
use crate::members::{KeySeed, Seen};
use crate::message::DynamicMessage;
use crate::plan::{Field, Plan, SLOT};
use crate::trail::Trail;
use crate::types::MessageType;

/// A message under construction.
pub(crate) struct Builder<'t> {
    ty: MessageType<'t>,
    /// The message, followed by the elements of incomplete sequences.
    open: Vec<u8>,
    /// Strings and complete sequences, which are appended to the message when reading ends.
    closed: Vec<u8>,
    /// The current path, or the path of the error.
    pub(crate) trail: Trail<'t>,
}

impl<'t> Builder<'t> {
    pub(crate) fn new(ty: MessageType<'t>) -> Self {
        let open = vec![0; ty.plan.size.padded];
        Self { ty, open, closed: Vec::new(), trail: Trail::default() }
    }

    pub(crate) fn finish(mut self) -> DynamicMessage<'t> {
        self.open.append(&mut self.closed);
        DynamicMessage { ty: self.ty, buffer: self.open }
    }

    /// Writes bytes into the message or an open element.
    pub(crate) fn write(&mut self, at: usize, bytes: &[u8]) {
        if let Some(to) = self.open.get_mut(at..at + bytes.len()) {
            to.copy_from_slice(bytes);
        }
    }

    /// Adds a string, and writes its slot at `at`.
    pub(crate) fn string<E: serde::de::Error>(&mut self, at: usize, text: &str) -> Result<(), E> {
        let start = self.closed.len();
        self.closed.extend_from_slice(text.as_bytes());
        self.point(at, start, text.len())
    }

    /// Size of the message and the open elements, in bytes.
    pub(crate) fn opened(&self) -> usize {
        self.open.len()
    }

    /// Opens a zeroed element of a sequence, and returns its offset.
    pub(crate) fn open_element(&mut self, stride: usize) -> usize {
        let at = self.open.len();
        self.open.resize(at + stride, 0);
        at
    }

    /// Closes the sequence whose first element was opened at `first`, and writes its slot at `at`.
    pub(crate) fn close<E: serde::de::Error>(
        &mut self,
        at: usize,
        first: usize,
        count: usize,
    ) -> Result<(), E> {
        let start = self.closed.len();
        self.closed.extend_from_slice(&self.open[first..]);
        self.open.truncate(first);
        self.point(at, start, count)
    }

    fn point<E: serde::de::Error>(&mut self, at: usize, start: usize, count: usize) -> Result<(), E> {
        let start = start + self.ty.plan.size.padded;
        let (Ok(start), Ok(count)) = (u32::try_from(start), u32::try_from(count)) else {
            return Err(E::custom("the message exceeds 4 GiB"));
        };
        let mut slot = [0; SLOT];
        slot[..4].copy_from_slice(&start.to_le_bytes());
        slot[4..].copy_from_slice(&count.to_le_bytes());
        self.write(at, &slot);
        Ok(())
    }
}

/// Reads a message into the builder at `base`.
pub(crate) struct MessageSeed<'b, 't> {
    pub(crate) builder: &'b mut Builder<'t>,
    pub(crate) plan: &'t Plan,
    pub(crate) base: usize,
}

impl<'de> DeserializeSeed<'de> for MessageSeed<'_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for MessageSeed<'_, '_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "an object with the fields of {}", self.plan.name)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let Self { builder, plan, base } = self;
        let mut seen = Seen::default();
        let mut guess = 0;
        while let Some(index) = map.next_key_seed(KeySeed { fields: &plan.fields, guess })? {
            let field = &plan.fields[index];
            builder.trail.enter(&field.name);
            if !seen.insert(index, plan.fields.len()) {
                return Err(A::Error::custom(format_args!("duplicate field `{}`", field.name)));
            }
            map.next_value_seed(FieldSeed { builder, field, at: base + field.offset })?;
            builder.trail.leave();
            guess = index + 1;
        }
        match (0..plan.fields.len()).find(|index| !seen.contains(*index)) {
            Some(missing) => {
                Err(A::Error::custom(format_args!("missing field `{}`", plan.fields[missing].name)))
            }
            None => Ok(()),
        }
    }
}

/// Reads a field into the builder at `at`.
struct FieldSeed<'b, 't> {
    builder: &'b mut Builder<'t>,
    field: &'t Field,
    at: usize,
}

impl<'de> DeserializeSeed<'de> for FieldSeed<'_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        match self.field.shape {
            Shape::Single => {
                let Self { builder, field, at } = self;
                ElementSeed { builder, field, at }.deserialize(deserializer)
            }
            Shape::Array(_) | Shape::Bounded(_) | Shape::Sequence => deserializer.deserialize_seq(self),
        }
    }
}

impl<'de> Visitor<'de> for FieldSeed<'_, '_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.field.shape {
            Shape::Array(length) => write!(formatter, "an array of {length}"),
            Shape::Single | Shape::Bounded(_) | Shape::Sequence => formatter.write_str("an array"),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<(), A::Error> {
        if self.field.is_sequence() { self.sequence(seq) } else { self.array(seq) }
    }
}

impl FieldSeed<'_, '_> {
    fn array<'de, A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        let Self { builder, field, at } = self;
        let length = field.count();
        for index in 0..length {
            builder.trail.select(Some(index));
            let seed = ElementSeed { builder, field, at: at + index * field.stride };
            if seq.next_element_seed(seed)?.is_none() {
                builder.trail.select(None);
                let expected = format!("an array of {length}");
                return Err(A::Error::invalid_length(index, &expected.as_str()));
            }
        }
        builder.trail.select(None);
        if seq.next_element::<IgnoredAny>()?.is_some() {
            return Err(A::Error::custom(format_args!(
                "more than {length} elements, expected an array of {length}"
            )));
        }
        Ok(())
    }

    fn sequence<'de, A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        let Self { builder, field, at } = self;
        let first = builder.opened();
        let mut count = 0;
        loop {
            builder.trail.select(Some(count));
            let at = builder.open_element(field.stride);
            if seq.next_element_seed(ElementSeed { builder, field, at })?.is_none() {
                builder.open.truncate(at);
                break;
            }
            count += 1;
        }
        builder.trail.select(None);
        builder.close(at, first, count)
    }
}

/// Reads a field value, or one element of a field, into the builder at `at`.
struct ElementSeed<'b, 't> {
    builder: &'b mut Builder<'t>,
    field: &'t Field,
    at: usize,
}

impl<'de> DeserializeSeed<'de> for ElementSeed<'_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        match self.field.element {
            Element::Scalar(scalar) => {
                let bytes = NumberSeed(scalar).deserialize(deserializer)?;
                self.builder.write(self.at, &bytes[..scalar.size()]);
                Ok(())
            }
            Element::Text(_) | Element::String { .. } => deserializer.deserialize_str(self),
            Element::Message(id) => {
                let plan = self.builder.ty.nested(id).plan;
                MessageSeed { builder: self.builder, plan, base: self.at }.deserialize(deserializer)
            }
        }
    }
}

/// Reads strings and texts.
impl Visitor<'_> for ElementSeed<'_, '_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.field.element {
            Element::Text(length) => write!(formatter, "a string of at most {length} bytes"),
            _ => formatter.write_str("a string"),
        }
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<(), E> {
        let Element::Text(room) = self.field.element else { return self.builder.string(self.at, text) };
        if text.contains('\0') {
            return Err(E::custom("expected text without NUL"));
        }
        if text.len() > room as usize {
            return Err(E::custom(format_args!(
                "expected at most {room} bytes of text, found {}",
                text.len()
            )));
        }
        self.builder.write(self.at, text.as_bytes());
        Ok(())
    }
}
