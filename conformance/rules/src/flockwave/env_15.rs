//! `FW-ENV-15`.

use super::env_16;
use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-15",
    name: "Form of a message type",
    level: Level::Info,
    status: Status::Advisory,
    statement: "A message type consists of two parts joined by a hyphen. Each part has 2 to 8 uppercase \
                letters or digits. Seven types in the specification are exceptions.",
    source: source::GENERAL,
    applies_to: "messages from the server",
    why: "Clients and proxies select messages by family, the part before the hyphen. Clients and proxies \
          cannot route a type in a different form.",
    example: r#"{"type":"uav-wind","speed":6200}"#,
    fix: "Name custom types like the standard ones: an uppercase family and name joined by one hyphen, \
          such as `UAV-WIND`.",
})
.checks(&[Check::Message(check)])
.bug(
    Bug::message("Requests of unknown types are answered with a lowercase type.", |out| {
        if out.refuses_unknown_type() {
            out.message()["body"] = json!({ "type": "whatever" });
        }
    })
    .also(&[&env_16::RULE.rule]),
)
.mutants(&[
    Mutant::session("a lowercase type", |session| {
        session.exchange(json!({ "type": "uav-soar" }), json!({}));
    }),
    Mutant::session("a type with three parts", |session| {
        session.exchange(json!({ "type": "UAV-SOAR-HIGH" }), json!({}));
    }),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(name) = message.type_name else { return };
    context.covered();
    let is_part = |part: &str| (2..=8).contains(&part.len()) && part.bytes().all(is_upper_case_or_digit);
    let is_usual = name.split_once('-').is_some_and(|(family, rest)| is_part(family) && is_part(rest));
    if !is_usual && !context.definitions.defined_schemas().has(name) {
        message.violates(context, || {
            let expected = "two parts joined by a hyphen, each 2 to 8 uppercase letters or digits";
            Detail::differs(expected, body::quoted(name)).at("/body/type")
        });
    }
}

fn is_upper_case_or_digit(byte: u8) -> bool {
    byte.is_ascii_uppercase() || byte.is_ascii_digit()
}
