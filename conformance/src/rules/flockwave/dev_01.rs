//! `FW-DEV-01`.
//!
//! DEV-INF is a matter of `FW-INF-01`.

use serde_json::json;

use super::{
    Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, inf_01, mutant, reply,
    source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-DEV-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "Each object or path that was asked for stands in exactly one part of the reply.",
        source: source::MESSAGES,
        applies_to: "DEV-LIST, DEV-SUB, DEV-UNSUB",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("The last object or path that was asked for is missing.", |out| {
        out.lose_last(&["DEV-LIST", "DEV-INF"]);
    })
    .with(&[&inf_01::RULE.rule]),
    trial: None,
    mutants: &[
        Mutant {
            name: "an object without a tree",
            make: || mutant::reply("DEV-LIST", |body| body["devices"] = json!({})),
            also: &[],
        },
        Mutant {
            name: "a path in both",
            make: || mutant::reply("DEV-SUB", |body| body["error"]["/kite/vario"] = "Busy".into()),
            also: &[],
        },
    ],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    reply::partition(exchange, context, &["DEV-LIST", "DEV-SUB", "DEV-UNSUB"]);
}
