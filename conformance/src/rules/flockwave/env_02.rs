//! `FW-ENV-02`.

use super::fw::{self, Shape, Turn};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "`$fw.version` of a message is a string.",
        source: fw::GENERAL,
        applies_to: "messages of the server",
    },
    check: Check::Exchange(judge),
    mutants: &[
        Mutant {
            name: "no version",
            make: || fw::reply_message("SYS-VER", |message| fw::remove(message, "$fw.version")),
            also: &[],
        },
        Mutant {
            name: "a number",
            make: || fw::reply_message("SYS-VER", |message| message["$fw.version"] = 1.into()),
            also: &[],
        },
    ],
};

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    let Some(message) = turn.message() else { return };
    fw::member(turn, context, Some(message), &[], ("$fw.version", true), &Shape::Text);
}
