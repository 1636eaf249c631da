//! `FW-ENV-15`.

use serde_json::json;

use super::{Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-15",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A type has two upper-case parts of 2 to 8 characters with a hyphen between them; seven of the specification itself are longer.",
        source: fw::GENERAL,
        applies_to: "messages of the server",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("Requests of unknown types are answered by a type in small letters.", |out| {
        if out.refuses_unknown_type() {
            out.message()["body"] = json!({ "type": "whatever" });
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a type in lower case",
            make: || fw::then(|session| session.asks(json!({ "type": "uav-soar" }), json!({}))),
            also: &[],
        },
        Mutant {
            name: "a type of three parts",
            make: || fw::then(|session| session.asks(json!({ "type": "UAV-SOAR-HIGH" }), json!({}))),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(name) = exchange.type_name.filter(|_| exchange.is_of_server()) else { return };
    context.covered();
    let is_part = |part: &str| (2..=8).contains(&part.len()) && part.bytes().all(is_upper_case);
    let is_usual = name.split_once('-').is_some_and(|(family, rest)| is_part(family) && is_part(rest));
    if !is_usual && !context.definitions.shapes().has(name) {
        exchange.breaks(context, || {
            let expected = "two upper-case parts of 2 to 8 characters with a hyphen between them";
            Detail::differs(expected, fw::quoted(name)).at("/body/type")
        });
    }
}

fn is_upper_case(byte: u8) -> bool {
    byte.is_ascii_uppercase() || byte.is_ascii_digit()
}
