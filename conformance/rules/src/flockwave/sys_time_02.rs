//! `FW-SYS-TIME-02`.
//!
//! After a request that adjusts the clock, the offset is unknown until the server answers the adjustment itself, or a
//! request that it certainly received later. `FW-SYS-TIME-03` checks adjustments of 0.

use uavspec_flockwave::session::ClockMove;

use super::prelude::*;
use super::{sys_time_03, uav_inf_09};

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-TIME-02",
    name: "Steady server clock",
    level: Level::Info,
    status: Status::Advisory,
    statement: "From one SYS-TIME response to the next, the server clock advances by the time that has \
                passed, without jumping or stopping.",
    source: source::DERIVED,
    applies_to: "SYS-TIME over time",
    why: "Clients use the offset to compare timestamps with their own clock. If the offset changes, the \
          age of all UAV states is wrong.",
    example: r#"→ {"type":"SYS-TIME"}
← {"type":"SYS-TIME","timestamp":1790000000000}
(10 s later)
→ {"type":"SYS-TIME"}
← {"type":"SYS-TIME","timestamp":1790000000000}"#,
    fix: "Read the system clock for every SYS-TIME request, and synchronize that clock without jumps, for \
          example with NTP.",
})
.checks(&[Check::Exchange(check)])
.bug(
    Bug::message("The server clock does not advance.", |out| {
        out.set("SYS-TIME", "timestamp", json!(1_700_000_000_000_u64));
    })
    .also(&[&uav_inf_09::RULE.rule]),
)
.mutants(&[
    Mutant::session("a clock that jumps forward", |session| {
        session.exchange(json!({ "type": "SYS-TIME" }), json!({ "timestamp": 1_800_000_000_000_u64 }));
    }),
    Mutant::session("a clock that jumps back", |session| {
        session.exchange(json!({ "type": "SYS-TIME" }), json!({ "timestamp": 1_780_000_000_000_u64 }));
    }),
]);

/// The tolerance for inaccurate clocks, in seconds.
pub(super) const TOLERANCE: f64 = 1.0;

/// True if the server's clock moved without an adjustment.
fn is_moved(found: &ClockMove) -> bool {
    found.by > TOLERANCE && !sys_time_03::is_adjusted(found)
}

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(found) = exchange.clock_move else { return };
    context.covered();
    if is_moved(&found) {
        exchange.violates(context, || {
            let by = found.by;
            Detail::new(format!("the server clock moved by {by:.1} s relative to the capture's clock"))
                .at("/body/timestamp")
        });
    }
}

#[cfg(test)]
mod tests {
    use super::{ClockMove, is_moved, sys_time_03};

    #[test]
    fn a_clock_may_deviate_by_a_second() {
        // A clock that stands still moves back by the time since the previous answer.
        for (by, is_after_nothing, expected) in [
            (1.0, false, (true, false)),
            (1.5, false, (false, false)),
            (1.5, true, (false, false)),
            (4.0, true, (false, false)),
            (4.5, true, (true, true)),
            (4.5, false, (false, false)),
        ] {
            let found = ClockMove { by, since: 3.0, is_after_nothing };
            assert_eq!((!is_moved(&found), sys_time_03::is_adjusted(&found)), expected, "{found:?}");
        }
    }
}
