//! `FW-ENV-15`.

use serde_json::json;

use super::{
    Bug, Check, Detail, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, body, mutant,
    source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-15",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A type has two upper-case parts of 2 to 8 characters with a hyphen between them; seven of the specification itself are longer.",
        source: source::GENERAL,
        applies_to: "messages of the server",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
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
            make: || mutant::then(|session| session.exchange(json!({ "type": "uav-soar" }), json!({}))),
            also: &[],
        },
        Mutant {
            name: "a type of three parts",
            make: || mutant::then(|session| session.exchange(json!({ "type": "UAV-SOAR-HIGH" }), json!({}))),
            also: &[],
        },
    ],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(name) = message.type_name else { return };
    context.covered();
    let is_part = |part: &str| (2..=8).contains(&part.len()) && part.bytes().all(is_upper_case);
    let is_usual = name.split_once('-').is_some_and(|(family, rest)| is_part(family) && is_part(rest));
    if !is_usual && !context.definitions.defined_schemas().has(name) {
        message.violates(context, || {
            let expected = "two upper-case parts of 2 to 8 characters with a hyphen between them";
            Detail::differs(expected, body::quoted(name)).at("/body/type")
        });
    }
}

fn is_upper_case(byte: u8) -> bool {
    byte.is_ascii_uppercase() || byte.is_ascii_digit()
}
