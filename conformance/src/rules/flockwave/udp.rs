//! `FW-UDP-02` and `FW-UDP-03`: requests over UDP that have to be served.
//!
//! Datagrams get lost. So a trial has failed where none of its requests got an answer until the connection ended. Who
//! tries them asks more than once.
//!
//! Where nothing is ever heard over UDP, answers don't find their way, and nobody can say what ends the service.

use std::collections::BTreeMap;

use serde_json::json;

use super::fw::{self, Exchange, PerConnection, Role};
use super::{Check, Checker, Detail, FlockwaveRule, Level, Mutant, Place, Rule, RuleContext, Status};

/// The rule of an id.
macro_rules! rule {
    ($rule:ident, $id:literal, $is_silence_told:literal, $statement:literal) => {
        #[doc = concat!("`", $id, "`.")]
        pub(super) static $rule: FlockwaveRule = FlockwaveRule {
            rule: Rule {
                id: $id,
                level: Level::Info,
                status: Status::Advisory,
                statement: $statement,
                source: fw::DERIVED,
                applies_to: "requests that try it, over UDP",
            },
            check: Check::State(|| {
                Box::new(Trials { is_silence_told: $is_silence_told, ..Trials::default() })
            }),
            mutants: &[
                Mutant {
                    name: "trials without an answer",
                    make: || {
                        fw::over("udp#9", |session| {
                            for _ in 0..3 {
                        session.tries($id, "without an answer", json!({ "type": "SYS-PING" }));
                            }
                        })
                    },
                    also: &[],
                },
                Mutant { name: "a trial that is refused", make: || fw::refused("udp#9", $id), also: &[] },
            ],
        };
    };
}

rule!(UDP_02, "FW-UDP-02", true, "The answer goes to the address and port that the request came from.");

rule!(UDP_03, "FW-UDP-03", false, "A datagram that is no message doesn't end the service.");

/// In how many ways a rule is tried on a connection: more are taken for the same.
const MAX_WAYS: usize = 64;

/// What came of the trials of a rule, by how it is tried.
#[derive(Default)]
struct Trials {
    /// Whether it is told where nothing was ever heard over UDP.
    is_silence_told: bool,
    /// Whether something was.
    is_heard: bool,
    connections: PerConnection<BTreeMap<String, Outcome>>,
}

/// What came of one.
struct Outcome {
    is_answered: bool,
    /// Where its latest request without an answer stands.
    place: Place,
}

impl Checker for Trials {
    fn exchanged(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        self.is_heard |= exchange.is_of_server() && fw::is_called(exchange, "udp");
        if let Some(trials) = self.connections.closed(exchange) {
            for (how, outcome) in trials {
                context.covered();
                if !outcome.is_answered && (self.is_heard || self.is_silence_told) {
                    let subject = if how.is_empty() { "message" } else { how.as_str() };
                    context.violation(subject, outcome.place, || {
                        Detail::new("no response to any request").expected("a response").actual("none")
                    });
                }
            }
            return;
        }
        fw::served(exchange, context);
        let is_answered = exchange.role == Role::Response;
        // Of a recording that doesn't show how the connection ended, nobody knows what was to come.
        let is_over = exchange.role == Role::Unanswered && exchange.record.note.is_some();
        if let (Some(how), true) = (exchange.tried(context.rule), is_answered || is_over) {
            let place = exchange.asked.as_ref().map_or(exchange.record.place, |asked| asked.place);
            let trials = self.connections.of(exchange);
            let how = if trials.len() < MAX_WAYS { how } else { "" };
            let outcome = trials.entry(how.to_owned()).or_insert(Outcome { is_answered, place });
            outcome.is_answered |= is_answered;
        }
    }

    fn damage(&mut self, _: Place) {
        self.connections.clear();
    }
}
