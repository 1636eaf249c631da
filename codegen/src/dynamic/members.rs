//! The members of a JSON object whose names are known: read as indices, and each once.
//!
//! ```
//! use serde::de::DeserializeSeed as _;
//! use uavspec_codegen::dynamic::members::{KeySeed, Named};
//!
//! struct Field(&'static str);
//!
//! impl Named for Field {
//!     fn name(&self) -> &str {
//!         self.0
//!     }
//! }
//!
//! let fields = [Field("speed"), Field("gust")];
//! let mut key = serde_json::Deserializer::from_str("\"gust\"");
//! assert_eq!(KeySeed { fields: &fields, guess: 0 }.deserialize(&mut key)?, 1);
//! # Ok::<(), serde_json::Error>(())
//! ```

use std::fmt;

use serde::Deserializer;
use serde::de::{DeserializeSeed, Error, Visitor};

/// Something that has a name.
pub trait Named {
    /// Its name.
    fn name(&self) -> &str;
}

/// Which fields have been read. Mostly they come in declared order, and then a number says it.
#[derive(Debug, Default)]
pub struct Seen {
    in_order: usize,
    others: Vec<bool>,
}

impl Seen {
    /// Adds one of `count` fields, and says whether it wasn't there yet.
    pub fn insert(&mut self, index: usize, count: usize) -> bool {
        if self.contains(index) {
            return false;
        }
        if index == self.in_order {
            self.in_order += 1;
        } else {
            self.others.resize(count, false);
            self.others[index] = true;
        }
        true
    }

    /// Whether a field has been read.
    pub fn contains(&self, index: usize) -> bool {
        index < self.in_order || self.others.get(index).is_some_and(|seen| *seen)
    }
}

/// Reads a key as the index of the field that it names.
#[derive(Debug)]
pub struct KeySeed<'f, F> {
    /// The fields.
    pub fields: &'f [F],
    /// The field that is looked at first.
    pub guess: usize,
}

impl<'de, F: Named> DeserializeSeed<'de> for KeySeed<'_, F> {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl<F: Named> Visitor<'_> for KeySeed<'_, F> {
    type Value = usize;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("the name of a field")
    }

    fn visit_str<E: Error>(self, key: &str) -> Result<usize, E> {
        if self.fields.get(self.guess).is_some_and(|field| field.name() == key) {
            return Ok(self.guess);
        }
        let found = self.fields.iter().position(|field| field.name() == key);
        found.ok_or_else(|| E::custom(format_args!("unknown field `{key}`")))
    }
}
