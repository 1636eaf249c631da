//! What the rules on Flockwave (`FW-…`) have in common. They are about servers: what clients send is only followed.
//!
//! Some show only where someone tries them ([`tried`]). `FW-ERR-05`, on the severity of error codes, isn't among them: what
//! severity a code has isn't sent, and is asked of codecs (`severity` of the testee protocol).

mod lines;
mod per_connection;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet, HashSet};

use crate::flockwave::session::parts;
use serde_json::{Value, json};

pub(super) use self::lines::{Lines, are_several, is_called};
pub(super) use self::per_connection::PerConnection;
pub(super) use crate::flockwave::body_schema::Shape;
use crate::flockwave::body_schema::{Deviation, Mismatch, integer};
pub(super) use crate::flockwave::session::{Exchange, OPERATIONS, Reference, Role};
pub(super) use crate::json::Tree;
use crate::json::pointer;
pub(super) use crate::rules::sample::Session;

use super::{Detail, Rule, RuleContext};

pub(super) const GENERAL: &str = "Flockwave 2.10, general remarks on messages";
pub(super) const SCHEMA: &str = "Flockwave 2.10, published JSON Schema";
pub(super) const TRANSPORT: &str = "Flockwave 2.10, transport";
pub(super) const TYPES: &str = "Flockwave 2.10, types";
pub(super) const ERRORS: &str = "Flockwave 2.10, error codes";
pub(super) const ASYNC: &str = "Flockwave 2.10, asynchronous operations";
pub(super) const MESSAGES: &str = "Flockwave 2.10, the chapter on the message";
pub(super) const DERIVED: &str = "derived from Flockwave 2.10";

/// How much of something is quoted, in characters.
const MAX_QUOTED: usize = 64;

/// How much room the ids of a list may take that are followed, in bytes: those of a fleet of ten thousand fit.
const MAX_LISTED: usize = 1 << 19;

/// What an id takes beside its text, in bytes; a rough guess.
const OVERHEAD: usize = 40;

/// The longest id that is followed, in bytes: 64 characters of up to four.
const MAX_ID: usize = 256;

/// How many objects are told that aren't where they should be.
const MAX_TOLD: usize = 4;

/// Something has another shape than it should, here in the message.
pub(super) fn mismatched(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, found: Mismatch) {
    exchange.breaks(context, || {
        let Mismatch { path, expected, actual } = found;
        Detail::differs(expected, actual).at(path)
    });
}

/// A field of the body has this shape; it may be left out where it isn't required.
pub(super) fn field(
    exchange: &Exchange<'_>,
    context: &mut RuleContext<'_>,
    name: &str,
    is_required: bool,
    shape: &Shape,
) {
    member(exchange, context, exchange.body, &["body"], (name, is_required), shape);
}

/// A member of something at `keys` has this shape.
pub(super) fn member(
    exchange: &Exchange<'_>,
    context: &mut RuleContext<'_>,
    holder: Option<&Tree<'_>>,
    keys: &[&str],
    (name, is_required): (&str, bool),
    shape: &Shape,
) {
    let found = match holder.and_then(|holder| holder.get(name)) {
        None if is_required => Some(Mismatch::new(shape.to_string(), "nothing")),
        None => return,
        Some(value) => shape.mismatch(value),
    };
    context.covered();
    if let Some(found) = found {
        let path = pointer(keys) + &pointer(&[name]) + &found.path;
        mismatched(exchange, context, Mismatch { path, ..found });
    }
}

impl Exchange<'_> {
    /// Something in it breaks a rule.
    pub(super) fn breaks(&self, context: &mut RuleContext<'_>, detail: impl FnOnce() -> Detail) {
        context.violation(&self.subject(), self.record.place, || detail().excerpt(self.excerpt()));
    }

    /// Its body deviates from its definition, and so breaks a rule on `subject`.
    pub(super) fn deviates(&self, context: &mut RuleContext<'_>, subject: &str, deviation: &Deviation) {
        context.violation_of(subject, self.record.place, deviation.definition, || {
            let Mismatch { path, expected, actual } = &deviation.mismatch;
            Detail::differs(expected, actual).at(path).excerpt(self.excerpt())
        });
    }
}

/// The members of a field of the body that is an object.
pub(super) fn members<'t>(exchange: &Exchange<'t>, name: &str) -> &'t [(Cow<'t, str>, Tree<'t>)] {
    match exchange.field(name) {
        Some(Tree::Object(members)) => members,
        _ => &[],
    }
}

/// The members of what a server says of the state of each object of a type.
pub(super) fn states<'t>(exchange: &Exchange<'t>, type_name: &str) -> &'t [(Cow<'t, str>, Tree<'t>)] {
    if exchange.body_of(type_name).is_some() { members(exchange, "status") } else { &[] }
}

