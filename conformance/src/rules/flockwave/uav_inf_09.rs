//! `FW-UAV-INF-09`.
//!
//! The time of the server is known from SYS-TIME, as far as it can be: up to the time that its answer took.

use super::{Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};
use crate::flockwave::session::seconds;
use crate::json::pointer;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-09",
        level: Level::Info,
        status: Status::Advisory,
        statement: "The timestamp of a UAV isn't after the time of the server.",
        source: fw::DERIVED,
        applies_to: "UAV-INF over time",
    },
    check: Check::Context(judge),
    covers: &[],
    bug: Bug::message("Time stamps lie an hour ahead.", |out| {
        out.shift_timestamps(|time| time + 3_600_000);
    }),
    trial: None,
    mutants: &[Mutant {
        name: "a state of tomorrow",
        make: || fw::state(|kite| kite["timestamp"] = 1_790_086_400_000_u64.into()),
        also: &[],
    }],
};

/// How much clocks may have drifted apart since, in seconds.
const TOLERANCE: f64 = 1.0;

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let (Some(time), Some((_, ahead))) = (exchange.time, exchange.clock) else { return };
    for (uav, state) in fw::states(exchange, "UAV-INF") {
        let Some(stamp) = state.get("timestamp").and_then(seconds) else { continue };
        context.covered();
        let early = stamp - time - ahead;
        if early > TOLERANCE {
            exchange.breaks(context, || {
                Detail::new(format!("{early:.1} s after the time of the server")).at(pointer(&[
                    "body",
                    "status",
                    uav,
                    "timestamp",
                ]))
            });
        }
    }
}
