//! What rules see: the records of a source, wherever that is.

use std::fmt;

use serde::Serialize;
use uavspec_codegen::dynamic::DynamicView;
use uavspec_codegen::schema::MessageId;

use crate::text::Grouped;

/// Where in its source a record stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Location {
    /// At a byte, from 0.
    Byte(u64),
    /// In a line, from 1.
    Line(u64),
}

impl fmt::Display for Location {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Byte(offset) => write!(formatter, "byte {}", Grouped(*offset)),
            Self::Line(line) => write!(formatter, "line {}", Grouped(*line)),
        }
    }
}

/// How much of a source could be read, from the best to the worst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Extent {
    /// All of it.
    #[default]
    Whole,
    /// All that is there, but it ends within something.
    #[serde(rename = "ends early")]
    EndsEarly,
    /// Not all: parts of it were passed over.
    #[serde(rename = "with gaps")]
    WithGaps,
    /// Not to its end: reading or unpacking it failed.
    #[serde(rename = "broken off")]
    Unreadable,
}

/// A stream of messages of one type: a subscription of a log, a topic of a capture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Channel<'c> {
    /// Its number in its source. A channel that is opened anew in the place of another has that one's.
    pub index: usize,
    /// The topic.
    pub topic: &'c str,
    /// The instance of the topic, from 0, where the source tells instances apart.
    pub multi_id: Option<u8>,
    /// The definition of its messages, where there is one.
    pub definition: Option<MessageId>,
    /// The version that its messages have, where the source itself says that; otherwise it is that of the definition.
    pub version: Option<u32>,
    /// Where it was opened.
    pub location: Location,
}

/// A message on a channel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Message<'m> {
    /// Its field `timestamp`, in µs since system start.
    pub timestamp: Option<u64>,
    /// Its fields, where a rule wants them (`Interest::Values`) and they can be read.
    pub values: Option<DynamicView<'m>>,
    /// Where it stands.
    pub location: Location,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_read_easily() {
        assert_eq!(Location::Byte(401_220).to_string(), "byte 401,220");
        assert_eq!(Location::Line(7).to_string(), "line 7");
        assert_eq!(Location::Byte(1_000_000).to_string(), "byte 1,000,000");
    }
}
