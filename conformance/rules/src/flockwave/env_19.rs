//! `FW-ENV-19`.
//!
//! This is the only rule that checks clients. If a client reuses an id, responses can't be matched to requests. Only a
//! probe shows whether the server accepts the id of an answered request.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-19",
    name: "Reuse of request ids",
    level: Level::Must,
    status: Status::Normative,
    statement: "A client does not reuse the id of a request until the request has been answered. The \
                server then accepts the id again.",
    source: source::GENERAL,
    applies_to: "requests over time",
    why: "If two open requests have the same id, neither side can tell which response belongs to which \
          request.",
    example: r#"→ {"$fw.version":"1.0","id":"c1","body":{"type":"SYS-PING"}}
→ {"$fw.version":"1.0","id":"c1","body":{"type":"UAV-LIST"}}"#,
    fix: "In the client, create a new id for each request. In the server, do not reject the id of an \
          answered request.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::behaviour("A request that reuses the id of an answered request is refused."))
.trial(Trial::Requests(|_| requests()))
.mutants(&[
    Mutant::session("two open requests with the same id", |session| {
        let id = session.sends(json!({ "type": "SYS-PING" }));
        let other = session.sends(json!({ "type": "SYS-PING" }));
        if let Some(line) = session.lines.last_mut() {
            line["msg"]["id"] = id.clone().into();
        }
        for _ in [&id, &other] {
            session.answers(&id, json!({ "body": { "type": "ACK-ACK" } }));
        }
    }),
    Mutant::refused("the id of an answered request is refused", "tcp#9"),
]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    served::served(exchange, context);
    if exchange.role != Role::Request || exchange.is_from_server() || !exchange.record.connection.is_ordered {
        return;
    }
    context.covered();
    if exchange.is_id_in_use {
        exchange.violates(context, || {
            let id = exchange.id.map(body::quoted).unwrap_or_default();
            Detail::new(format!("another request with the id {id} has not been answered yet")).at("/id")
        });
    }
}

fn requests() -> Vec<Request> {
    let request = Request::new("the id of an answered request", json!({ "type": "SYS-VER" }));
    vec![Request { is_repeated: true, ..request }]
}