/// A text as it is quoted.
pub(super) fn quoted(text: &str) -> String {
    let short: String = text.chars().take(MAX_QUOTED).collect();
    let more = if short.len() < text.len() { "…" } else { "" };
    format!("`{short}{more}`")
}

/// Each object that was asked for stands in exactly one part of the reply, if it is of one of these types.
pub(super) fn partition(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, types: &[&str]) {
    let Some((asked, parts)) = replied(exchange, types) else { return };
    context.covered();
    let mut found: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for part in parts {
        for object in named(exchange, part).filter(|object| asked.contains(*object)) {
            let stands = found.entry(object).or_default();
            if stands.last() != Some(part) {
                stands.push(part);
            }
        }
    }
    let stands = |object: &String| found.get(object.as_str()).cloned().unwrap_or_default();
    let wrong = asked.iter().map(|object| (object, stands(object))).filter(|(_, stands)| stands.len() != 1);
    let wrong: Vec<(&String, Vec<&str>)> = wrong.collect();
    if !wrong.is_empty() {
        exchange.breaks(context, || {
            let told = wrong.iter().take(MAX_TOLD).map(|(object, found)| match found.len() {
                0 => format!("{} in none", quoted(object)),
                _ => format!("{} in {}", quoted(object), found.join(" and ")),
            });
            let mut told: Vec<String> = told.collect();
            if wrong.len() > MAX_TOLD {
                told.push(format!("{} more", wrong.len() - MAX_TOLD));
            }
            let told = told.join(", ");
            Detail::new(format!(
                "of what was asked for, there is {told}; expected each in exactly one of {}",
                parts.join(", ")
            ))
            .at("/body")
            .expected(format!("each in exactly one of {}", parts.join(", ")))
            .actual(told)
        });
    }
}

/// The reply tells of nothing that wasn't asked for, if it is of one of these types.
pub(super) fn strangers(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, types: &[&str]) {
    let Some((asked, parts)) = replied(exchange, types) else { return };
    context.covered();
    let stranger = parts.iter().find_map(|part| {
        let (key, _) = members(exchange, part).iter().find(|(key, _)| !asked.contains(key.as_ref()))?;
        Some((*part, key))
    });
    if let Some((part, key)) = stranger {
        exchange.breaks(context, || {
            Detail::new(format!("{} wasn't asked for", quoted(key))).at(pointer(&["body", part, key]))
        });
    }
}

/// What was asked for, and the parts of a reply that tell about it.
fn replied<'u>(
    exchange: &'u Exchange<'_>,
    types: &[&str],
) -> Option<(&'u BTreeSet<String>, &'static [&'static str])> {
    let name = exchange.type_name.filter(|name| exchange.response(name).is_some() && types.contains(name))?;
    let asked = exchange.asked_same()?.objects.as_ref()?;
    Some((asked, parts(name)?.told))
}

/// What a part of a reply names: the keys of a map, or the strings of a list.
fn named<'t>(exchange: &Exchange<'t>, part: &str) -> impl Iterator<Item = &'t str> {
    let (members, values) = match exchange.field(part) {
        Some(Tree::Object(members)) => (&members[..], &[][..]),
        Some(Tree::List(values)) => (&[][..], &values[..]),
        _ => (&[][..], &[][..]),
    };
    members.iter().map(|(key, _)| key.as_ref()).chain(values.iter().filter_map(Tree::as_str))
}

/// Each object's key in the map is its id.
pub(super) fn keyed(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, type_name: &str) {
    for (key, state) in states(exchange, type_name) {
        context.covered();
        let id = state.get("id");
        // That there is an id, and a string, is another rule's matter.
        if let Some(id) = id.and_then(Tree::as_str).filter(|id| id != key) {
            exchange.breaks(context, || {
                Detail::differs(quoted(key), quoted(id)).at(pointer(&["body", "status", key, "id"]))
            });
        }
    }
}

/// No value of a list stands there twice.
pub(super) fn unique(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, name: &str) {
    let Some(Tree::List(values)) = exchange.field(name) else { return };
    context.covered();
    let mut seen = HashSet::new();
    let repeated = values.iter().filter_map(Tree::as_str).find(|text| !seen.insert(*text));
    if let Some(text) = repeated {
        exchange.breaks(context, || {
            Detail::new(format!("{} stands there twice", quoted(text))).at(pointer(&["body", name]))
        });
    }
}

