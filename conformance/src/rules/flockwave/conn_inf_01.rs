//! `FW-CONN-INF-01`.

use serde_json::json;

use super::{
    Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, mutant, reply, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-CONN-INF-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "Each requested id stands in exactly one of `status` and `error`.",
        source: source::MESSAGES,
        applies_to: "CONN-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("The last connection that was asked for is missing.", |out| {
        out.lose_last(&["CONN-INF"]);
    }),
    trial: None,
    mutants: &[Mutant {
        name: "a connection is missing",
        make: || mutant::reply("CONN-INF", |body| body["error"] = json!({})),
        also: &[],
    }],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    reply::partition(exchange, context, &["CONN-INF"]);
}
