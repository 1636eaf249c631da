//! `FW-UAV-INF-01`.

use super::{
    Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, mutant, reply, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "Each requested id stands in exactly one of `status` and `error`.",
        source: source::MESSAGES,
        applies_to: "UAV-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("The last UAV that was asked for is missing.", |out| {
        out.lose_last(&["UAV-INF"]);
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a glider is missing",
            make: || mutant::reply("UAV-INF", |body| mutant::remove(body, "error")),
            also: &[],
        },
        Mutant {
            name: "a glider is in both",
            make: || mutant::reply("UAV-INF", |body| body["error"]["kite"] = "Asleep".into()),
            also: &[],
        },
    ],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    reply::partition(exchange, context, &["UAV-INF"]);
}
