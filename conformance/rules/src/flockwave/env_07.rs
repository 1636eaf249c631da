//! `FW-ENV-07`.
//!
//! The specification sets no time limit, and a recording may end before the response arrives. A request is therefore
//! reported only under two conditions. First, no response arrives before the connection or the recording ends. Second,
//! the server still sends messages long after the request (`MAX_SECONDS`). A probe waits for the response and marks
//! the request as a test of this rule. If a request tests another rule, that rule checks the request.
//!
//! A server that is being shut down closes connections without a response. If the server closed a connection and has
//! answered the same request before, its behaviour therefore proves nothing; FW-ENV-27 reports messages that end the
//! service.

use std::collections::BTreeSet;

use uavspec_flockwave::session::SentRequest;

use super::prelude::*;
use super::{env_24, env_25};
use crate::limits::MAX_ANSWERED;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-07",
    name: "Every request gets a response",
    level: Level::Must,
    status: Status::Normative,
    statement: "Every request gets a response, even if the server does not know the type of the request.",
    source: source::GENERAL,
    applies_to: "requests over time",
    why: "A client waiting for the response blocks or times out. The client cannot distinguish an unknown \
          request from a dead connection.",
    example: r#"→ {"type":"UAV-SOAR","ids":["uav-1"]}
(40 s later, still no response)
← {"type":"OBJ-DEL","ids":["uav-2"]}"#,
    fix: "Answer every request. Send ACK-NAK with a reason if the type is unknown or no handler produces \
          a response.",
})
.checks(&[Check::Session(|| Box::new(Answered::default()))])
.bug(Bug::message("Requests of unknown types are not answered.", |out| {
    if out.refuses_unknown_type() {
        out.message = None;
    }
}))
.mutants(&[
    Mutant::new("a request without a response", || Some(Session::new().without("SYS-VER")?.to_bytes())),
    Mutant::connection("a probe request without a response", "tcp#9", |session| {
        session.tries(&RULE.rule, "", json!({ "type": "SYS-VER" }));
    }),
    Mutant::connection("a connection that the server closes instead of responding", "tcp#9", |session| {
        session.tries(&env_24::RULE.rule, "", json!({ "type": "RTK-SURVEY" }));
        session.closed("eof");
    }),
]);

/// The maximum time until a response, in seconds. If a server needs longer to process a request, it responds with a
/// receipt instead.
const MAX_SECONDS: f64 = 30.0;

/// The families with requests that may take long, although their responses can't have a receipt.
const SLOW: [&str; 3] = ["EXT-", "RTK-", "SHOW-"];

fn may_be_slow(type_name: &str) -> bool {
    SLOW.iter().any(|family| type_name.starts_with(family))
        && !["-INF", "-LIST"].iter().any(|end| type_name.ends_with(end))
}

/// The type, the objects and the filter of a request.
type Key = (Option<String>, Option<BTreeSet<String>>, Option<BTreeSet<String>>);

/// The requests that the server has answered on any connection.
#[derive(Default)]
struct Answered(BTreeSet<Key>);

impl SessionCheck for Answered {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        let Some(request) = &exchange.request else { return };
        let is_closed_by_server = exchange.record.note.is_some_and(|note| note != "client");
        let is_shut_down = exchange.role == Role::Unanswered
            && is_closed_by_server
            && request.trial.is_some()
            && request.failure.is_none();
        if !(is_shut_down && self.0.contains(&key(request))) {
            check(exchange, request, context);
        }
        if exchange.role == Role::Response && exchange.is_from_server() && self.0.len() < MAX_ANSWERED {
            self.0.insert(key(request));
        }
    }
}

fn key(request: &SentRequest) -> Key {
    (request.type_name.clone(), request.objects.clone(), request.filter.clone())
}

fn check(exchange: &Exchange<'_>, request: &SentRequest, context: &mut RuleContext<'_>) {
    let connection = exchange.record.connection;
    // A malformed request doesn't require a response.
    if !request.is_sound || connection.is_lossy {
        return;
    }
    if let Some((tested, _)) = &request.trial {
        // If a request tests another rule, that rule checks it. FW-ENV-24 and FW-ENV-25 are exceptions, because they
        // check only responses.
        if [RULE.rule.id, env_24::RULE.rule.id].contains(&tested.id) {
            served::tried_as(tested, exchange, context, |detail| detail);
        }
        if tested.id != env_25::RULE.rule.id {
            return;
        }
    }
    if !connection.is_ordered {
        return;
    }
    if exchange.role == Role::Response {
        return context.covered();
    }
    let subject = request.type_name.as_deref().unwrap_or("message");
    let is_late = |waited: &f64| *waited > MAX_SECONDS && !may_be_slow(subject);
    let Some(waited) = request.waited.filter(is_late).filter(|_| exchange.role == Role::Unanswered) else {
        return;
    };
    context.violation(subject, request.location, || {
        Detail::new(format!("no response within {waited:.0} s, although the server sent other messages"))
            .expected("a response")
            .actual("none")
    });
}
