//! `FW-ACK-04`.

use super::fw::{self, Exchange, Shape, Tree};
use super::{Check, Detail, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};
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
