//! `FW-SYS-TIME-01`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, Exchange, FlockwaveRule, INTEGER, Level, Mutant, Rule, RuleContext, Status,
    attribution, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-TIME-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "`timestamp` is an integer, in milliseconds.",
        source: fw::MESSAGES,
        applies_to: "SYS-TIME",
    },
    check: Check::Exchange(judge),
    covers: &[Attribution::new(&["SYS-TIME"], "timestamp", attribution::MISSING)],
    bug: Bug::message("The time of the server is in seconds, with a fraction.", |out| {
        if let Some(body) = out.body_of("SYS-TIME") {
            #[expect(clippy::cast_precision_loss, reason = "it is a bug")]
            let seconds = body["timestamp"].as_u64().unwrap_or_default() as f64 / 1000.0 + 0.000_5;
            body["timestamp"] = json!(seconds);
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "seconds with a fraction",
            make: || fw::reply("SYS-TIME", |body| body["timestamp"] = 1_790_000_000.25.into()),
            also: &[],
        },
        Mutant {
            name: "a string",
            make: || fw::reply("SYS-TIME", |body| body["timestamp"] = "noon".into()),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("SYS-TIME").is_some() {
        fw::field(exchange, context, "timestamp", true, &INTEGER);
    }
}
