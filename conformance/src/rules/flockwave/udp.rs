//! The check of requests over UDP that have to be served.
//!
//! Datagrams get lost. So a trial has failed where none of its requests got an answer until the connection ended. Who
//! tries them asks more than once.
//!
//! Where nothing is ever heard over UDP, answers don't find their way, and nobody can say what ends the service.

use std::collections::BTreeMap;

use serde_json::json;

use super::{
    Detail, Exchange, Location, PerConnection, Role, Rule, RuleContext, SessionCheck, StatusReport, lines,
    mutant, served,
};

/// The records that these rules apply to.
pub(super) const APPLIES_TO: &str = "requests that try it, over UDP";

/// The ids of the requests of a trial. Datagrams get lost: one answer is enough.
pub(super) const REQUESTS: [&str; 3] = ["one", "two", "three"];

/// The session with trials of a rule that get no answer.
pub(super) fn unanswered(rule: &Rule) -> Option<Vec<u8>> {
    mutant::over("udp#9", |session| {
        for _ in 0..3 {
            session.tries(rule, "without an answer", json!({ "type": "SYS-PING" }));
        }
    })
}

/// In how many ways a rule is tried on a connection: more are taken for the same.
const MAX_WAYS: usize = 64;

/// What came of the trials of a rule, by how it is tried.
#[derive(Default)]
pub(super) struct Trials {
    /// True if a violation is reported although the server never sent anything over UDP.
    is_silence_reported: bool,
    /// Whether something was.
    has_received: bool,
    connections: PerConnection<BTreeMap<String, Outcome>>,
}

/// What came of one.
struct Outcome {
    is_answered: bool,
    /// Where its latest request without an answer stands.
    location: Location,
}

impl Trials {
    /// Trials that fail whenever none of their requests is answered.
    pub(super) fn new() -> Self {
        Self { is_silence_reported: true, ..Self::default() }
    }

    /// Trials that fail only if the server sends something else over UDP.
    pub(super) fn if_server_sends() -> Self {
        Self::default()
    }
}

impl SessionCheck for Trials {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        self.has_received |= exchange.is_from_server() && lines::is_called(exchange.record.connection, "udp");
        if let Some(trials) = self.connections.closed(exchange) {
            for (how, outcome) in trials {
                context.covered();
                if !outcome.is_answered && (self.has_received || self.is_silence_reported) {
                    let subject = if how.is_empty() { "message" } else { how.as_str() };
                    context.violation(subject, outcome.location, || {
                        Detail::new("no response to any request").expected("a response").actual("none")
                    });
                }
            }
            return;
        }
        served::served(exchange, context);
        let is_answered = exchange.role == Role::Response;
        // Of a recording that doesn't show how the connection ended, nobody knows what was to come.
        let is_over = exchange.role == Role::Unanswered && exchange.record.note.is_some();
        if let (Some(how), true) = (exchange.tried(context.rule), is_answered || is_over) {
            let location =
                exchange.request.as_ref().map_or(exchange.record.location, |request| request.location);
            let trials = self.connections.get(exchange);
            let how = if trials.len() < MAX_WAYS { how } else { "" };
            let outcome = trials.entry(how.to_owned()).or_insert(Outcome { is_answered, location });
            outcome.is_answered |= is_answered;
        }
    }

    fn status_report(&mut self, report: &StatusReport<'_>, _: &mut RuleContext<'_>) {
        self.has_received |= lines::is_called(report.connection(), "udp");
    }

    fn corruption(&mut self, _: Location) {
        self.connections.clear();
    }
}
