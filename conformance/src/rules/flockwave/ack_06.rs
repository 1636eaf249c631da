//! `FW-ACK-06`.
//!
//! Whether a login is needed says AUTH-INF, but not for which requests. Whoever tries it chooses one that needs it.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Needs, Rule, RuleContext, Status, body,
    mutant, served, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ACK-06",
        level: Level::Must,
        status: Status::Normative,
        statement: "A request that needs a login is refused with ACK-NAK before it.",
        source: source::MESSAGES,
        applies_to: "requests that try it",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::behaviour("Requests are served without the login that they need (with --login).")
        .needs(Needs::Login),
    trial: None,
    mutants: &[
        Mutant {
            name: "it is served",
            make: || {
                let served = json!({ "type": "UAV-LIST", "ids": ["kite"] });
                let request = json!({ "type": "UAV-LIST" });
                mutant::over("tcp#9", |session| session.tries_and_receives(&RULE.rule, "", request, served))
            },
            also: &[],
        },
        Mutant { name: "it isn't answered", make: || mutant::unanswered("tcp#9", &RULE.rule), also: &[] },
    ],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if served::tried(exchange, context) && exchange.type_name != Some("ACK-NAK") {
        exchange.violates(context, || {
            let found = exchange.type_name.map_or_else(|| "another answer".to_owned(), body::quoted);
            Detail::differs("ACK-NAK", found)
        });
    }
}
