//! `FW-ACK-03`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, Detail, Exchange, Fault, FlockwaveRule, Level, Mutant, Rule, RuleContext,
    Status, Tree, fw,
};
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
    covers: &[Attribution::new(&["ACK-ACK"], "*", &[Fault::Further])],
    bug: Bug::message("ACK-ACK has a reason.", |out| {
        if let Some(body) = out.body_of("ACK-ACK") {
            body["reason"] = json!("why not");
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "a reason",
        make: || fw::reply("ACK-ACK", |body| body["reason"] = "Fine".into()),
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(Tree::Object(members)) = exchange.body_of("ACK-ACK") else { return };
    context.covered();
    if let Some((key, _)) = members.iter().find(|(key, _)| key != "type") {
        exchange.breaks(context, || {
            Detail::new(format!("it has {}, too", fw::quoted(key))).at(pointer(&["body", key]))
        });
    }
}
