//! `FW-CONN-INF-02`.

use serde_json::json;

use super::{
    Bug, Check, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-CONN-INF-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "The key of each state is the `id` in it.",
        source: source::MESSAGES,
        applies_to: "CONN-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("Connections have other ids than their keys.", |out| {
        out.each_status("CONN-INF", |status| status["id"] = json!("radio-7"));
    }),
    trial: None,
    mutants: &[Mutant {
        name: "another id",
        make: || mutant::notice("CONN-INF", |body| body["status"]["winch"]["id"] = "tow".into()),
        also: &[],
    }],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::keyed(message, context, "CONN-INF");
}
