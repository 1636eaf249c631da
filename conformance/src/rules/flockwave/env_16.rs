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
        statement: "A response has the type of its request, or is ACK-NAK. There are two exceptions: AUTH-RESP answers \
                    AUTH-REQ, and ACK-ACK answers SYS-PING, SHOW-SETCFG, SHOW-SETLIGHTS and any RTK-SOURCE that has an \
                    `id`.",
        source: source::GENERAL,
        applies_to: "responses over time",
        why: "The client decodes the body as the expected type. If the type differs, the client reads wrong data or \
              rejects the response.",
        example: r#"→ {"type":"CONN-LIST"}
← {"type":"OBJ-LIST","ids":["radio-1"]}"#,
        fix: "Copy the type of the request to the response. Answer with ACK-NAK if the request fails, and follow \
              the listed exceptions.",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("CONN-LIST is answered with OBJ-LIST.", |out| {
        if let Some(body) = out.body_of("CONN-LIST") {
            body["type"] = json!("OBJ-LIST");
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a response of a different type",
            make: || mutant::reply("SYS-PORTS", |body| *body = json!({ "type": "UAV-LIST", "ids": [] })),
            also: &[],
        },
        Mutant {
            name: "SYS-PING answered with SYS-PING",
            make: || mutant::reply("ACK-ACK", |body| body["type"] = "SYS-PING".into()),
            also: &[&sys_ping_01::RULE.rule, &sys_ping_02::RULE.rule],
        },
        Mutant {
            name: "an RTK-SOURCE with `id` answered with RTK-SOURCE",
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
    let Some(request_type) =
        request.type_name.as_deref().filter(|name| context.definitions.defined_schemas().has(name))
    else {
        return;
    };
    if exchange.role != Role::Response || !exchange.is_from_server() {
        return;
    }
    let expected = response_type(request_type, request.is_setting);
    context.covered();
    if found != expected && found != "ACK-NAK" {
        exchange.violates(context, || {
            Detail::new(format!(
                "{} answers {request_type}; expected {expected} or ACK-NAK",
                body::quoted(found)
            ))
            .at("/body/type")
            .expected(format!("{expected} or ACK-NAK"))
            .actual(body::quoted(found))
        });
    }
}

/// The type of a successful response to a request of this type.
fn response_type(request_type: &str, is_setting: bool) -> &str {
    match request_type {
        "SYS-PING" | "SHOW-SETCFG" | "SHOW-SETLIGHTS" => "ACK-ACK",
        "RTK-SOURCE" if is_setting => "ACK-ACK",
        "AUTH-REQ" => "AUTH-RESP",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::response_type;
    use crate::definitions::Definitions;

    #[test]
    fn response_types_match_the_definitions() {
        for message in &Definitions::built_in().schema.json_messages {
            for part in message.parts.iter().filter(|part| !part.answers.is_empty()) {
                let stated: BTreeSet<&str> = part.answers.iter().map(String::as_str).collect();
                let expected = [false, true].map(|is_setting| response_type(&message.name, is_setting));
                assert_eq!(stated, BTreeSet::from(expected), "{}", message.name);
            }
        }
    }
}