/// Asks of each list of error codes what is wrong with it. What is no integer is another rule's matter.
pub(super) fn codes(
    exchange: &Exchange<'_>,
    context: &mut RuleContext<'_>,
    wrong: impl Fn(&[i128]) -> Option<String>,
) {
    for (uav, state) in states(exchange, "UAV-INF") {
        let Some(Tree::List(values)) = state.get("errors") else { continue };
        let codes: Vec<i128> = values.iter().filter_map(integer).collect();
        context.covered();
        if let Some(message) = wrong(&codes) {
            exchange.breaks(context, || {
                let told: Vec<String> = codes.iter().take(16).map(ToString::to_string).collect();
                let path = pointer(&["body", "status", uav, "errors"]);
                Detail::new(message).at(path).actual(format!("[{}]", told.join(", ")))
            });
        }
    }
}

/// Whether something is there, and not null: members that are optional may be null, by the advice to the authors of
/// the specification.
pub(super) fn is_there(value: Option<&Tree<'_>>) -> bool {
    value.is_some_and(|value| *value != Tree::Null)
}

/// Exactly one of the members of a body is there. A null among them counts only where nothing else does, and only if
/// null may be what it says.
pub(super) fn exactly_one(
    exchange: &Exchange<'_>,
    context: &mut RuleContext<'_>,
    names: &[&str],
    may_be_null: &str,
) {
    context.covered();
    let mut found: Vec<&str> = names.iter().copied().filter(|name| is_there(exchange.field(name))).collect();
    if found.is_empty() && exchange.field(may_be_null) == Some(&Tree::Null) {
        found.push(may_be_null);
    }
    if found.len() != 1 {
        exchange.breaks(context, || {
            let found = if found.is_empty() { "none".to_owned() } else { found.join(" and ") };
            Detail::differs(format!("exactly one of {}", names.join(", ")), found).at("/body")
        });
    }
}

/// Whether this is the response to a request that tries the rule. That there is none breaks it, and so does a connection
/// that didn't come about. Of a recording that doesn't show how the connection ended, nobody knows what was to come; nor
/// what was lost, where messages may be.
pub(super) fn tried(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) -> bool {
    let Some(how) = exchange.tried(context.rule) else { return false };
    let (what, actual) = match exchange.role {
        Role::Response => {
            context.covered();
            return true;
        }
        Role::Unanswered if is_over(exchange) => ("no response", "none"),
        Role::Event if exchange.record.text == "refused" => ("no connection", "none"),
        _ => return false,
    };
    context.covered();
    unserved(exchange, context, what, actual, how);
    false
}

/// Whether all that answered a request would be known.
fn is_over(exchange: &Exchange<'_>) -> bool {
    exchange.record.note.is_some() && exchange.record.connection.is_told
}

/// A request that tries the rule, or the connection for it, comes to nothing. Of `how` it is tried, what stands before
/// the first colon is the subject: what is tried in several ways is one weakness.
fn unserved(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, what: &str, actual: &str, how: &str) {
    let type_name = exchange.asked.as_ref().and_then(|asked| asked.type_name.as_deref());
    let (way, kind) = how.split_once(": ").unwrap_or((how, ""));
    let subject = if way.is_empty() { type_name.unwrap_or("message") } else { way };
    context.violation(subject, exchange.record.place, || {
        let why = match exchange.record.note {
            // The client itself gave up.
            None | Some("client") => String::new(),
            Some("eof") => "; the server closed the connection".to_owned(),
            Some(why) => format!("; {}", quoted(why)),
        };
        let of = type_name.map_or_else(String::new, |name| format!(" to {}", quoted(name)));
        let kind = if kind.is_empty() { String::new() } else { format!(" ({kind})") };
        Detail::new(format!("{what}{of}{kind}{why}")).expected("a response").actual(actual)
    });
}

/// Whether this is the response to a request that tries the rule, and that was served. That it wasn't breaks the rule.
pub(super) fn served(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) -> bool {
    if !tried(exchange, context) {
        return false;
    }
    let Some((actual, reason)) = refusal(exchange) else { return true };
    let way =
        exchange.tried(context.rule).and_then(|how| how.split(": ").next()).filter(|way| !way.is_empty());
    context.violation(way.unwrap_or(actual), exchange.record.place, || {
        Detail::new(match reason {
            Some(reason) => format!("refused: {}", quoted(reason)),
            None => "refused".to_owned(),
        })
        .expected("what was asked for")
        .actual(actual)
    });
    false
}

/// What a response refuses a request with, and the reason that it gives.
fn refusal<'t>(exchange: &Exchange<'t>) -> Option<(&'static str, Option<&'t str>)> {
    if exchange.type_name == Some("ACK-NAK") {
        return Some(("ACK-NAK", exchange.field("reason").and_then(Tree::as_str)));
    }
    let error =
        exchange.message()?.get("error").filter(|error| **error != Tree::Null && exchange.body.is_none())?;
    Some(("an error", error.get("message").and_then(Tree::as_str)))
}

