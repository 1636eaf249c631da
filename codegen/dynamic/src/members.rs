//! JSON object members with known names. Each key is read as an index, and duplicates are detected.
//!
//! ```
//! use serde::de::DeserializeSeed as _;
//! use uavspec_dynamic::members::{KeySeed, Named};
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

/// A named item.
pub trait Named {
    /// Name of the item.
    fn name(&self) -> &str;
}

/// The set of fields that have been read. Fields that are read in declaration order need only a counter.
#[derive(Debug, Default)]
pub struct Seen {
    in_order: usize,
    others: Vec<bool>,
}

impl Seen {
    /// Marks the field with this `index` as read; the message has `count` fields. Returns false if it is already
    /// marked.
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

    /// True if the field has been read.
    pub fn contains(&self, index: usize) -> bool {
        index < self.in_order || self.others.get(index).is_some_and(|seen| *seen)
    }
}

/// Reads a key and returns the index of the field with this name.
#[derive(Debug)]
pub struct KeySeed<'f, F> {
    /// All fields.
    pub fields: &'f [F],
    /// Index of the field whose name is compared first.
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
