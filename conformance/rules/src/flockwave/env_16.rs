//! `FW-ENV-16`.

use uavspec_flockwave::session::parts;
use uavspec_schema::json_type::Direction;

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-16",
    name: "Type of a response",
    level: Level::Must,
    status: Status::Normative,
    statement: "A response has the type of its request, or is ACK-NAK. There are three exceptions: \
                AUTH-RESP answers AUTH-REQ. ACK-ACK answers SHOW-SETCFG, SHOW-SETLIGHTS and any \
                RTK-SOURCE that has an `id`. ACK-ACK may answer requests whose response has no required \
                fields.",
    source: source::GENERAL,
    applies_to: "responses over time",
    why: "The client decodes the body as the expected type. If the type differs, the client reads wrong \
          data or rejects the response.",
    example: r#"→ {"type":"CONN-LIST"}
← {"type":"OBJ-LIST","ids":["radio-1"]}"#,
    fix: "Copy the type of the request to the response. Answer with ACK-NAK if the request fails, and \
          follow the listed exceptions.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::message("CONN-LIST is answered with OBJ-LIST.", |out| {
    out.set("CONN-LIST", "type", json!("OBJ-LIST"));
}))
.mutants(&[
    Mutant::reply("a response of a different type", "SYS-PORTS", |body| {
        *body = json!({ "type": "UAV-LIST", "ids": [] });
    }),
    Mutant::session("an RTK-SOURCE with `id` answered with RTK-SOURCE", |session| {
        session.exchange(json!({ "type": "RTK-SOURCE", "id": null }), json!({ "id": null }));
    }),
]);

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
    let is_acknowledged =
        found == "ACK-ACK" && expected == request_type && needs_no_details(request_type, context);
    // FW-SYS-PING-01 checks SYS-PING.
    let is_right = [expected, "ACK-NAK"].contains(&found) || is_acknowledged || request_type == "SYS-PING";
    if !is_right {
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

/// True if a successful response needs no details. According to the description of ACK-ACK, it may then replace the
/// response.
fn needs_no_details(request_type: &str, context: &RuleContext<'_>) -> bool {
    let defined_schemas = context.definitions.defined_schemas();
    defined_schemas.is_defined(request_type, Direction::Response)
        && !defined_schemas.has_required_fields(request_type, Direction::Response)
        && parts(request_type).is_none()
        && !reply::may_have_receipts(request_type)
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
