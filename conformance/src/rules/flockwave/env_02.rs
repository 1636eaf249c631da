//! `FW-ENV-02`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape, Status, fw};

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
    covers: &[],
    bug: Bug::message("The version of the protocol is a number.", |out| {
        out.message()["$fw.version"] = json!(1);
    }),
    trial: None,
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

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(message) = exchange.message() else { return };
    fw::member(exchange, context, Some(message), &[], ("$fw.version", true), &Shape::Text);
}
