//! Checks that a server serves requests over UDP.
//!
//! Datagrams may be lost. A probe therefore sends several requests for each trial, and the trial fails only if all of
//! them are unanswered when the connection closes.
//!
//! If nothing from the server ever arrives over UDP, a missing response does not prove that the server stopped serving
//! requests.

use std::collections::BTreeMap;

use super::prelude::*;

/// The records that these rules apply to.
pub(super) const APPLIES_TO: &str = "probe requests over UDP that test this rule";

/// The request ids of a trial. Datagrams may be lost, so one response is sufficient.
pub(super) const REQUESTS: [&str; 3] = ["one", "two", "three"];

/// Adds a trial of a rule in which the server does not respond to any request.
pub(super) fn unanswered(session: &mut Session, rule: &Rule) {
    for _ in 0..3 {
        session.tries(rule, "without a response", json!({ "type": "SYS-PING" }));
    }
}

/// The maximum number of distinct trials on a connection. Further trials are counted as one.
const MAX_TRIALS: usize = 64;

/// The trial outcomes for a rule, by connection and description.
#[derive(Default)]
pub(super) struct Trials {
    /// True if violations are reported even if the server never sends anything over UDP.
    is_silence_reported: bool,
    /// True if the server sent something over UDP.
    has_received: bool,
    connections: PerConnection<BTreeMap<String, Outcome>>,
}

/// The outcome of a trial.
struct Outcome {
    is_answered: bool,
    /// The location of the trial's first request.
    location: Location,
}

impl Trials {
    /// Creates trials that fail if none of their requests is answered, even if the server never sends anything over
    /// UDP.
    pub(super) fn new() -> Self {
        Self { is_silence_reported: true, ..Self::default() }
    }

    /// Creates trials that fail if none of their requests is answered, but only if the server has sent something over
    /// UDP.
    pub(super) fn if_server_sends() -> Self {
        Self::default()
    }
}

impl SessionCheck for Trials {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        self.has_received |=
            exchange.is_from_server() && lines::name_starts_with(exchange.record.connection, "udp");
        if let Some(trials) = self.connections.closed(exchange) {
            for (how, outcome) in trials {
                context.covered();
                let is_reported = self.has_received || self.is_silence_reported;
                if !outcome.is_answered && is_reported {
                    // The service may have ended, so further trials prove nothing until the server sends something.
                    self.has_received = false;
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
        // If the recording does not contain the end of the connection, a response may still have arrived.
        let is_over = exchange.role == Role::Unanswered && exchange.record.note.is_some();
        if let (Some(how), true) = (exchange.tried(context.rule), is_answered || is_over) {
            let location =
                exchange.request.as_ref().map_or(exchange.record.location, |request| request.location);
            let trials = self.connections.get(exchange);
            let how = if trials.len() < MAX_TRIALS { how } else { "" };
            let outcome = trials.entry(how.to_owned()).or_insert(Outcome { is_answered, location });
            outcome.is_answered |= is_answered;
        }
    }

    fn status_report(&mut self, report: &StatusReport<'_>, _: &mut RuleContext<'_>) {
        self.has_received |= lines::name_starts_with(report.connection(), "udp");
    }
}
