//! `FW-ASY-07`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-07",
        level: Level::Must,
        status: Status::Normative,
        statement: "ASYNC-RESP has exactly one of `result` and `error`.",
        source: fw::ASYNC,
        applies_to: "ASYNC-RESP",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("ASYNC-RESP has a result and an error.", |out| {
        if let Some(body) = out.body_of("ASYNC-RESP") {
            body["result"] = json!(true);
            body["error"] = json!("and yet");
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "both",
            make: || fw::notice("ASYNC-RESP", |body| body["error"] = "Winch broke".into()),
            also: &[],
        },
        Mutant {
            name: "neither",
            make: || fw::notice("ASYNC-RESP", |body| fw::remove(body, "result")),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("ASYNC-RESP").is_some() {
        fw::exactly_one(exchange, context, &["result", "error"], "result");
    }
}
