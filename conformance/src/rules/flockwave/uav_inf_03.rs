//! `FW-UAV-INF-03`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-03",
        level: Level::Must,
        status: Status::Normative,
        statement: "The key of each state is the `id` in it.",
        source: fw::MESSAGES,
        applies_to: "UAV-INF",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("A UAV has another id than its key.", |out| {
        out.set_in_state("id", json!("ghost-1"));
    }),
    trial: None,
    mutants: &[Mutant {
        name: "another id",
        make: || fw::state(|kite| kite["id"] = "hawk".into()),
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::keyed(exchange, context, "UAV-INF");
}
