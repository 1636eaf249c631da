//! `FW-ACK-01`.

use serde_json::json;

use super::fw::{self, Exchange, Role};
use super::{Check, Detail, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

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
    mutants: &[Mutant {
        name: "an acknowledgment of nothing",
        make: || fw::then(|session| session.tells(json!({ "type": "ACK-ACK" }))),
        also: &["FW-ENV-17"],
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
