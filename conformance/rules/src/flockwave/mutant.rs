//! Sessions that violate a rule: small changes to the conforming session.
//!
//! Most changes are function pointers, so that the compiler doesn't copy the functions for each change.

use serde_json::{Value, json};
use uavspec_model::Rule;

use super::sample::Session;

/// The conforming session with a changed body in the first response of this type.
pub(super) fn reply(type_name: &str, change: fn(&mut Value)) -> Option<Vec<u8>> {
    Some(Session::new().reply(type_name, change)?.to_bytes())
}

/// The conforming session with a changed envelope in the first response of this type.
pub(super) fn reply_message(type_name: &str, change: fn(&mut Value)) -> Option<Vec<u8>> {
    Some(Session::new().reply_message(type_name, change)?.to_bytes())
}

/// The conforming session with a changed body in the first notification of this type.
pub(super) fn notice(type_name: &str, change: fn(&mut Value)) -> Option<Vec<u8>> {
    Some(Session::new().notice(type_name, change)?.to_bytes())
}

/// The conforming session with a changed UAV state in the last status report.
pub(super) fn state(change: impl FnOnce(&mut Value)) -> Option<Vec<u8>> {
    Some(Session::new().state(change)?.to_bytes())
}

/// The conforming session with these error codes in a UAV state of the last status report.
pub(super) fn errors(codes: &[i64]) -> Option<Vec<u8>> {
    Some(Session::new().errors(codes)?.to_bytes())
}

/// The conforming session with additional records on another connection.
#[allow(clippy::unnecessary_wraps)] // like all mutants
pub(super) fn over(connection: &'static str, add: impl FnOnce(&mut Session)) -> Option<Vec<u8>> {
    Some(Session::new().then(|session| session.over(connection, add)).to_bytes())
}

/// The conforming session with additional records before its end.
#[allow(clippy::unnecessary_wraps)] // like all mutants
pub(super) fn then(add: impl FnOnce(&mut Session)) -> Option<Vec<u8>> {
    Some(Session::new().then(add).to_bytes())
}

/// The conforming session, extended by a trial of a rule in which the server does not respond.
pub(super) fn unanswered(connection: &'static str, rule: &Rule) -> Option<Vec<u8>> {
    over(connection, |session| {
        session.tries(rule, "without a response", json!({ "type": "SYS-PING" }));
    })
}

/// The conforming session, extended by a trial of a rule in which the server refuses the request.
pub(super) fn refused(connection: &'static str, rule: &Rule) -> Option<Vec<u8>> {
    let refusal = json!({ "type": "ACK-NAK", "reason": "Too windy" });
    over(connection, |session| {
        session.tries_and_receives(rule, "refused", json!({ "type": "SYS-PING" }), refusal);
    })
}

/// Removes a member of an object.
pub(super) fn remove(object: &mut Value, key: &str) {
    object.as_object_mut().and_then(|object| object.remove(key));
}
