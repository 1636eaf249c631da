//! `FW-ENV-14`.

use serde_json::json;

use super::fw::{self, Shape, Turn};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-14",
        level: Level::Must,
        status: Status::Normative,
        statement: "`type` of a body is a string.",
        source: fw::GENERAL,
        applies_to: "messages of the server",
    },
    check: Check::Exchange(judge),
    mutants: &[
        Mutant {
            name: "no type",
            make: || fw::reply_message("ACK-ACK", |message| message["body"] = json!({})),
            also: &[],
        },
        Mutant {
            name: "a type that is a number",
            make: || fw::reply("ACK-ACK", |body| body["type"] = 7.into()),
            also: &[],
        },
    ],
};

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    if turn.is_of_server() && turn.body.is_some() {
        fw::field(turn, context, "type", true, &Shape::Text);
    }
}
