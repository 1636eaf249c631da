//! `FW-ENV-07`.
//!
//! The specification sets no time limit, and a recording may end before the response arrives. A request is therefore
//! reported only under two conditions. First, no response arrives before the connection or the recording ends. Second,
//! the server still sends messages long after the request ([`MAX_SECONDS`]). A probe waits for the response and marks
//! the request as a test of this rule. If a request tests another rule, that rule checks the request.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Role, Rule, RuleContext, Session, Status,
    env_25, mutant, served, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-07",
        name: "Every request gets a response",
        level: Level::Must,
        status: Status::Normative,
        statement: "Every request gets a response, even if the server does not know the type of the request.",
        source: source::GENERAL,
        applies_to: "requests over time",
        why: "A client waiting for the response blocks or times out. The client cannot distinguish an unknown request \
              from a dead connection.",
        example: r#"→ {"type":"UAV-SOAR","ids":["uav-1"]}
(40 s later, still no response)
← {"type":"OBJ-DEL","ids":["uav-2"]}"#,
        fix: "Answer every request. Send ACK-NAK with a reason if the type is unknown or no handler produces a \
              response.",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("Requests of unknown types are not answered.", |out| {
        if out.refuses_unknown_type() {
            out.message = None;
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a request without a response",
            make: || Some(Session::new().without("SYS-VER")?.to_bytes()),
            also: &[],
        },
        Mutant {
            name: "a probe request without a response",
            make: || {
                mutant::over("tcp#9", |session| {
                    session.tries(&RULE.rule, "", json!({ "type": "SYS-VER" }));
                })
            },
            also: &[],
        },
    ],
};

/// The maximum time until a response, in seconds. If a server needs longer to process a request, it responds with a
/// receipt instead.
const MAX_SECONDS: f64 = 30.0;

/// The families with requests that may take long, although their responses can't have a receipt.
const SLOW: [&str; 3] = ["EXT-", "RTK-", "SHOW-"];

fn may_be_slow(type_name: &str) -> bool {
    SLOW.iter().any(|family| type_name.starts_with(family))
        && !["-INF", "-LIST"].iter().any(|end| type_name.ends_with(end))
}

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(request) = &exchange.request else { return };
    // A malformed request doesn't require a response.
    if !request.is_sound || !exchange.record.connection.is_ordered {
        return;
    }
    if let Some((tested, _)) = &request.trial {
        // If a request tests another rule, that rule checks it. FW-ENV-25 is an exception, because it checks only the
        // order of responses.
        if tested.id == RULE.rule.id {
            served::tried(exchange, context);
        }
        if tested.id != env_25::RULE.rule.id {
            return;
        }
    }
    if exchange.role == Role::Response {
        return context.covered();
    }
    let subject = request.type_name.as_deref().unwrap_or("message");
    let is_late = |waited: &f64| *waited > MAX_SECONDS && !may_be_slow(subject);
    let Some(waited) = request.waited.filter(is_late).filter(|_| exchange.role == Role::Unanswered) else {
        return;
    };
    context.violation(subject, request.location, || {
        Detail::new(format!("no response within {waited:.0} s, although the server sent other messages"))
            .expected("a response")
            .actual("none")
    });
}
