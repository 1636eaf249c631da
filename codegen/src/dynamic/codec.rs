//! The forms of a message: uORB, CDR and JSON.

use serde::Deserializer;
use serde::de::{DeserializeSeed, Error as _};
use uavspec_runtime::cdr::ByteOrder;

use super::error::{Error, Reason};
use super::json::{self, Builder, MessageSeed};
use super::message::DynamicMessage;
use super::types::MessageType;
use super::validate::{self, Violation};
use super::view::DynamicView;
use super::{cdr, initial, uorb};

impl<'t> MessageType<'t> {
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
}

/// Reads a message from JSON, or another format that describes itself.
impl<'de, 't> DeserializeSeed<'de> for MessageType<'t> {
    type Value = DynamicMessage<'t>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<DynamicMessage<'t>, D::Error> {
        self.build(deserializer).map_err(D::Error::custom)
    }
}

impl DynamicMessage<'_> {
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
