//! The records of a capture, in the form that rules receive.

use std::fmt;

use serde::Serialize;
use uavspec_dynamic::DynamicView;
use uavspec_schema::MessageId;

use super::SubjectName;
use crate::text::thousands;

/// The location of a record in its capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Location {
    /// A byte offset, from 0.
    Byte(u64),
    /// A line number, from 1.
    Line(u64),
    /// The number of a message in a bag, from 1, in the order of reading. Compressed chunks and databases have no byte
    /// offset for a message.
    #[serde(rename = "message_number")]
    Message(u64),
    /// The id of a channel in a bag.
    Channel(u64),
    /// The number of an announcement of a publisher or subscriber, from 1, in the order of discovery.
    Endpoint(u64),
}

impl fmt::Display for Location {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Byte(offset) => write!(formatter, "byte {}", thousands(offset)),
            Self::Line(line) => write!(formatter, "line {}", thousands(line)),
            Self::Message(number) => write!(formatter, "message {}", thousands(number)),
            Self::Channel(id) => write!(formatter, "channel {id}"),
            Self::Endpoint(number) => write!(formatter, "endpoint {}", thousands(number)),
        }
    }
}

/// The extent to which a capture is readable, from best to worst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Extent {
    /// The whole capture.
    #[default]
    Whole,
    /// All bytes were read, but the file is truncated within a record.
    #[serde(rename = "truncated")]
    EndsEarly,
    /// Some parts are corrupt. They were skipped if they can't be read.
    #[serde(rename = "corrupt")]
    WithGaps,
    /// Reading or decompressing failed before the end.
    Unreadable,
}

/// A stream of messages of one type: a subscription in a log, or a topic in any other capture.
#[derive(Clone, Copy, Debug)]
pub struct Channel<'c> {
    /// The number of the channel in its capture. If a new channel replaces an old one, the new channel reuses the
    /// number.
    pub index: usize,
    /// The topic.
    pub topic: &'c str,
    /// The topic with its namespace, such as `/uav_1/fmu/out/vehicle_status`, if the format distinguishes namespaces.
    pub full_topic: &'c str,
    /// The instance of the topic, counted from 0, if the format distinguishes instances.
    pub multi_id: Option<u8>,
    /// The definition of the messages, if known.
    pub definition: Option<MessageId>,
    /// The version of the messages, if the capture contains it. Otherwise, the definition's version applies.
    pub version: Option<u32>,
    /// The location where the channel was opened.
    pub location: Location,
}

impl<'c> Channel<'c> {
    /// The topic as the subject of findings.
    pub fn subject(&self) -> SubjectName<'c> {
        SubjectName { name: self.full_topic, instance: self.multi_id }
    }
}

/// A message on a channel.
#[derive(Clone, Copy, Debug)]
pub struct Message<'m> {
    /// The `timestamp` field, in µs since boot.
    pub timestamp: Option<u64>,
    /// The time at which a bag recorded the message, in µs since 1970, if it is known.
    pub logged: Option<u64>,
    /// The fields, if a rule needs them (`Interest::Values`) and they can be read.
    pub values: Option<DynamicView<'m>>,
    /// The location of the message.
    pub location: Location,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locations_have_grouped_digits() {
        assert_eq!(Location::Byte(401_220).to_string(), "byte 401,220");
        assert_eq!(Location::Line(7).to_string(), "line 7");
        assert_eq!(Location::Message(1_234).to_string(), "message 1,234");
        assert_eq!(Location::Channel(1_234).to_string(), "channel 1234");
        assert_eq!(Location::Endpoint(1_234).to_string(), "endpoint 1,234");
        assert_eq!(Location::Byte(1_000_000).to_string(), "byte 1,000,000");
    }
}
