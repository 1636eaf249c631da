//! Messages whose definitions are known only when the program runs, such as those that logs and bags
//! bring with them: the codecs and checks of generated types, driven by the model.
//!
//! ```
//! use uavspec_codegen::{PackageInput, SourceMap, dynamic::Types, msg::Dialect, read, schema::Form};
//! use uavspec_runtime::cdr::ByteOrder;
//!
//! let mut sources = SourceMap::default();
//! let text = "uint64 timestamp\nfloat32[2] speed  # [@range 0, 60] Over ground\n";
//! let id = sources.add("Wind.msg", text.into()).unwrap();
//! let (schema, _) = read(&sources, &[PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])]);
//!
//! let types = Types::new(&schema);
//! let wind = types.find("px4", "Wind").unwrap();
//! let message = wind.from_json_text(r#"{"timestamp": 7, "speed": [1.5, null]}"#)?;
//! let payload = message.to_cdr(ByteOrder::LittleEndian)?;
//! let message = wind.decode_cdr(&payload)?;
//! assert_eq!(message.get("speed[0]").unwrap().number().unwrap().to_string(), "1.5");
//! assert_eq!(message.validate()[0].to_string(), "speed[1]: NaN, which has no meaning here (PX-NAN-01)");
//! # Ok::<(), uavspec_codegen::dynamic::Error>(())
//! ```
//!
//! # How it works
//!
//! A message is one buffer. Its fields lie in it as in uORB, so a message of fixed size is its own memory
//! form, and a payload of uORB or `ULog` can be looked at where it is ([`DynamicView`]). Strings and
//! sequences have a slot of eight bytes there, which says where behind the fields their bytes or
//! elements start, and how many there are. For CDR, a type is a list of steps, mostly copies of
//! numbers that lie side by side in both forms.
//!
//! Nothing panics on any input, and no payload asks for more room than it has the right to: a message
//! takes at most eight times as many bytes as its CDR payload, or as the text of its JSON. (Eight is what
//! an array of messages with one `uint8` each comes to.) Payloads that are refused take no more than
//! that; JSON takes the fixed size of each message as soon as it begins. The vectors that hold all this
//! may have twice the room. Messages nest at most 32 deep.

mod cdr;
mod compile;
mod error;
mod initial;
mod json;
pub mod members;
mod packed;
mod plan;
mod trail;
mod ulog;
mod uorb;
mod validate;
mod view;
mod walk;

use serde::Deserializer;
use serde::de::{DeserializeSeed, Error as _};
use uavspec_runtime::Scalar;
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::layout::Size;

pub use self::error::{Defect, Error, Reason};
use self::json::{Builder, MessageSeed};
use self::plan::Plan;
pub use self::ulog::{FormatError, FormatProblem, ULOG_PACKAGE};
pub use self::validate::Violation;
pub use self::view::{DynamicView, Elements, Value};
use crate::schema::{MessageId, Schema, Shape};

/// The types of all messages of a schema, or of a log.
#[derive(Debug)]
pub struct Types {
    plans: Vec<Plan>,
    /// Indices of the plans, by package and name.
    by_name: Vec<usize>,
}

impl Types {
    /// The types of all messages of a schema.
    pub fn new(schema: &Schema) -> Self {
        Self::of(compile::compile(compile::drafts(schema)))
    }

    fn of(plans: Vec<Plan>) -> Self {
        let mut by_name: Vec<usize> = (0..plans.len()).collect();
        by_name.sort_by_key(|index| (&plans[*index].package, &plans[*index].name));
        Self { plans, by_name }
    }

    /// The type of a message of the schema that these types were made from.
    ///
    /// # Panics
    ///
    /// Where it has no such message.
    pub fn get(&self, id: MessageId) -> MessageType<'_> {
        MessageType { types: self, plan: &self.plans[id.0 as usize] }
    }

    /// The type with this name.
    pub fn find(&self, package: &str, name: &str) -> Option<MessageType<'_>> {
        let key = |index: &usize| (&*self.plans[*index].package, &*self.plans[*index].name);
        let found = self.by_name.binary_search_by_key(&(package, name), key).ok()?;
        Some(MessageType { types: self, plan: &self.plans[self.by_name[found]] })
    }

    /// All of them, by package and name.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = MessageType<'_>> {
        self.by_name.iter().map(|index| MessageType { types: self, plan: &self.plans[*index] })
    }
}

/// A type of messages.
#[derive(Clone, Copy, Debug)]
pub struct MessageType<'t> {
    types: &'t Types,
    plan: &'t Plan,
}

