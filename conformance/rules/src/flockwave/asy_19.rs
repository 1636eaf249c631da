//! `FW-ASY-19`.
//!
//! An operation may become suspended just before the request. The rule therefore accepts that the operation is resumed
//! if the server has reported it as suspended.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-19",
    name: "Resuming a running operation",
    level: Level::Info,
    status: Status::Advisory,
    statement: "In the response to ASYNC-RESUME, an operation that is not suspended has an entry in `error`.",
    source: source::DERIVED,
    applies_to: "ASYNC-RESUME requests from a probe that tests this rule",
    why: "The client believes that the operation received the values in the request, although the \
          operation was not waiting for any values.",
    example: r#"→ {"type":"UAV-TAKEOFF","ids":["uav-1"]}
← {"type":"UAV-TAKEOFF","receipt":{"uav-1":"r1"}}
→ {"type":"ASYNC-RESUME","ids":["r1"]}
← {"type":"ASYNC-RESUME","success":["r1"]}"#,
    fix: "Check that the operation is suspended before you resume it. If it is not suspended, add an \
          entry to `error`.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::behaviour("Operations that are not suspended can be resumed."))
.mutants(&[
    Mutant::connection("a running operation is resumed", "tcp#9", |session| {
        let resume = json!({ "type": "ASYNC-RESUME", "ids": ["rcpt-30"] });
        let done = json!({ "type": "ASYNC-RESUME", "success": ["rcpt-30"] });

        session.command("rcpt-30");
        session.tries_and_receives(&RULE.rule, "", resume, done);
    }),
    Mutant::refused("the request is refused", "tcp#9"),
]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let is_clear = exchange
        .operations
        .iter()
        .all(|named| named.before.as_ref().is_some_and(|operation| !operation.was_suspended));
    if is_clear {
        served::in_error(exchange, context, &["ASYNC-RESUME"]);
    }
}
