//! `FW-SYS-PING-02`.

use super::fw::{self, Exchange, Role};
use super::{Check, Detail, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-PING-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "SYS-PING isn't answered with SYS-PING.",
        source: fw::MESSAGES,
        applies_to: "SYS-PING",
    },
    check: Check::Exchange(judge),
    mutants: &[Mutant {
        name: "it is",
        make: || fw::reply("ACK-ACK", |body| body["type"] = "SYS-PING".into()),
        also: &["FW-ENV-16", "FW-SYS-PING-01"],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let asked = exchange.asked.as_ref().and_then(|asked| asked.type_name.as_deref());
    if exchange.role != Role::Response || !exchange.is_of_server() || asked != Some("SYS-PING") {
        return;
    }
    context.covered();
    if exchange.type_name == Some("SYS-PING") {
        exchange.breaks(context, || Detail::new("a request in the place of an answer").at("/body/type"));
    }
}