impl<'t> MessageType<'t> {
    /// Its package.
    pub fn package(self) -> &'t str {
        &self.plan.package
    }

    /// Its name.
    pub fn name(self) -> &'t str {
        &self.plan.name
    }

    /// Names of its fields, in declared order.
    pub fn field_names(self) -> impl ExactSizeIterator<Item = &'t str> {
        self.plan.fields.iter().map(|field| &*field.name)
    }

    /// Where its fields lie in a payload of uORB, in declared order.
    pub fn layout(self) -> impl ExactSizeIterator<Item = Placed<'t>> {
        self.plan.fields.iter().map(move |field| Placed {
            name: &field.name,
            element: match field.element {
                plan::Element::Scalar(scalar) => PlacedElement::Scalar(scalar),
                plan::Element::Text(length) => PlacedElement::Text(length),
                plan::Element::String(_) => PlacedElement::String,
                plan::Element::Message(index) => {
                    PlacedElement::Message(MessageType { types: self.types, plan: &self.types.plans[index] })
                }
            },
            shape: field.shape,
            offset: field.offset,
            stride: field.stride,
        })
    }

    /// Its size in uORB, in bytes; none where it varies.
    pub fn size(self) -> Option<Size> {
        (self.plan.is_fixed && self.plan.defect.is_none()).then_some(self.plan.size)
    }

    /// Why its messages can't be handled, where that is so. All that is asked of it then fails.
    pub fn defect(self) -> Option<&'t Defect> {
        self.plan.defect.as_ref()
    }

    /// A message of zeros and empty strings, or of the defaults that its definition states.
    pub fn default(self) -> DynamicMessage<'t> {
        initial::message(self)
    }

    /// Reads a payload of uORB or `ULog`, with or without the padding at its end. A `bool` is true unless its
    /// byte is 0.
    pub fn decode_uorb(self, payload: &[u8]) -> Result<DynamicMessage<'t>, Error> {
        self.view_uorb(payload)?;
        let mut buffer = Vec::with_capacity(self.plan.size.padded);
        buffer.extend_from_slice(payload);
        buffer.resize(self.plan.size.padded, 0);
        Ok(DynamicMessage { of: self, buffer })
    }

    /// As [`decode_uorb`](Self::decode_uorb), but refuses a `bool` that is neither 0 nor 1.
    pub fn decode_uorb_strict(self, payload: &[u8]) -> Result<DynamicMessage<'t>, Error> {
        uorb::check_bools(self.view_uorb(payload)?)?;
        self.decode_uorb(payload)
    }

    /// Looks at a payload of uORB or `ULog`, with or without the padding at its end, where it is.
    pub fn view_uorb<'v>(self, payload: &'v [u8]) -> Result<DynamicView<'v>, Error>
    where
        't: 'v,
    {
        self.check()?;
        uorb::check_size(self, payload)?;
        Ok(DynamicView { types: self.types, plan: self.plan, bytes: payload, base: 0 })
    }

    /// Reads a CDR payload in either byte order. A `bool` is true unless its byte is 0.
    ///
    /// Up to three bytes may follow, which fill the payload up to a multiple of four.
    pub fn decode_cdr(self, payload: &[u8]) -> Result<DynamicMessage<'t>, Error> {
        self.check()?;
        cdr::decode(self, payload, false)
    }

    /// As [`decode_cdr`](Self::decode_cdr), but refuses a `bool` that is neither 0 nor 1.
    pub fn decode_cdr_strict(self, payload: &[u8]) -> Result<DynamicMessage<'t>, Error> {
        self.check()?;
        cdr::decode(self, payload, true)
    }

    /// Reads JSON. Lengths beyond a bound are taken, for [`DynamicMessage::validate`] to find.
    pub fn from_json(self, json: &serde_json::Value) -> Result<DynamicMessage<'t>, Error> {
        self.build(json)
    }

    /// Reads the text of JSON, without a tree between.
    pub fn from_json_text(self, text: &str) -> Result<DynamicMessage<'t>, Error> {
        let mut reader = serde_json::Deserializer::from_str(text);
        let message = self.build(&mut reader)?;
        reader.end().map_err(|error| self.error(Reason::Json(error.to_string())))?;
        Ok(message)
    }

    fn build<'de, D: Deserializer<'de>>(self, deserializer: D) -> Result<DynamicMessage<'t>, Error> {
        self.check()?;
        let mut builder = Builder::new(self);
        let seed = MessageSeed { builder: &mut builder, plan: self.plan, base: 0 };
        match seed.deserialize(deserializer) {
            Ok(()) => Ok(builder.finish()),
            Err(error) => Err(Error {
                reason: Reason::Json(error.to_string()),
                path: builder.trail.text(&self.plan.name),
                offset: None,
            }),
        }
    }

    fn check(self) -> Result<(), Error> {
        match &self.plan.defect {
            None => Ok(()),
            Some(defect) => Err(self.error(Reason::Defect(defect.clone()))),
        }
    }

    fn error(self, reason: Reason) -> Error {
        Error { reason, path: self.plan.name.to_string(), offset: None }
    }
}

