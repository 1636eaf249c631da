//! The records of a session: messages between a client and a server, and events of their connections.

use crate::json::Tree;
use crate::model::{Location, Rule};

/// A connection between a client and a server of Flockwave.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Connection<'c> {
    /// Its number in its source, from 0 in order of appearance.
    pub index: usize,
    /// Its name.
    pub name: &'c str,
    /// Whether messages come one after the other as they were sent, on the connection that is said. Otherwise nothing
    /// is certain that depends on what went over it before: the source doesn't tell connections apart, and all
    /// messages are taken to belong to one; or it is UDP, where some get lost, come twice or change places.
    pub is_ordered: bool,
}

/// Which way something goes, seen from the client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    /// From the server to the client.
    In,
    /// From the client to the server.
    Out,
    /// Neither: something happens to the connection.
    Event,
}

/// What a client tries a server with: a record that is there to see whether a rule holds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trial<'e> {
    /// The rule.
    pub rule: &'static Rule,
    /// How it is tried: how the record comes about, or what goes before it. May be empty.
    pub how: &'e str,
}

/// Something that goes over a connection of Flockwave, or happens to it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SessionRecord<'e> {
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
    pub location: Location,
}
