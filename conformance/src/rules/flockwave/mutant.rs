//! Sessions that violate a rule: small changes of the one that conforms.

use serde_json::{Value, json};

use super::{Rule, Session};

/// The session that conforms, with another body of the first response of this type.
pub(super) fn reply(type_name: &str, change: impl FnOnce(&mut Value)) -> Option<Vec<u8>> {
    Some(Session::new().reply(type_name, change)?.to_bytes())
}

/// The session that conforms, with another envelope of that response.
pub(super) fn reply_message(type_name: &str, change: impl FnOnce(&mut Value)) -> Option<Vec<u8>> {
    Some(Session::new().reply_message(type_name, change)?.to_bytes())
}

/// The session that conforms, with another body of the first notification of this type.
pub(super) fn notice(type_name: &str, change: impl FnOnce(&mut Value)) -> Option<Vec<u8>> {
    Some(Session::new().notice(type_name, change)?.to_bytes())
}

/// The session that conforms, with another state of a glider in the last report.
pub(super) fn state(change: impl FnOnce(&mut Value)) -> Option<Vec<u8>> {
    Some(Session::new().state(change)?.to_bytes())
}

/// The session that conforms, with other error codes in that state.
pub(super) fn errors(codes: &[i64]) -> Option<Vec<u8>> {
    Some(Session::new().errors(codes)?.to_bytes())
}

/// The session that conforms, with these records over another connection.
#[allow(clippy::unnecessary_wraps)] // as all mutants
pub(super) fn over(connection: &'static str, say: impl FnOnce(&mut Session)) -> Option<Vec<u8>> {
    Some(Session::new().then(|session| session.over(connection, say)).to_bytes())
}

/// The session that conforms, with more records before its end.
#[allow(clippy::unnecessary_wraps)] // as all mutants
pub(super) fn then(say: impl FnOnce(&mut Session)) -> Option<Vec<u8>> {
    Some(Session::new().then(say).to_bytes())
}

/// The session that conforms, with a trial of a rule that gets no answer.
pub(super) fn unanswered(connection: &'static str, rule: &Rule) -> Option<Vec<u8>> {
    over(connection, |session| {
        session.tries(rule, "without an answer", json!({ "type": "SYS-PING" }));
    })
}

/// The session that conforms, with a trial of a rule that is refused.
pub(super) fn refused(connection: &'static str, rule: &Rule) -> Option<Vec<u8>> {
    let no = json!({ "type": "ACK-NAK", "reason": "Too windy" });
    over(connection, |session| session.tries_and_receives(rule, "refused", json!({ "type": "SYS-PING" }), no))
}

/// Removes a member of an object.
pub(super) fn remove(object: &mut Value, key: &str) {
    object.as_object_mut().and_then(|object| object.remove(key));
}
