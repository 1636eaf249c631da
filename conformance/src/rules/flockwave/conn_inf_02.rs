//! `FW-CONN-INF-02`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-CONN-INF-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "The key of each state is the `id` in it.",
        source: fw::MESSAGES,
        applies_to: "CONN-INF",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("Connections have other ids than their keys.", |out| {
        out.each_status("CONN-INF", |status| status["id"] = json!("radio-7"));
    }),
    trial: None,
    mutants: &[Mutant {
        name: "another id",
        make: || fw::notice("CONN-INF", |body| body["status"]["winch"]["id"] = "tow".into()),
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::keyed(exchange, context, "CONN-INF");
}
