//! `FW-UDP-02` and `FW-UDP-03`: requests over UDP that have to be served.
//!
//! Datagrams get lost. So a trial has failed where none of its requests got an answer until the connection ended. Who
//! tries them asks more than once.

use std::collections::BTreeMap;

use serde_json::json;

use super::fw::{self, PerConnection, Role, Turn};
use super::{Check, Checker, Detail, Judged, Level, Mutant, Place, Rule, Status};

/// The rule of an id.
macro_rules! rule {
    ($rule:ident, $id:literal, $statement:literal) => {
        #[doc = concat!("`", $id, "`.")]
        pub(super) static $rule: Rule = Rule {
            id: $id,
            level: Level::Info,
            status: Status::Advisory,
            statement: $statement,
            source: fw::DERIVED,
            applies_to: "requests that try it, over UDP",
            check: Check::State(|| Box::new(Trials::default())),
            mutants: &[
                Mutant {
                    name: "trials without an answer",
                    make: |_| {
                        fw::over("udp#9", |talk| {
                            for _ in 0..3 {
                        talk.tries($id, "without an answer", json!({ "type": "SYS-PING" }));
                            }
                        })
                    },
                    also: &[],
                },
                Mutant { name: "a trial that is refused", make: |_| fw::refused("udp#9", $id), also: &[] },
            ],
        };
    };
}

rule!(UDP_02, "FW-UDP-02", "The answer goes to the address and port that the request came from.");

rule!(UDP_03, "FW-UDP-03", "A datagram that is no message doesn't end the service.");

/// In how many ways a rule is tried on a connection: more are taken for the same.
const MAX_WAYS: usize = 64;

/// What came of the trials of a rule, by how it is tried.
#[derive(Default)]
struct Trials(PerConnection<BTreeMap<String, Outcome>>);

/// What came of one.
struct Outcome {
    is_answered: bool,
    /// Where its latest request without an answer stands.
    place: Place,
}

impl Checker for Trials {
    fn exchanged(&mut self, turn: &Turn<'_>, judged: &mut Judged<'_>) {
        if let Some(trials) = self.0.closed(turn) {
            for (how, outcome) in trials {
                judged.exercise();
                if !outcome.is_answered {
                    let subject = if how.is_empty() { "message" } else { how.as_str() };
                    judged.report(subject, outcome.place, || {
                        Detail::new("no response to any request").expected("a response").actual("none")
                    });
                }
            }
            return;
        }
        fw::served(turn, judged);
        let is_answered = turn.role == Role::Response;
        // Of a recording that doesn't show how the connection ended, nobody knows what was to come.
        let is_over = turn.role == Role::Unanswered && turn.exchange.note.is_some();
        if let (Some(how), true) = (turn.tried(judged.rule), is_answered || is_over) {
            let place = turn.asked.as_ref().map_or(turn.exchange.place, |asked| asked.place);
            let trials = self.0.of(turn);
            let how = if trials.len() < MAX_WAYS { how } else { "" };
            let outcome = trials.entry(how.to_owned()).or_insert(Outcome { is_answered, place });
            outcome.is_answered |= is_answered;
        }
    }

    fn damage(&mut self, _: Place) {
        self.0.clear();
    }
}
