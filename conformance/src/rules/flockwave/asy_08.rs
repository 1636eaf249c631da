//! `FW-ASY-08`.

use serde_json::{Value, json};

use super::{
    Attribution, Bug, Check, Exchange, Fault, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape, Status,
    attribution, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-08",
        level: Level::Must,
        status: Status::Normative,
        statement: "`id` of ASYNC-RESP is a string, and so is `error`.",
        source: fw::ASYNC,
        applies_to: "ASYNC-RESP",
    },
    check: Check::Exchange(judge),
    covers: &[
        Attribution::new(&["ASYNC-RESP"], "id", attribution::MISSING),
        Attribution::new(&["ASYNC-RESP"], "error", &[Fault::Kind]),
    ],
    bug: Bug::message("The error of ASYNC-RESP is a number.", |out| {
        if let Some(body) = out.body_of("ASYNC-RESP").and_then(Value::as_object_mut) {
            body.remove("result");
            body.insert("error".to_owned(), json!(7));
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "an id that is a number",
            make: || fw::notice("ASYNC-RESP", |body| body["id"] = 7.into()),
            also: &[],
        },
        Mutant {
            name: "an error that is a number",
            make: || {
                fw::notice("ASYNC-RESP", |body| {
                    *body = json!({ "type": "ASYNC-RESP", "id": "rcpt-1", "error": 7 });
                })
            },
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("ASYNC-RESP").is_some() {
        fw::field(exchange, context, "id", true, &Shape::Text);
        fw::field(exchange, context, "error", false, &Shape::Nullable(&Shape::Text));
    }
}
