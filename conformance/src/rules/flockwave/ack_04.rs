//! `FW-ACK-04`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, Detail, Exchange, Fault, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape,
    Status, Tree, fw,
};
use crate::json::pointer;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ACK-04",
        level: Level::Must,
        status: Status::Normative,
        statement: "ACK-NAK has nothing beside `type` but a string `reason`.",
        source: fw::MESSAGES,
        applies_to: "ACK-NAK",
    },
    check: Check::Exchange(judge),
    covers: &[
        Attribution::new(&["ACK-NAK"], "*", &[Fault::Further]),
        Attribution::new(&["ACK-NAK"], "reason", &[Fault::Kind]),
    ],
    bug: Bug::message("The reason of ACK-NAK is an object.", |out| {
        if let Some(body) = out.body_of("ACK-NAK") {
            body["reason"] = json!({ "en": "no" });
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a number for the reason",
            make: || fw::reply("ACK-NAK", |body| body["reason"] = 7.into()),
            also: &[],
        },
        Mutant {
            name: "another field",
            make: || fw::reply("ACK-NAK", |body| body["code"] = 7.into()),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(Tree::Object(members)) = exchange.body_of("ACK-NAK") else { return };
    context.covered();
    if let Some((key, _)) = members.iter().find(|(key, _)| key != "type" && key != "reason") {
        exchange.breaks(context, || {
            Detail::new(format!("it has {}, too", fw::quoted(key))).at(pointer(&["body", key]))
        });
    }
    fw::field(exchange, context, "reason", false, &Shape::Nullable(&Shape::Text));
}
