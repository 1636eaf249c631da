//! Says whether a message is clean, as its text is read, without a tree.
//!
//! An error says only that something is wrong: what, is worked out from the tree.

use std::fmt;

use serde::Deserializer;
use serde::de::{DeserializeSeed, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use uavspec_codegen::dynamic::members::{KeySeed, Seen};
use uavspec_codegen::schema::{MessageId, Shape};
use uavspec_runtime::Scalar;

use super::dialect::{Dialect, Dialects};
use super::plan::{Element, FieldPlan, MessagePlan, Plans};
use super::value::Leaf;
use crate::json::base64;

/// What a clean message says of itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Clean {
    /// Its own field `timestamp`.
    pub(crate) timestamp: Option<u64>,
    /// What differs from the published schema.
    pub(crate) dialects: Dialects,
}

impl Plans {
    /// Whether a text is a message, and nothing is wrong with it. `is_rosbridge` allows what rosbridge writes.
    pub fn is_clean(&self, id: MessageId, text: &str, is_rosbridge: bool) -> bool {
        let mut reader = serde_json::Deserializer::from_str(text);
        let seed = MessageSeed::new(self, id, is_rosbridge, &mut []);
        seed.deserialize(&mut reader).is_ok() && reader.end().is_ok()
    }
}

/// Reads a message.
pub(crate) struct MessageSeed<'p, 'v> {
    reading: Reading<'p, 'v>,
    plan: &'p MessagePlan,
}

impl<'p, 'v> MessageSeed<'p, 'v> {
    /// `values` gets the numbers and bools of the message as they lie in memory. It has the size of the message,
    /// or is empty where nobody wants them.
    pub(crate) fn new(plans: &'p Plans, id: MessageId, is_rosbridge: bool, values: &'v mut [u8]) -> Self {
        let reading = Reading { plans, is_rosbridge, values, clean: Clean::default() };
        Self { reading, plan: plans.get(id) }
    }
}

impl<'de> DeserializeSeed<'de> for MessageSeed<'_, '_> {
    type Value = Clean;

    fn deserialize<D: Deserializer<'de>>(mut self, deserializer: D) -> Result<Clean, D::Error> {
        deserializer.deserialize_map(Members {
            reading: &mut self.reading,
            plan: self.plan,
            base: 0,
            is_top: true,
        })?;
        Ok(self.reading.clean)
    }
}

struct Reading<'p, 'v> {
    plans: &'p Plans,
    is_rosbridge: bool,
    values: &'v mut [u8],
    clean: Clean,
}

fn unclean<E: Error>() -> E {
    E::custom("unclean")
}

/// The members of a message.
struct Members<'r, 'p, 'v> {
    reading: &'r mut Reading<'p, 'v>,
    plan: &'p MessagePlan,
    /// Where the message starts in memory.
    base: usize,
    is_top: bool,
}

impl<'de> Visitor<'de> for Members<'_, '_, '_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a message")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let Self { reading, plan, base, is_top } = self;
        let fields = &plan.fields;
        let mut seen = Seen::default();
        let mut guess = 0;
        while let Some(index) = map.next_key_seed(KeySeed { fields, guess })? {
            if !seen.insert(index, fields.len()) {
                return Err(unclean());
            }
            let field = &fields[index];
            if is_top && field.is_timestamp() {
                let timestamp: u64 = map.next_value()?;
                reading.clean.timestamp = Some(timestamp);
                field.keep(reading.values, field.offset, Leaf::Int(timestamp.into()));
            } else {
                map.next_value_seed(Value { reading, field, at: base + field.offset, is_element: false })?;
            }
            guess = index + 1;
        }
        if (0..fields.len()).all(|index| seen.contains(index)) { Ok(()) } else { Err(unclean()) }
    }
}

/// Reads the value of a field, or of an element of it.
struct Value<'r, 'p, 'v> {
    reading: &'r mut Reading<'p, 'v>,
    field: &'p FieldPlan,
    /// Where it starts in memory.
    at: usize,
    is_element: bool,
}

impl Value<'_, '_, '_> {
    fn is_array(&self) -> bool {
        self.field.shape != Shape::Single && !self.is_element
    }

    fn leaf<E: Error>(self, leaf: Leaf<'_>) -> Result<(), E> {
        if self.is_array() {
            return Err(unclean());
        }
        self.field.keep(self.reading.values, self.at, leaf);
        self.field.judge(leaf).map_err(|_| unclean())
    }
}

impl<'de> DeserializeSeed<'de> for Value<'_, '_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Value<'_, '_, '_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.field.expected(self.is_element), formatter)
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.leaf(Leaf::Null)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<(), E> {
        self.leaf(Leaf::Bool(value))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<(), E> {
        self.leaf(Leaf::Int(value.into()))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<(), E> {
        self.leaf(Leaf::Int(value.into()))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<(), E> {
        self.leaf(Leaf::Float(value))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<(), E> {
        if let Some(bytes) = self.field.as_base64(text, self.reading.is_rosbridge, self.is_element) {
            self.reading.clean.dialects.insert(Dialect::Base64);
            return self.field.judge_bytes(&bytes).then_some(()).ok_or_else(unclean);
        }
        self.leaf(Leaf::Text(text))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        let Self { reading, field, at, .. } = self;
        if let (Element::Text(room), true) = (field.element, reading.is_rosbridge) {
            let mut bytes = Vec::new();
            while bytes.len() < room as usize
                && let Some(byte) = seq.next_element()?
            {
                bytes.push(byte);
            }
            if seq.next_element::<IgnoredAny>()?.is_some() {
                return Err(unclean());
            }
            reading.clean.dialects.insert(Dialect::NumbersForText);
            return field.judge_text(&bytes).map_err(|_| unclean());
        }
        if field.shape == Shape::Single || self.is_element {
            return Err(unclean());
        }
        let mut count = 0;
        let mut element = at;
        while seq.next_element_seed(Value { reading, field, at: element, is_element: true })?.is_some() {
            count += 1;
            element += field.stride;
        }
        field.judge_length(count).map_err(|_| unclean())
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<(), A::Error> {
        match self.field.element {
            Element::Message(id) if !self.is_array() => {
                let plan = self.reading.plans.get(id);
                Members { reading: self.reading, plan, base: self.at, is_top: false }.visit_map(map)
            }
            _ => Err(unclean()),
        }
    }
}

impl FieldPlan {
    /// Whether it is the time of a message. It needs no restriction, which its definition doesn't give.
    pub(super) fn is_timestamp(&self) -> bool {
        self.name == "timestamp"
            && matches!(self.element, Element::Scalar(Scalar::UInt64))
            && self.shape == Shape::Single
            && self.restriction.is_none()
    }

    /// The bytes of an array that a text stands for, where that is how rosbridge writes it.
    ///
    /// Text that fits into its array is shorter than its base64, so it can't be taken for such.
    pub(super) fn as_base64(&self, text: &str, is_rosbridge: bool, is_element: bool) -> Option<Vec<u8>> {
        let is_bytes = match self.element {
            Element::Text(room) => text.len() > room as usize,
            _ => self.holds_bytes() && !is_element,
        };
        if is_rosbridge && is_bytes { base64::decode(text) } else { None }
    }

    /// Whether nothing is wrong with an array that was written as base64.
    fn judge_bytes(&self, bytes: &[u8]) -> bool {
        match self.element {
            Element::Text(_) => self.judge_text(bytes).is_ok(),
            _ => {
                self.judge_length(bytes.len()).is_ok()
                    && bytes.iter().all(|byte| self.judge(Leaf::Int((*byte).into())).is_ok())
            }
        }
    }
}
