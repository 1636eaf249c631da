//! Mutants: small changes to the conforming session that violate a rule.
//!
//! Most changes are function pointers, so that the compiler doesn't copy the functions for each change.

use serde_json::{Value, json};
use uavspec_model::Rule;

use super::sample::Session;

/// A capture that violates a rule: the conforming session with a small change.
#[derive(Debug)]
pub(crate) struct Mutant {
    /// A description of the change.
    pub name: &'static str,
    /// The other rules that the capture violates.
    pub also: &'static [&'static Rule],
    change: Change,
}

/// A change to the conforming session.
#[derive(Debug)]
enum Change {
    /// Changes the body of the first response of this type.
    Reply(&'static str, fn(&mut Value)),
    /// Changes the envelope of the first response of this type.
    ReplyMessage(&'static str, fn(&mut Value)),
    /// Changes the body of the first notification of this type.
    Notice(&'static str, fn(&mut Value)),
    /// Changes a UAV state in the last status report.
    State(fn(&mut Value)),
    /// Sets the error codes of a UAV state in the last status report.
    Errors(&'static [i64]),
    /// Adds records before the end.
    Session(fn(&mut Session)),
    /// Adds records on another connection.
    Connection(&'static str, fn(&mut Session)),
    /// Adds a trial of the rule on a connection. The server doesn't respond.
    Unanswered(&'static str),
    /// Adds a trial of the rule on a connection. The server refuses the request.
    Refused(&'static str),
    /// Adds a trial of the rule. The server refuses the connection.
    NoConnection,
    /// Creates the capture.
    Capture(fn() -> Option<Vec<u8>>),
}

impl Mutant {
    /// Creates a mutant from a function that creates the capture.
    pub(super) const fn new(name: &'static str, make: fn() -> Option<Vec<u8>>) -> Self {
        Self::changing(name, Change::Capture(make))
    }

    /// Creates a mutant with a changed body in the first response of this type.
    pub(super) const fn reply(name: &'static str, type_name: &'static str, change: fn(&mut Value)) -> Self {
        Self::changing(name, Change::Reply(type_name, change))
    }

    /// Creates a mutant with a changed envelope in the first response of this type.
    pub(super) const fn reply_message(
        name: &'static str,
        type_name: &'static str,
        change: fn(&mut Value),
    ) -> Self {
        Self::changing(name, Change::ReplyMessage(type_name, change))
    }

    /// Creates a mutant with a changed body in the first notification of this type.
    pub(super) const fn notice(name: &'static str, type_name: &'static str, change: fn(&mut Value)) -> Self {
        Self::changing(name, Change::Notice(type_name, change))
    }

    /// Creates a mutant with a changed UAV state in the last status report.
    pub(super) const fn state(name: &'static str, change: fn(&mut Value)) -> Self {
        Self::changing(name, Change::State(change))
    }

    /// Creates a mutant with these error codes in a UAV state of the last status report.
    pub(super) const fn errors(name: &'static str, codes: &'static [i64]) -> Self {
        Self::changing(name, Change::Errors(codes))
    }

    /// Creates a mutant with additional records before the end of the session.
    pub(super) const fn session(name: &'static str, add: fn(&mut Session)) -> Self {
        Self::changing(name, Change::Session(add))
    }

    /// Creates a mutant with additional records on another connection, such as `tcp#9`.
    pub(super) const fn connection(
        name: &'static str,
        connection: &'static str,
        add: fn(&mut Session),
    ) -> Self {
        Self::changing(name, Change::Connection(connection, add))
    }

    /// Creates a mutant with a trial of the rule to which the server doesn't respond.
    pub(super) const fn unanswered(name: &'static str, connection: &'static str) -> Self {
        Self::changing(name, Change::Unanswered(connection))
    }

    /// Creates a mutant with a trial of the rule that the server refuses.
    pub(super) const fn refused(name: &'static str, connection: &'static str) -> Self {
        Self::changing(name, Change::Refused(connection))
    }

    /// Creates a mutant with a trial of the rule for which the server refuses the connection.
    pub(super) const fn no_connection(name: &'static str) -> Self {
        Self::changing(name, Change::NoConnection)
    }

    const fn changing(name: &'static str, change: Change) -> Self {
        Self { name, also: &[], change }
    }

    /// Sets the rules that the capture violates in addition to the mutant's own rule.
    pub(super) const fn also(self, also: &'static [&'static Rule]) -> Self {
        Self { also, ..self }
    }

    /// The capture, for the mutant's own rule. `None` if the conforming session lacks the message to change.
    pub(crate) fn capture(&self, rule: &Rule) -> Option<Vec<u8>> {
        let session = Session::new();
        let changed = match self.change {
            Change::Reply(type_name, change) => session.reply(type_name, change),
            Change::ReplyMessage(type_name, change) => session.reply_message(type_name, change),
            Change::Notice(type_name, change) => session.notice(type_name, change),
            Change::State(change) => session.state(change),
            Change::Errors(codes) => session.errors(codes),
            Change::Session(add) => Some(session.then(add)),
            Change::Connection(connection, add) => {
                Some(session.then(|session| session.over(connection, add)))
            }
            Change::Unanswered(connection) => Some(session.then(|session| {
                session.over(connection, |session| {
                    session.tries(rule, "without a response", json!({ "type": "SYS-PING" }));
                });
            })),
            Change::Refused(connection) => Some(session.then(|session| {
                session.over(connection, |session| {
                    let refusal = json!({ "type": "ACK-NAK", "reason": "Too windy" });
                    session.tries_and_receives(rule, "refused", json!({ "type": "SYS-PING" }), refusal);
                });
            })),
            Change::NoConnection => {
                Some(session.then(|session| session.refused(rule, "no connection", "Connection refused")))
            }
            Change::Capture(make) => return make(),
        };
        changed.map(|session| session.to_bytes())
    }
}

/// Removes a member of an object.
pub(super) fn remove(object: &mut Value, key: &str) {
    object.as_object_mut().and_then(|object| object.remove(key));
}
