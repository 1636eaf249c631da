//! `FW-ACK-03`.

use super::fw::{self, Tree, Turn};
use super::{Check, Detail, FlockwaveRule, Judged, Level, Mutant, Rule, Status};
use crate::json::pointer;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ACK-03",
        level: Level::Must,
        status: Status::Normative,
        statement: "ACK-ACK has nothing but `type`.",
        source: fw::MESSAGES,
        applies_to: "ACK-ACK",
    },
    check: Check::Exchange(judge),
    mutants: &[Mutant {
        name: "a reason",
        make: || fw::reply("ACK-ACK", |body| body["reason"] = "Fine".into()),
        also: &[],
    }],
};

fn judge(turn: &Turn<'_>, judged: &mut Judged<'_>) {
    let Some(Tree::Object(members)) = turn.body_of("ACK-ACK") else { return };
    judged.exercise();
    if let Some((key, _)) = members.iter().find(|(key, _)| key != "type") {
        turn.breaks(judged, || {
            Detail::new(format!("it has {}, too", fw::quoted(key))).at(pointer(&["body", key]))
        });
    }
}
