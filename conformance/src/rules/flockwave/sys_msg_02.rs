//! `FW-SYS-MSG-02`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape, Status, Tree,
    attribution, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-MSG-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "`severity` of an item is debug, info, warning, error or critical.",
        source: fw::MESSAGES,
        applies_to: "SYS-MSG",
    },
    check: Check::Exchange(judge),
    covers: &[Attribution::new(&["SYS-MSG"], "items.*.severity", attribution::WRONG)],
    bug: Bug::message("Items of SYS-MSG are of severity loud.", |out| {
        if let Some(item) = out.item() {
            item.insert("severity".to_owned(), json!("loud"));
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "a severity of its own",
        make: || fw::notice("SYS-MSG", |body| body["items"][0]["severity"] = "loud".into()),
        also: &[],
    }],
};

const SEVERITY: Shape = Shape::Nullable(&Shape::OneOf(&["debug", "info", "warning", "error", "critical"]));

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(Tree::List(items)) = exchange.body_of("SYS-MSG").and_then(|body| body.get("items")) else {
        return;
    };
    for (at, item) in items.iter().enumerate() {
        let keys = ["body", "items", &at.to_string()];
        fw::member(exchange, context, Some(item), &keys, ("severity", false), &SEVERITY);
    }
}
