//! `FW-UAV-LIST-03`.

use serde_json::json;

use super::listed_uavs::{Unknown, listed_twice};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-LIST-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "UAV-INF knows each UAV that UAV-LIST lists.",
        source: fw::DERIVED,
        applies_to: "UAV-LIST and UAV-INF over time",
    },
    check: Check::State(|| Box::new(Unknown::default())),
    mutants: &[Mutant {
        name: "one that it doesn't know",
        make: || {
            fw::over("tcp#9", |session| {
                listed_twice(session, |session| {
                    let error = json!({ "error": { "kite": "No such glider" } });
                    session.asks(json!({ "type": "UAV-INF", "ids": ["kite"] }), error);
                });
            })
        },
        also: &[],
    }],
};
