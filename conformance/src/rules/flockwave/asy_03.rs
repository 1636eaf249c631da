//! `FW-ASY-03`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};
use crate::flockwave::session::OPERATIONS;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A reply about several objects tells of none that wasn't asked for.",
        source: fw::DERIVED,
        applies_to: "commands to several objects",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("There is an object that nobody asked for.", |out| {
        if OPERATIONS.contains(&out.kind()) {
            out.message()["body"]["error"]["ghost-1"] = json!("there is no such object");
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "one more glider",
        make: || fw::reply("UAV-TAKEOFF", |body| body["error"]["hawk"] = "Asleep".into()),
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::strangers(exchange, context, &OPERATIONS);
}
