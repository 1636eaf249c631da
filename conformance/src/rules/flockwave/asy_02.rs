//! `FW-ASY-02`.

use super::{
    Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, asy_09, mutant, reply,
    source,
};
use crate::flockwave::session::OPERATIONS;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "In a reply about several objects, each that was asked for stands in exactly one of `result`, `error` and `receipt`.",
        source: source::ASYNC,
        applies_to: "commands to several objects",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("The last object that was asked for is missing.", |out| {
        out.lose_last(&OPERATIONS);
    })
    .with(&[&asy_09::RULE.rule]),
    trial: None,
    mutants: &[
        Mutant {
            name: "a glider is missing",
            make: || mutant::reply("UAV-TAKEOFF", |body| mutant::remove(body, "result")),
            also: &[],
        },
        Mutant {
            name: "a glider is in two",
            make: || mutant::reply("UAV-TAKEOFF", |body| body["result"]["owl"] = true.into()),
            also: &[],
        },
    ],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    reply::partition(exchange, context, &OPERATIONS);
}
