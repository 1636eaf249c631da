//! `FW-ACK-01`.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Role, Rule, RuleContext, Status, env_17, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ACK-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "Acknowledgments come only as responses.",
        source: fw::MESSAGES,
        applies_to: "ACK-ACK, ACK-NAK",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("An acknowledgment that answers nothing follows each SYS-VER.", |out| {
        if out.kind() == "SYS-VER" {
            out.follow(None, json!({ "type": "ACK-ACK" }));
        }
    })
    .with(&[&env_17::RULE.rule]),
    trial: None,
    mutants: &[Mutant {
        name: "an acknowledgment of nothing",
        make: || fw::then(|session| session.tells(json!({ "type": "ACK-ACK" }))),
        also: &[&env_17::RULE.rule],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if !exchange.is_of_server() || !matches!(exchange.type_name, Some("ACK-ACK" | "ACK-NAK")) {
        return;
    }
    context.covered();
    if exchange.role != Role::Response {
        exchange.breaks(context, || Detail::new("an acknowledgment without `refs`"));
    }
}
