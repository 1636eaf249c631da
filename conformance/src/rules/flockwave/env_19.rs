//! `FW-ENV-19`.
//!
//! It is the one rule on clients: what breaks it leaves nobody able to say which answer belongs to what. What servers do
//! with an id that is used again in its time is seen where someone tries it.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Request, Role, Rule, RuleContext, Status,
    Trial, body, mutant, served, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-19",
        level: Level::Must,
        status: Status::Normative,
        statement: "A client doesn't use the id of a request again while that is unanswered. Afterwards a server accepts it.",
        source: source::GENERAL,
        applies_to: "requests over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::behaviour("An id that was answered is refused when it comes again."),
    trial: Some(Trial::Requests(|_| requests())),
    mutants: &[
        Mutant {
            name: "an id is used twice at the same time",
            make: || {
                mutant::then(|session| {
                    let id = session.sends(json!({ "type": "SYS-PING" }));
                    let other = session.sends(json!({ "type": "SYS-PING" }));
                    if let Some(line) = session.lines.last_mut() {
                        line["msg"]["id"] = id.clone().into();
                    }
                    for _ in [&id, &other] {
                        session.answers(&id, json!({ "body": { "type": "ACK-ACK" } }));
                    }
                })
            },
            also: &[],
        },
        Mutant {
            name: "an id that was answered is refused",
            make: || mutant::refused("tcp#9", &RULE.rule),
            also: &[],
        },
    ],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    served::served(exchange, context);
    if exchange.role != Role::Request || exchange.is_from_server() || !exchange.record.connection.is_ordered {
        return;
    }
    context.covered();
    if exchange.is_id_in_use {
        exchange.violates(context, || {
            let id = exchange.id.map(body::quoted).unwrap_or_default();
            Detail::new(format!("another request with the id {id} waits for its answer")).at("/id")
        });
    }
}

fn requests() -> Vec<Request> {
    let request = Request::new("an id that is answered", json!({ "type": "SYS-VER" }));
    vec![Request { is_repeated: true, ..request }]
}
