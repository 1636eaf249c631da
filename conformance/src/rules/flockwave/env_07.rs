//! `FW-ENV-07`.
//!
//! No time limit is laid down, and a recording may end before the answer. So a request counts as unanswered only
//! where no answer comes until the connection or the recording ends, and the server still spoke long after
//! ([`MAX_SECONDS`]). Who probes a server waits until he knows, and says so: such a request tries the rule, and one that tries another is left to that one.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Role, Rule, RuleContext, Session, Status,
    env_25, mutant, served, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-07",
        level: Level::Must,
        status: Status::Normative,
        statement: "Each request gets a response, whatever its type.",
        source: source::GENERAL,
        applies_to: "requests over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("Requests of unknown types aren't answered.", |out| {
        if out.refuses_unknown_type() {
            out.message = None;
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a request without an answer",
            make: || Some(Session::new().without("SYS-VER")?.to_bytes()),
            also: &[],
        },
        Mutant {
            name: "a request without an answer after which a probe waits no longer",
            make: || {
                mutant::over("tcp#9", |session| {
                    session.tries(&RULE.rule, "", json!({ "type": "SYS-VER" }));
                })
            },
            also: &[],
        },
    ],
};

/// How long a server may take, in seconds: what takes longer is answered with a receipt.
const MAX_SECONDS: f64 = 30.0;

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(request) = &exchange.request else { return };
    // What is no request of Flockwave needn't have an answer.
    if !request.is_sound || !exchange.record.connection.is_ordered {
        return;
    }
    if let Some((of, _)) = &request.trial {
        // What tries another rule is a matter of that one, but for the one on the order of answers, which says nothing of
        // what has none.
        if of.id == RULE.rule.id {
            served::tried(exchange, context);
        }
        if of.id != env_25::RULE.rule.id {
            return;
        }
    }
    if exchange.role == Role::Response {
        return context.covered();
    }
    let Some(waited) =
        request.waited.filter(|waited| exchange.role == Role::Unanswered && *waited > MAX_SECONDS)
    else {
        return;
    };
    let subject = request.type_name.as_deref().unwrap_or("message");
    context.violation(subject, request.location, || {
        Detail::new(format!("no response, though the server went on speaking for {waited:.0} s"))
            .expected("a response")
            .actual("none")
    });
}
