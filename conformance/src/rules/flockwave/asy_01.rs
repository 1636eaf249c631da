//! `FW-ASY-01`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "A reply about one object has exactly one of `result`, `error` and `receipt`.",
        source: fw::ASYNC,
        applies_to: "LOG-DATA",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("LOG-DATA has a receipt and an error.", |out| {
        if let Some(body) = out.body_of("LOG-DATA")
            && body.get("receipt").is_some()
        {
            body["error"] = json!("the log is late");
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a result beside the receipt",
            make: || {
                fw::reply("LOG-DATA", |body| {
                    body["result"] = json!({ "id": "7", "kind": "text", "body": "Took off" });
                })
            },
            also: &[],
        },
        Mutant {
            name: "nothing",
            make: || {
                fw::then(|session| {
                    session.asks(json!({ "type": "LOG-DATA", "uavId": "kite", "logId": "8" }), json!({}));
                })
            },
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.response("LOG-DATA").is_some() {
        fw::exactly_one(exchange, context, &["result", "error", "receipt"], "result");
    }
}
