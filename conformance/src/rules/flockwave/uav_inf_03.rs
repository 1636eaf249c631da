//! `FW-UAV-INF-03`.

use serde_json::json;

use super::{
    Bug, Check, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-03",
        level: Level::Must,
        status: Status::Normative,
        statement: "The key of each state is the `id` in it.",
        source: source::MESSAGES,
        applies_to: "UAV-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("A UAV has another id than its key.", |out| {
        out.set_in_state("id", json!("ghost-1"));
    }),
    trial: None,
    mutants: &[Mutant {
        name: "another id",
        make: || mutant::state(|kite| kite["id"] = "hawk".into()),
        also: &[],
    }],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::keyed(message, context, "UAV-INF");
}
