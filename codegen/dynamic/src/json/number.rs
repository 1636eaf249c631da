//! Numbers and `bool`s in JSON.

use std::fmt;

use serde::Deserializer;
use serde::de::{DeserializeSeed, Error, Unexpected, Visitor};
use uavspec_runtime::Scalar;

/// Reads a number of this type. The result is the little-endian bytes of the number, followed by zeros.
#[derive(Clone, Copy)]
pub(super) struct NumberSeed(pub(super) Scalar);

impl<'de> DeserializeSeed<'de> for NumberSeed {
    type Value = [u8; 8];

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<[u8; 8], D::Error> {
        match self.0 {
            Scalar::Bool => deserializer.deserialize_bool(self),
            Scalar::Float32 | Scalar::Float64 => deserializer.deserialize_option(self),
            Scalar::Int8 | Scalar::Int16 | Scalar::Int32 | Scalar::Int64 => {
                deserializer.deserialize_i64(self)
            }
            Scalar::Byte
            | Scalar::Char
            | Scalar::UInt8
            | Scalar::UInt16
            | Scalar::UInt32
            | Scalar::UInt64 => deserializer.deserialize_u64(self),
        }
    }
}

impl<'de> Visitor<'de> for NumberSeed {
    type Value = [u8; 8];

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.0.integer_bounds(), self.0.is_float()) {
            (Some((low, high)), _) => write!(formatter, "an integer from {low} to {high}"),
            (None, true) => formatter.write_str("a number or null"),
            (None, false) => formatter.write_str("true or false"),
        }
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<[u8; 8], E> {
        if self.0 == Scalar::Bool {
            Ok(u64::from(value).to_le_bytes())
        } else {
            Err(E::invalid_type(Unexpected::Bool(value), &self))
        }
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<[u8; 8], E> {
        match self.0.integer_bounds() {
            Some((_, high)) if i128::from(value) <= high => Ok(value.to_le_bytes()),
            Some(_) => Err(E::invalid_value(Unexpected::Unsigned(value), &self)),
            #[allow(clippy::cast_precision_loss)] // the field is a float
            None if self.0.is_float() => self.visit_f64(value as f64),
            None => Err(E::invalid_type(Unexpected::Unsigned(value), &self)),
        }
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<[u8; 8], E> {
        match self.0.integer_bounds() {
            Some((low, high)) if (low..=high).contains(&value.into()) => Ok(value.to_le_bytes()),
            Some(_) => Err(E::invalid_value(Unexpected::Signed(value), &self)),
            #[allow(clippy::cast_precision_loss)] // the field is a float
            None if self.0.is_float() => self.visit_f64(value as f64),
            None => Err(E::invalid_type(Unexpected::Signed(value), &self)),
        }
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<[u8; 8], E> {
        #[allow(clippy::cast_possible_truncation)] // a float32 is rounded
        let (bits, is_infinite) = match self.0 {
            Scalar::Float32 => ((value as f32).to_bits().into(), (value as f32).is_infinite()),
            Scalar::Float64 => (value.to_bits(), value.is_infinite()),
            _ => return Err(E::invalid_type(Unexpected::Float(value), &self)),
        };
        if is_infinite {
            return Err(E::custom(format_args!("number too large for {}", self.0.name())));
        }
        Ok(bits.to_le_bytes())
    }

    /// Reads `null` as NaN.
    fn visit_unit<E: Error>(self) -> Result<[u8; 8], E> {
        match self.0 {
            Scalar::Float32 => Ok(u64::from(f32::NAN.to_bits()).to_le_bytes()),
            Scalar::Float64 => Ok(f64::NAN.to_bits().to_le_bytes()),
            _ => Err(E::invalid_type(Unexpected::Unit, &self)),
        }
    }

    fn visit_none<E: Error>(self) -> Result<[u8; 8], E> {
        self.visit_unit()
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<[u8; 8], D::Error> {
        match self.0 {
            // Rounds once, without an intermediate 64-bit float, if the format supports it.
            Scalar::Float32 => deserializer.deserialize_f32(self),
            _ => deserializer.deserialize_f64(self),
        }
    }
}
