//! Conversion of messages to and from uORB, CDR and JSON.

use serde::Deserializer;
use serde::de::{DeserializeSeed, Error as _};
use uavspec_runtime::cdr::ByteOrder;

use super::error::{Error, Reason};
use super::json::{self, Builder, MessageSeed};
use super::message::DynamicMessage;
use super::types::MessageType;
use super::validate::{self, ViolationAt};
use super::view::DynamicView;
use super::{cdr, initial, uorb};

impl<'t> MessageType<'t> {
    /// Creates a message with the defaults from its definition. Fields without a default are zero or empty.
    pub fn default(self) -> DynamicMessage<'t> {
        initial::message(self)
    }

    /// Reads a uORB or `ULog` payload, with or without the padding at its end. A `bool` is true unless its byte is 0.
    pub fn decode_uorb(self, payload: &[u8]) -> Result<DynamicMessage<'t>, Error> {
        self.view_uorb(payload)?;
        let mut buffer = Vec::with_capacity(self.plan.size.padded);
        buffer.extend_from_slice(payload);
        buffer.resize(self.plan.size.padded, 0);
        Ok(DynamicMessage { ty: self, buffer })
    }

    /// Like [`decode_uorb`](Self::decode_uorb), but rejects a `bool` that is neither 0 nor 1.
    pub fn decode_uorb_strict(self, payload: &[u8]) -> Result<DynamicMessage<'t>, Error> {
        uorb::check_bools(self.view_uorb(payload)?)?;
        self.decode_uorb(payload)
    }

    /// Views a uORB or `ULog` payload in place, with or without the padding at its end.
    pub fn view_uorb<'v>(self, payload: &'v [u8]) -> Result<DynamicView<'v>, Error>
    where
        't: 'v,
    {
        self.check()?;
        uorb::check_size(self, payload)?;
        Ok(DynamicView { types: self.types, plan: self.plan, bytes: payload, base: 0 })
    }

    /// Views the memory of a message in place.
    ///
    /// `memory` must be the result of [`DynamicMessage::memory`] for a message of the same type. This requirement isn't
    /// checked. Other bytes result in meaningless values, and reading these values can take unbounded time.
    pub fn view_memory<'v>(self, memory: &'v [u8]) -> Result<DynamicView<'v>, Error>
    where
        't: 'v,
    {
        self.check()?;
        Ok(DynamicView { types: self.types, plan: self.plan, bytes: memory, base: 0 })
    }

    /// Reads a CDR payload in either byte order. A `bool` is true unless its byte is 0. Strings that are not Unicode are
    /// accepted; [`DynamicMessage::validate`] reports them.
    ///
    /// The payload may end with up to three padding bytes, which extend it to a multiple of four bytes.
    pub fn decode_cdr(self, payload: &[u8]) -> Result<DynamicMessage<'t>, Error> {
        self.decode_cdr_in(payload, Vec::new())
    }

    /// Like [`decode_cdr`](Self::decode_cdr), with a buffer for the memory of the message, such as that of an earlier message
    /// ([`DynamicMessage::into_memory`]).
    pub fn decode_cdr_in(self, payload: &[u8], buffer: Vec<u8>) -> Result<DynamicMessage<'t>, Error> {
        self.check()?;
        cdr::decode(self, payload, false, buffer)
    }

    /// Like [`decode_cdr`](Self::decode_cdr), but rejects a `bool` that is neither 0 nor 1, and a string that is not
    /// Unicode.
    pub fn decode_cdr_strict(self, payload: &[u8]) -> Result<DynamicMessage<'t>, Error> {
        self.check()?;
        cdr::decode(self, payload, true, Vec::new())
    }

    /// Reads JSON. Sequences and strings longer than their bound are accepted; [`DynamicMessage::validate`] reports
    /// them.
    pub fn from_json(self, json: &serde_json::Value) -> Result<DynamicMessage<'t>, Error> {
        self.build(json)
    }

    /// Reads JSON text without building a tree.
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
}

/// Deserializes a message from JSON or another self-describing format.
impl<'de, 't> DeserializeSeed<'de> for MessageType<'t> {
    type Value = DynamicMessage<'t>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<DynamicMessage<'t>, D::Error> {
        self.build(deserializer).map_err(D::Error::custom)
    }
}

impl DynamicMessage<'_> {
    /// Encodes the message as a uORB payload, including the padding at its end. Fails if the size of the message
    /// varies.
    pub fn to_uorb(&self) -> Result<Vec<u8>, Error> {
        self.view().to_uorb()
    }

    /// Encodes the message as a CDR payload.
    pub fn to_cdr(&self, order: ByteOrder) -> Result<Vec<u8>, Error> {
        self.view().to_cdr(order)
    }

    /// Converts the message to JSON. Fails if a float is infinite or text isn't UTF-8.
    pub fn to_json(&self) -> Result<serde_json::Value, Error> {
        self.view().to_json()
    }

    /// All violations of the definition.
    pub fn validate(&self) -> Vec<ViolationAt<'_>> {
        self.view().validate()
    }
}

impl<'v> DynamicView<'v> {
    /// Encodes the message as a uORB payload, including the padding at its end. Fails if the size of the message
    /// varies.
    pub fn to_uorb(self) -> Result<Vec<u8>, Error> {
        self.message_type().check()?;
        uorb::encode(self)
    }

    /// Encodes the message as a CDR payload.
    pub fn to_cdr(self, order: ByteOrder) -> Result<Vec<u8>, Error> {
        self.to_cdr_in(order, Vec::new())
    }

    /// Like [`to_cdr`](Self::to_cdr), with a buffer for the payload, such as that of an earlier message.
    pub fn to_cdr_in(self, order: ByteOrder, buffer: Vec<u8>) -> Result<Vec<u8>, Error> {
        self.message_type().check()?;
        cdr::encode(self, order, buffer)
    }

    /// Converts the message to JSON. Fails if a float is infinite or text isn't UTF-8.
    pub fn to_json(self) -> Result<serde_json::Value, Error> {
        self.message_type().check()?;
        serde_json::to_value(self).map_err(|error| json::explain(self, &error))
    }

    /// Writes the message as JSON text.
    pub fn to_json_text(self) -> Result<String, Error> {
        self.message_type().check()?;
        serde_json::to_string(&self).map_err(|error| json::explain(self, &error))
    }

    /// All violations of the definition.
    pub fn validate(self) -> Vec<ViolationAt<'v>> {
        let mut violations = Vec::new();
        self.validate_with(&mut |violation| violations.push(violation));
        violations
    }

    /// Calls `report` for each violation of the definition.
    pub fn validate_with(self, report: &mut dyn FnMut(ViolationAt<'v>)) {
        validate::each(self, report);
    }
}
