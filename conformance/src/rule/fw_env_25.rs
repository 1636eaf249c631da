//! `FW-ENV-25`.
//!
//! The specification lets answers come in any order. Most clients never see another than that of their requests, so it is
//! good to know of a server that doesn't keep to it.

use std::collections::BTreeSet;

use super::fw::{self, PerConnection, Role, Turn};
use super::{Check, Checker, Detail, Judged, Level, Mutant, Place, Rule, Status};

pub(super) static RULE: Rule = Rule {
    id: "FW-ENV-25",
    level: Level::Info,
    status: Status::Advisory,
    statement: "Answers to requests that are sent at once come in the order of the requests.",
    source: fw::DERIVED,
    applies_to: "requests that try it",
    check: Check::State(|| Box::new(Order::default())),
    mutants: &[
        Mutant {
            name: "the last one is answered first",
            make: |_| fw::over("tcp#9", |talk| talk.pipelines("FW-ENV-25", &[2, 0, 1])),
            also: &[],
        },
        Mutant { name: "one isn't answered", make: |_| fw::unanswered("tcp#9", "FW-ENV-25"), also: &[] },
    ],
};

/// How many requests of a connection are followed at the same time.
const MAX_WAITING: usize = 1_000;

/// The order of answers, connection by connection.
#[derive(Default)]
struct Order(PerConnection<Waiting>);

/// What waits on a connection.
#[derive(Default)]
struct Waiting {
    /// Where the requests stand.
    requests: BTreeSet<Place>,
    is_told: bool,
}

impl Checker for Order {
    fn exchanged(&mut self, turn: &Turn<'_>, judged: &mut Judged<'_>) {
        if !turn.exchange.connection.is_told {
            return;
        }
        let is_trial = turn.exchange.trial.is_some_and(|trial| trial.rule.id == RULE.id);
        if turn.role == Role::Request && is_trial {
            let waiting = self.0.of(turn);
            if waiting.requests.len() < MAX_WAITING {
                waiting.requests.insert(turn.exchange.place);
            }
        }
        if !fw::tried(turn, judged) {
            return;
        }
        let Some(asked) = &turn.asked else { return };
        let waiting = self.0.of(turn);
        waiting.requests.remove(&asked.place);
        let earlier = waiting.requests.first().filter(|place| **place < asked.place);
        if let Some(earlier) = earlier.filter(|_| !waiting.is_told) {
            turn.breaks(judged, || {
                Detail::new(format!("the request in {} is answered before that in {earlier}", asked.place))
                    .at("/refs")
            });
            waiting.is_told = true;
        }
    }

    fn damage(&mut self, _: Place) {
        self.0.clear();
    }
}
