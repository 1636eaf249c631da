//! Accepted deviations of JSON messages from the published schemas.

use std::fmt;

use serde::{Serialize, Serializer};

/// An accepted deviation of JSON messages from the published schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dialect {
    /// rosbridge writes `uint8` arrays, and therefore also `char[N]`, as base64.
    Base64,
    /// In ROS 2, `char` is `uint8`, so `char[N]` is an array of numbers.
    NumbersForText,
    /// Python's `json` writes NaN and infinity as tokens that aren't JSON.
    BareNan,
}

impl Dialect {
    /// All dialects.
    pub const ALL: [Self; 3] = [Self::Base64, Self::NumbersForText, Self::BareNan];
}

impl fmt::Display for Dialect {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Base64 => "base64 for arrays of uint8 (rosbridge)",
            Self::NumbersForText => "numbers for char[N] (ROS 2)",
            Self::BareNan => "bare NaN or Infinity (Python)",
        })
    }
}

/// The dialects of a capture; serialized as their names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, schemars::JsonSchema)]
pub struct Dialects(#[schemars(with = "Vec<String>")] u8);

impl Dialects {
    /// Adds a dialect.
    pub fn insert(&mut self, dialect: Dialect) {
        self.0 |= 1 << dialect as u8;
    }

    /// Adds all dialects of another set.
    pub fn absorb(&mut self, others: Self) {
        self.0 |= others.0;
    }

    /// The dialects in order.
    pub fn iter(self) -> impl Iterator<Item = Dialect> {
        Dialect::ALL.into_iter().filter(move |dialect| self.0 & 1 << *dialect as u8 != 0)
    }
}

impl Serialize for Dialects {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter().map(|dialect| dialect.to_string()))
    }
}
