//! `FW-ASY-20J`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, Exchange, Fault, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-20J",
        level: Level::Should,
        status: Status::Advisory,
        statement: "The `ids` of ASYNC-TIMEOUT are unique.",
        source: fw::SCHEMA,
        applies_to: "ASYNC-TIMEOUT",
    },
    check: Check::Exchange(judge),
    covers: &[Attribution::new(&["ASYNC-TIMEOUT"], "ids", &[Fault::Value])],
    bug: Bug::message("ASYNC-TIMEOUT has its receipt twice.", |out| {
        if let Some(ids) = out.ids_of("ASYNC-TIMEOUT") {
            ids.extend_from_within(..1);
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "an id twice",
        make: || {
            fw::then(|session| {
                session.asks(
                    json!({ "type": "UAV-RTH", "ids": ["kite"] }),
                    json!({ "receipt": { "kite": "rcpt-8" } }),
                );
                session.tells(json!({ "type": "ASYNC-TIMEOUT", "ids": ["rcpt-8", "rcpt-8"] }));
            })
        },
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("ASYNC-TIMEOUT").is_some() {
        fw::unique(exchange, context, "ids");
    }
}
