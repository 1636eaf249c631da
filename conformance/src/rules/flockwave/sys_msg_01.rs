//! `FW-SYS-MSG-01`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape, Status, Tree,
    attribution, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-MSG-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "`items` is a list, and each has a string `message`.",
        source: fw::MESSAGES,
        applies_to: "SYS-MSG",
    },
    check: Check::Exchange(judge),
    covers: &[
        Attribution::new(&["SYS-MSG"], "items", attribution::MISSING),
        Attribution::new(&["SYS-MSG"], "items.*", attribution::MISSING),
        Attribution::new(&["SYS-MSG"], "items.*.message", attribution::MISSING),
    ],
    bug: Bug::message("Items of SYS-MSG have no message.", |out| {
        if let Some(item) = out.item() {
            item.remove("message");
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "an item without a message",
            make: || fw::notice("SYS-MSG", |body| body["items"][0] = json!({ "severity": "info" })),
            also: &[],
        },
        Mutant {
            name: "no list",
            make: || fw::notice("SYS-MSG", |body| body["items"] = "Thermals".into()),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("SYS-MSG").is_none() {
        return;
    }
    fw::field(exchange, context, "items", true, &Shape::List(&Shape::Object));
    if let Some(Tree::List(items)) = exchange.field("items") {
        for (at, item) in items.iter().enumerate().filter(|(_, item)| matches!(item, Tree::Object(_))) {
            let keys = ["body", "items", &at.to_string()];
            fw::member(exchange, context, Some(item), &keys, ("message", true), &Shape::Text);
        }
    }
}
