//! The records of a session: messages between a client and a server, and connection events.

use uavspec_model::json::Tree;
use uavspec_model::{Location, Rule};

/// A connection between a Flockwave client and a server.
#[derive(Clone, Copy, Debug)]
pub struct Connection<'c> {
    /// The index in the capture, from 0 in order of appearance.
    pub index: usize,
    /// The name.
    pub name: &'c str,
    /// True if messages arrive in the order in which they were sent, and each message's connection is known. False for
    /// UDP, which may lose, repeat or reorder messages. Also false if the capture doesn't distinguish connections.
    /// Checks that depend on earlier messages are then uncertain.
    pub is_ordered: bool,
    /// True if messages may be lost, so a missing answer proves nothing. True for UDP, and if the capture doesn't
    /// distinguish connections. False for HTTP, where each request has its own response.
    pub is_lossy: bool,
}

/// The direction of a record, from the client's point of view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From the server to the client.
    In,
    /// From the client to the server.
    Out,
    /// An event of the connection.
    Event,
}

/// The rule test to which a record belongs.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'e> {
    /// The rule.
    pub rule: &'static Rule,
    /// The description of the test: how the record was created, or what preceded it. May be empty.
    pub how: &'e str,
}

/// A message or an event of a connection.
#[derive(Clone, Copy, Debug)]
pub struct SessionRecord<'e> {
    /// The connection.
    pub connection: Connection<'e>,
    /// The direction.
    pub direction: Direction,
    /// The time in seconds since the epoch, by the client's clock, if it is known.
    pub time: Option<f64>,
    /// The text of the message, or the name of the event.
    pub text: &'e str,
    /// The message, if it is JSON.
    pub value: Option<&'e Tree<'e>>,
    /// The rule test to which the record belongs.
    pub trial: Option<Trial<'e>>,
    /// Details of an event. When a connection starts, the note is the server's URL. When a connection ends or fails,
    /// the note is the reason.
    pub note: Option<&'e str>,
    /// The location in the capture.
    pub location: Location,
}
