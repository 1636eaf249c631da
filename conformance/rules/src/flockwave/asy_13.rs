//! `FW-ASY-13`.
//!
//! A recording shows a violation only if a client resumes an operation that was never announced as suspended. Some
//! servers also accept ASYNC-RESUME for operations that are not suspended. The rule therefore requires that the server
//! has refused to resume the operation before.

use super::asy_19;
use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-13",
    name: "Suspension is reported",
    level: Level::Must,
    status: Status::Normative,
    statement: "When an operation is suspended, the server sends ASYNC-ST with `suspended` set to true.",
    source: source::ASYNC,
    applies_to: "ASYNC-RESUME over time",
    why: "Without this notification, the client does not know that it must resume the operation. The \
          operation then stays pending.",
    example: r#"→ {"type":"UAV-TAKEOFF","ids":["uav-1"]}
← {"type":"UAV-TAKEOFF","receipt":{"uav-1":"r1"}}
→ {"type":"ASYNC-RESUME","ids":["r1"]}
← {"type":"ASYNC-RESUME","error":{"r1":"Not suspended"}}
→ {"type":"ASYNC-RESUME","ids":["r1"]}
← {"type":"ASYNC-RESUME","success":["r1"]}"#,
    fix: "Send ASYNC-ST with `suspended` set to true as soon as the operation starts waiting for the client.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::message("ASYNC-ST has no `suspended`.", |out| {
    if let Some(body) = out.body_of("ASYNC-ST").and_then(Value::as_object_mut) {
        body.remove("suspended");
    }
}))
.mutants(&[Mutant::connection("a suspended operation without a notification", "tcp#9", |session| {
    let resume = || json!({ "type": "ASYNC-RESUME", "ids": ["rcpt-60"] });
    session.command("rcpt-60");
    session.exchange(resume(), json!({ "error": { "rcpt-60": "It isn't suspended" } }));
    session.exchange(resume(), json!({ "success": ["rcpt-60"] }));
})]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    // If a probe resumes an operation that is not suspended, FW-ASY-19 checks the request.
    if exchange.response("ASYNC-RESUME").is_none() || exchange.tried(&asy_19::RULE.rule).is_some() {
        return;
    }
    for named in exchange.operations.iter().filter(|named| named.is_known) {
        let Some(operation) = named.before.as_ref().filter(|known| known.stage != Stage::Early) else {
            continue;
        };
        if !operation.was_suspended && !operation.has_refused_resume {
            continue;
        }
        context.covered();
        if !operation.was_suspended {
            exchange.violates(context, || {
                Detail::new(format!(
                    "{} was resumed, but no ASYNC-ST reported it as suspended",
                    body::quoted(&named.receipt)
                ))
                .at("/body/success")
            });
        }
    }
}
