//! `FW-ENV-16`.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Role, Rule, RuleContext, Status, body,
    mutant, source, sys_ping_01, sys_ping_02,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-16",
        level: Level::Must,
        status: Status::Normative,
        statement: "A response has the type of its request or is ACK-NAK, but that of SYS-PING, SHOW-SETCFG, SHOW-SETLIGHTS and a setting RTK-SOURCE is ACK-ACK, and that of AUTH-REQ is AUTH-RESP.",
        source: source::GENERAL,
        applies_to: "responses over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("CONN-LIST is answered by OBJ-LIST.", |out| {
        if let Some(body) = out.body_of("CONN-LIST") {
            body["type"] = json!("OBJ-LIST");
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "another type",
            make: || mutant::reply("SYS-PORTS", |body| *body = json!({ "type": "UAV-LIST", "ids": [] })),
            also: &[],
        },
        Mutant {
            name: "SYS-PING is answered with itself",
            make: || mutant::reply("ACK-ACK", |body| body["type"] = "SYS-PING".into()),
            also: &[&sys_ping_01::RULE.rule, &sys_ping_02::RULE.rule],
        },
        Mutant {
            name: "a setting RTK-SOURCE is answered with itself",
            make: || {
                mutant::then(|session| {
                    session.exchange(json!({ "type": "RTK-SOURCE", "id": null }), json!({ "id": null }));
                })
            },
            also: &[],
        },
    ],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let (Some(request), Some(found)) = (&exchange.request, exchange.type_name) else { return };
    let Some(question) =
        request.type_name.as_deref().filter(|name| context.definitions.defined_schemas().has(name))
    else {
        return;
    };
    if exchange.role != Role::Response || !exchange.is_from_server() {
        return;
    }
    let expected = answer(question, request.is_setting);
    context.covered();
    if found != expected && found != "ACK-NAK" {
        exchange.violates(context, || {
            Detail::new(format!(
                "{} answers {question}, where {expected} or ACK-NAK should",
                body::quoted(found)
            ))
            .at("/body/type")
            .expected(format!("{expected} or ACK-NAK"))
            .actual(body::quoted(found))
        });
    }
}

/// The type that answers a request of this type, if it isn't ACK-NAK.
fn answer(question: &str, is_setting: bool) -> &str {
    match question {
        "SYS-PING" | "SHOW-SETCFG" | "SHOW-SETLIGHTS" => "ACK-ACK",
        "RTK-SOURCE" if is_setting => "ACK-ACK",
        "AUTH-REQ" => "AUTH-RESP",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::answer;
    use crate::definitions::Definitions;

    #[test]
    fn answers_are_those_that_the_definitions_have() {
        for message in &Definitions::built_in().schema.json_messages {
            for part in message.parts.iter().filter(|part| !part.answers.is_empty()) {
                let stated: BTreeSet<&str> = part.answers.iter().map(String::as_str).collect();
                let expected = [false, true].map(|is_setting| answer(&message.name, is_setting));
                assert_eq!(stated, BTreeSet::from(expected), "{}", message.name);
            }
        }
    }
}
