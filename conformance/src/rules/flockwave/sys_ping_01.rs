//! `FW-SYS-PING-01`.
//!
//! A server may refuse even this, as long as nobody has logged in. Whoever tries it has seen to that.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Role, Rule, RuleContext, Status, body,
    env_16, mutant, served, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-PING-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "SYS-PING is answered with ACK-ACK.",
        source: source::MESSAGES,
        applies_to: "SYS-PING",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("SYS-PING is answered with ACK-NAK.", |out| {
        if out.request_type() == Some("SYS-PING") {
            out.message()["body"] = json!({ "type": "ACK-NAK" });
        }
    }),
    trial: None,
    mutants: &[
        Mutant { name: "it is refused", make: || mutant::refused("tcp#9", &RULE.rule), also: &[] },
        Mutant { name: "it isn't answered", make: || mutant::unanswered("tcp#9", &RULE.rule), also: &[] },
        Mutant {
            name: "it is answered with something else",
            make: || mutant::reply("ACK-ACK", |body| *body = json!({ "type": "CONN-LIST", "ids": [] })),
            also: &[&env_16::RULE.rule],
        },
    ],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let is_trial = exchange.tried(&RULE.rule).is_some();
    if is_trial && !served::served(exchange, context) {
        return;
    }
    let request = exchange.request.as_ref().and_then(|request| request.type_name.as_deref());
    if exchange.role != Role::Response || !exchange.is_from_server() || request != Some("SYS-PING") {
        return;
    }
    if !is_trial {
        context.covered();
    }
    if let Some(found) = exchange.type_name.filter(|found| !["ACK-ACK", "ACK-NAK"].contains(found)) {
        exchange.violates(context, || Detail::differs("ACK-ACK", body::quoted(found)).at("/body/type"));
    }
}
