//! `FW-ENV-03`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-03",
        level: Level::Must,
        status: Status::Normative,
        statement: "`id` of a message is a string.",
        source: fw::GENERAL,
        applies_to: "messages of the server",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("Ids are numbers.", |out| {
        let number = out.number;
        out.message()["id"] = json!(number);
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "an id that is a number",
            make: || fw::reply_message("SYS-VER", |message| message["id"] = 7.into()),
            also: &[],
        },
        Mutant {
            name: "no id",
            make: || fw::reply_message("SYS-VER", |message| fw::remove(message, "id")),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(message) = exchange.message() else { return };
    fw::member(exchange, context, Some(message), &[], ("id", true), &Shape::Text);
}
