//! `FW-ASY-03`.

use serde_json::json;

use super::{
    Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, mutant, reply, source,
};
use crate::flockwave::session::OPERATIONS;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A reply about several objects tells of none that wasn't asked for.",
        source: source::DERIVED,
        applies_to: "commands to several objects",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("There is an object that nobody asked for.", |out| {
        if OPERATIONS.contains(&out.kind()) {
            out.message()["body"]["error"]["ghost-1"] = json!("there is no such object");
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "one more glider",
        make: || mutant::reply("UAV-TAKEOFF", |body| body["error"]["hawk"] = "Asleep".into()),
        also: &[],
    }],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    reply::strangers(exchange, context, &OPERATIONS);
}
