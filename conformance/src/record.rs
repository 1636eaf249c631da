//! What rules see: the records of a source, wherever that is.

use std::fmt;

use serde::Serialize;
use uavspec_codegen::dynamic::DynamicView;
use uavspec_codegen::schema::MessageId;

use crate::json::Tree;
use crate::rule::Rule;

/// Where in its source a record stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// At a byte, from 0.
    Byte(u64),
    /// In a line, from 1.
    Line(u64),
}

impl fmt::Display for Place {
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
    BrokenOff,
}

/// A number with its thousands apart: 1,234,567.
pub(crate) struct Grouped(pub(crate) u64);

impl fmt::Display for Grouped {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = self.0.to_string();
        for (at, digit) in digits.chars().enumerate() {
            if at > 0 && (digits.len() - at).is_multiple_of(3) {
                formatter.write_str(",")?;
            }
            write!(formatter, "{digit}")?;
        }
        Ok(())
    }
}

/// A stream of messages of one type: a subscription of a log, a topic of a capture.
#[derive(Clone, Copy, Debug)]
pub struct Channel<'c> {
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
    pub place: Place,
}

/// A message on a channel.
#[derive(Clone, Copy, Debug)]
pub struct Message<'m> {
    /// Its field `timestamp`, in µs since system start.
    pub timestamp: Option<u64>,
    /// Its fields, where a rule wants them ([`Interest::Values`](crate::rule::Interest)) and they can be read.
    pub values: Option<DynamicView<'m>>,
    /// Where it stands.
    pub place: Place,
}

/// A connection between a client and a server of Flockwave.
#[derive(Clone, Copy, Debug)]
pub struct Connection<'c> {
    /// Its number in its source, from 0 in order of appearance.
    pub index: usize,
    /// Its name.
    pub name: &'c str,
    /// Whether messages come one after the other as they were sent, on the connection that is said. Otherwise nothing
    /// is certain that depends on what went over it before: the source doesn't tell connections apart, and all
    /// messages are taken to belong to one; or it is UDP, where some get lost, come twice or change places.
    pub is_told: bool,
}

/// Which way something goes, seen from the client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From the server to the client.
    In,
    /// From the client to the server.
    Out,
    /// Neither: something happens to the connection.
    Event,
}

/// What a client tries a server with: an exchange that is there to see whether a rule holds.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'e> {
    /// The rule.
    pub rule: &'static Rule,
    /// How it is tried: how the exchange comes about, or what goes before it. May be empty.
    pub how: &'e str,
}

/// Something that goes over a connection of Flockwave, or happens to it.
#[derive(Clone, Copy, Debug)]
pub struct Exchange<'e> {
    /// Where it goes.
    pub connection: Connection<'e>,
    /// Which way.
    pub direction: Direction,
    /// When, in seconds since the epoch by the clock of the client, where that is known.
    pub time: Option<f64>,
    /// The message as it is written; of an event, its name.
    pub text: &'e str,
    /// The message, where it can be read as JSON.
    pub value: Option<&'e Tree<'e>>,
    /// What is tried with it.
    pub trial: Option<Trial<'e>>,
    /// What the source says more of an event: of the beginning of a connection, where the server is, as a URL; of its
    /// end, and of a connection that doesn't come about, why.
    pub note: Option<&'e str>,
    /// Where it stands.
    pub place: Place,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_read_easily() {
        assert_eq!(Place::Byte(401_220).to_string(), "byte 401,220");
        assert_eq!(Place::Line(7).to_string(), "line 7");
        assert_eq!(Place::Byte(1_000_000).to_string(), "byte 1,000,000");
    }
}