/// Reads a message from JSON, or another format that describes itself.
impl<'de, 't> DeserializeSeed<'de> for MessageType<'t> {
    type Value = DynamicMessage<'t>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<DynamicMessage<'t>, D::Error> {
        self.build(deserializer).map_err(D::Error::custom)
    }
}

/// A field and its place.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'t> {
    /// Its name.
    pub name: &'t str,
    /// What it holds.
    pub element: PlacedElement<'t>,
    /// How many of them.
    pub shape: Shape,
    /// Its first byte, from the start of the message.
    pub offset: usize,
    /// Bytes from one element to the next.
    pub stride: usize,
}

/// What a field holds.
#[derive(Clone, Copy, Debug)]
pub enum PlacedElement<'t> {
    /// A number or a `bool`.
    Scalar(Scalar),
    /// PX4's `char[N]` as a whole, of so many bytes.
    Text(u32),
    /// A string, of which only the slot stands here.
    String,
    /// A message.
    Message(MessageType<'t>),
}

/// A message.
#[derive(Clone)]
pub struct DynamicMessage<'t> {
    of: MessageType<'t>,
    /// The fields, and behind them strings and the elements of sequences.
    buffer: Vec<u8>,
}

impl<'t> DynamicMessage<'t> {
    /// Its type.
    pub fn message_type(&self) -> MessageType<'t> {
        self.of
    }

    /// Looks at it.
    pub fn view(&self) -> DynamicView<'_> {
        DynamicView { types: self.of.types, plan: self.of.plan, bytes: &self.buffer, base: 0 }
    }

    /// The value that a path such as `events[2].id` leads to, if there is one.
    pub fn get(&self, path: &str) -> Option<Value<'_>> {
        self.view().get(path)
    }

    /// The payload of uORB, with the padding at its end; an error where the size varies.
    pub fn to_uorb(&self) -> Result<Vec<u8>, Error> {
        self.view().to_uorb()
    }

    /// The CDR payload.
    pub fn to_cdr(&self, order: ByteOrder) -> Result<Vec<u8>, Error> {
        self.view().to_cdr(order)
    }

    /// The message as JSON; an error where a float is infinite or text isn't UTF-8.
    pub fn to_json(&self) -> Result<serde_json::Value, Error> {
        self.view().to_json()
    }

    /// Everything in it that breaks a rule of its definition.
    pub fn validate(&self) -> Vec<Violation<'_>> {
        self.view().validate()
    }

    /// Its bytes in memory, as [`MessageType::layout`] places its fields; a `bool` is the byte that was read.
    pub fn memory(&self) -> &[u8] {
        &self.buffer
    }

    /// How many bytes it takes in memory.
    pub fn size_in_memory(&self) -> usize {
        self.buffer.len()
    }
}

impl<'v> DynamicView<'v> {
    /// The payload of uORB, with the padding at its end; an error where the size varies.
    pub fn to_uorb(self) -> Result<Vec<u8>, Error> {
        self.message_type().check()?;
        uorb::encode(self)
    }

    /// The CDR payload.
    pub fn to_cdr(self, order: ByteOrder) -> Result<Vec<u8>, Error> {
        self.message_type().check()?;
        cdr::encode(self, order)
    }

    /// The message as JSON; an error where a float is infinite or text isn't UTF-8.
    pub fn to_json(self) -> Result<serde_json::Value, Error> {
        self.message_type().check()?;
        serde_json::to_value(self).map_err(|error| json::unsayable(self, &error))
    }

    /// The text of its JSON.
    pub fn to_json_text(self) -> Result<String, Error> {
        self.message_type().check()?;
        serde_json::to_string(&self).map_err(|error| json::unsayable(self, &error))
    }

    /// Everything in it that breaks a rule of its definition.
    pub fn validate(self) -> Vec<Violation<'v>> {
        let mut violations = Vec::new();
        self.validate_with(&mut |violation| violations.push(violation));
        violations
    }

    /// Calls `report` with everything in it that breaks a rule of its definition.
    pub fn validate_with(self, report: &mut dyn FnMut(Violation<'v>)) {
        validate::each(self, report);
    }
}