/// A request that tries the rule has an entry in `error` for what nobody knows or can do. Of what is asked for, and stands
/// nowhere in the reply, other rules tell.
pub(super) fn in_error(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, types: &[&str]) {
    if !served(exchange, context) {
        return;
    }
    let Some((asked, parts)) = replied(exchange, types) else { return };
    let stands = |object: &str, part: &str| named(exchange, part).any(|named| named == object);
    let is_told = |object: &String| parts.iter().any(|part| stands(object, part));
    let wrong = asked.first().filter(|_| asked.iter().all(is_told));
    if let Some(object) = wrong.filter(|_| !asked.iter().any(|object| stands(object, "error"))) {
        exchange.breaks(context, || {
            Detail::new(format!("{} has no entry in `error`", quoted(object)))
                .at("/body")
                .expected("an entry in `error`")
                .actual("none")
        });
    }
}

/// The ids of a list, where it is one of strings, and not too long to be followed.
pub(super) fn listed(exchange: &Exchange<'_>) -> Option<BTreeSet<String>> {
    let Some(Tree::List(values)) = exchange.field("ids").filter(|_| exchange.role != Role::Unanswered) else {
        return None;
    };
    let mut room = MAX_LISTED;
    let id = |value: &Tree<'_>| {
        let id = value.as_str().filter(|id| id.len() <= MAX_ID)?;
        room = room.checked_sub(id.len() + OVERHEAD)?;
        Some(id.to_owned())
    };
    values.iter().map(id).collect()
}

/// Whether replies of a type may have receipts.
pub(super) fn gives_receipts(name: &str) -> bool {
    name == "LOG-DATA" || OPERATIONS.contains(&name)
}

/// Whether a text is one to three numbers with dots between them.
pub(super) fn is_version(text: &str) -> bool {
    let mut parts = text.split('.');
    let is_number = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    parts.by_ref().take(3).all(is_number) && parts.next().is_none()
}

/// Whether it is a response of the server, and what its `refs` name is known for certain.
pub(super) fn refers(exchange: &Exchange<'_>) -> bool {
    let is_response = exchange.role == Role::Response && exchange.is_of_server();
    is_response && exchange.record.connection.is_told && exchange.reference != Reference::Unclear
}

/// The session that conforms, with another body of the first response of this type.
pub(super) fn reply(type_name: &str, change: impl FnOnce(&mut Value)) -> Option<Vec<u8>> {
    Some(Session::new().reply(type_name, change)?.to_bytes())
}

/// The same, with another envelope.
pub(super) fn reply_message(type_name: &str, change: impl FnOnce(&mut Value)) -> Option<Vec<u8>> {
    Some(Session::new().reply_message(type_name, change)?.to_bytes())
}

/// The same, with another body of the first notification of this type.
pub(super) fn notice(type_name: &str, change: impl FnOnce(&mut Value)) -> Option<Vec<u8>> {
    Some(Session::new().notice(type_name, change)?.to_bytes())
}

/// The same, with another state of a glider in the last report.
pub(super) fn state(change: impl FnOnce(&mut Value)) -> Option<Vec<u8>> {
    Some(Session::new().state(change)?.to_bytes())
}

/// The same, with other error codes in that state.
pub(super) fn errors(codes: &[i64]) -> Option<Vec<u8>> {
    Some(Session::new().errors(codes)?.to_bytes())
}

/// The same, with another connection, over which this is said.
#[allow(clippy::unnecessary_wraps)] // as all mutants
pub(super) fn over(connection: &'static str, say: impl FnOnce(&mut Session)) -> Option<Vec<u8>> {
    Some(Session::new().then(|session| session.over(connection, say)).to_bytes())
}

/// The same, with more that is said before it ends.
#[allow(clippy::unnecessary_wraps)] // as all mutants
pub(super) fn then(say: impl FnOnce(&mut Session)) -> Option<Vec<u8>> {
    Some(Session::new().then(say).to_bytes())
}

/// The same, with a trial of a rule that gets no answer.
pub(super) fn unanswered(connection: &'static str, rule: &Rule) -> Option<Vec<u8>> {
    over(connection, |session| {
        session.tries(rule, "without an answer", json!({ "type": "SYS-PING" }));
    })
}

/// The same, with a trial of a rule that is refused.
pub(super) fn refused(connection: &'static str, rule: &Rule) -> Option<Vec<u8>> {
    let no = json!({ "type": "ACK-NAK", "reason": "Too windy" });
    over(connection, |session| session.tries_and_hears(rule, "refused", json!({ "type": "SYS-PING" }), no))
}

/// Takes a member out of an object.
pub(super) fn remove(object: &mut Value, key: &str) {
    object.as_object_mut().and_then(|object| object.remove(key));
}
