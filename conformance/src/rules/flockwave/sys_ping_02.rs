//! `FW-SYS-PING-02`.

use super::fw::{self, Role, Turn};
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

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    let asked = turn.asked.as_ref().and_then(|asked| asked.type_name.as_deref());
    if turn.role != Role::Response || !turn.is_of_server() || asked != Some("SYS-PING") {
        return;
    }
    context.covered();
    if turn.type_name == Some("SYS-PING") {
        turn.breaks(context, || Detail::new("a request in the place of an answer").at("/body/type"));
    }
}
