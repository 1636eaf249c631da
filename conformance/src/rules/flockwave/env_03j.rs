//! `FW-ENV-03J`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-03J",
        level: Level::Should,
        status: Status::Advisory,
        statement: "`id` of a message has 1 to 36 characters.",
        source: fw::SCHEMA,
        applies_to: "messages of the server",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("Ids have 40 characters.", |out| {
        let id = format!("{:0>40}", out.number);
        out.message()["id"] = json!(id);
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "an id of 37 characters",
            make: || fw::reply_message("SYS-VER", |message| message["id"] = "x".repeat(37).into()),
            also: &[],
        },
        Mutant {
            name: "an empty id",
            make: || fw::reply_message("SYS-VER", |message| message["id"] = "".into()),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(message) = exchange.message().filter(|_| exchange.id.is_some()) else { return };
    fw::member(exchange, context, Some(message), &[], ("id", true), &Shape::Length(1, 36));
}
