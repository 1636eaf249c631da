//! `FW-SYS-TIME-01`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, FlockwaveRule, INTEGER, Level, Message, Mutant, Rule, RuleContext, Status,
    attribution, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-TIME-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "`timestamp` is an integer number of milliseconds.",
        source: source::MESSAGES,
        applies_to: "SYS-TIME",
        why: "Clients compute the clock offset from the timestamp. If the timestamp is in seconds, the offset is wrong \
              by decades.",
        example: r#"{"type":"SYS-TIME","timestamp":1790000000.25}"#,
        fix: "Send the Unix time in milliseconds as an integer.",
    },
    checks: &[Check::Message(check)],
    covers: &[Attribution::new(&["SYS-TIME"], "timestamp", attribution::MISSING)],
    bug: Bug::message("The server time is in fractional seconds.", |out| {
        if let Some(body) = out.body_of("SYS-TIME") {
            #[expect(clippy::cast_precision_loss, reason = "it is a bug")]
            let seconds = body["timestamp"].as_u64().unwrap_or_default() as f64 / 1000.0 + 0.000_5;
            body["timestamp"] = json!(seconds);
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "fractional seconds",
            make: || mutant::reply("SYS-TIME", |body| body["timestamp"] = 1_790_000_000.25.into()),
            also: &[],
        },
        Mutant {
            name: "a string",
            make: || mutant::reply("SYS-TIME", |body| body["timestamp"] = "noon".into()),
            also: &[],
        },
    ],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("SYS-TIME").is_some() {
        body::field(message, context, "timestamp", true, &INTEGER);
    }
}
