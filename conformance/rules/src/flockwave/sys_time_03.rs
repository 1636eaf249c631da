//! `FW-SYS-TIME-03`.
//!
//! The rule compares the server times before and after the adjustment. If the clock has stopped or drifts, it may
//! deviate from the recording clock by up to the elapsed time. This rule accepts such a deviation, which
//! `FW-SYS-TIME-02` reports.

use uavspec_flockwave::session::ClockMove;

use super::prelude::*;
use super::sys_time_02;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-TIME-03",
    name: "Adjustment by 0",
    level: Level::Must,
    status: Status::Normative,
    statement: "An `adjustment` of 0 does not change the server clock.",
    source: source::MESSAGES,
    applies_to: "SYS-TIME over time",
    why: "Clients send 0 just to ask whether the clock can be adjusted. If that query changes the clock, \
          it corrupts the timestamps of a flight in progress.",
    example: r#"→ {"type":"SYS-TIME"}
← {"type":"SYS-TIME","timestamp":1790000000000}
→ {"type":"SYS-TIME","adjustment":0}
← {"type":"SYS-TIME","timestamp":1790003600000}"#,
    fix: "If the adjustment is 0, only check whether the client may set the clock, and return the current \
          time.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::behaviour("An adjustment of 0 sets the clock forward by an hour."))
.mutants(&[
    Mutant::connection("the response to the adjustment is an hour ahead", "tcp#9", |session| {
        adjusts(session, 1);
    }),
    Mutant::connection("the next response is an hour ahead", "tcp#9", |session| adjusts(session, 2)),
]);

/// Adds three responses. From response `first` on, the server clock is an hour ahead.
fn adjusts(session: &mut Session, first: usize) {
    let requests = [json!({}), json!({ "adjustment": 0 }), json!({})];
    for (at, mut request) in requests.into_iter().enumerate() {
        request["type"] = "SYS-TIME".into();
        let ahead = if at < first { 0 } else { 3_600_000 };
        let answer = json!({ "timestamp": session.now() + 40 + ahead });
        session.exchange(request, answer);
    }
}

/// True if an adjustment of 0 changed the clock.
pub(super) fn is_adjusted(found: &ClockMove) -> bool {
    found.is_after_nothing && found.by > sys_time_02::TOLERANCE + found.since
}

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(found) = exchange.clock_move.filter(|found| found.is_after_nothing) else { return };
    context.covered();
    if is_adjusted(&found) {
        exchange.violates(context, || {
            let by = found.by;
            Detail::new(format!("the server clock moved by {by:.1} s after an adjustment of 0"))
                .at("/body/timestamp")
        });
    }
}
