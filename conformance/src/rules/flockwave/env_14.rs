//! `FW-ENV-14`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape, Status, fw};

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
    covers: &[],
    bug: Bug::message("The type of notifications of UAV-INF is a number.", |out| {
        if let Some(body) = out.notification_of("UAV-INF") {
            body["type"] = json!(7);
        }
    }),
    trial: None,
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

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.is_of_server() && exchange.body.is_some() {
        fw::field(exchange, context, "type", true, &Shape::Text);
    }
}
