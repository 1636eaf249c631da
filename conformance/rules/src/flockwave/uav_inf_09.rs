//! `FW-UAV-INF-09`.
//!
//! The server time is known from SYS-TIME. Its uncertainty is the response time of that request, and the drift of the
//! clocks since then. After a request that adjusts the clock, the server time is unknown until the server answers the
//! adjustment itself, or a request that it certainly received later. If a client sets the server's clock back, older
//! timestamps may be later than the server time. The rule then checks nothing more.

use uavspec_flockwave::session::seconds;

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-INF-09",
    name: "UAV timestamps are in the past",
    level: Level::Info,
    status: Status::Advisory,
    statement: "The timestamp of a UAV is not later than the server time.",
    source: source::DERIVED,
    applies_to: "UAV-INF over time",
    why: "Clients compute the age of a state from its timestamp. A state from the future never looks \
          outdated, so a lost UAV seems to be connected.",
    example: r#"→ {"type":"SYS-TIME"}
← {"type":"SYS-TIME","timestamp":1790000000000}
← {"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790003600000}}}"#,
    fix: "Set the timestamp from the server clock when the state is received, not from the clock of the UAV.",
})
.checks(&[Check::Exchange(check), Check::StatusReport(check_status_report)])
.bug(Bug::message("The timestamps of UAVs are an hour ahead.", |out| {
    out.shift_timestamps(|time| time + 3_600_000);
}))
.mutants(&[Mutant::state("a timestamp that is a day ahead", |state| {
    state["timestamp"] = 1_790_086_400_000_u64.into();
})]);

/// The tolerance for inaccurate clocks, in seconds.
const TOLERANCE: f64 = 1.0;

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let states = body::members(exchange.body_of("UAV-INF"), "status");
    let timestamps = states.iter().map(|(uav, state)| (uav.as_ref(), state.get("timestamp")));
    let clock = exchange.clock.filter(|_| !exchange.is_clock_set_back);
    for (ahead, uav) in future_timestamps(timestamps, exchange.time, clock, context) {
        exchange.violates(context, || detail(ahead, uav));
    }
}

fn check_status_report(report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
    let clock = report.clock().filter(|_| !report.is_clock_set_back());
    for (ahead, uav) in future_timestamps(report.timestamps(), report.time(), clock, context) {
        report.violates(context, || detail(ahead, uav));
    }
}

/// The UAVs with timestamps later than the server time, and the differences in seconds.
fn future_timestamps<'t>(
    timestamps: impl Iterator<Item = (&'t str, Option<&'t Tree<'t>>)>,
    time: Option<f64>,
    clock: Option<(f64, f64)>,
    context: &mut RuleContext<'_>,
) -> Vec<(f64, &'t str)> {
    let (Some(time), Some((_, offset))) = (time, clock) else { return Vec::new() };
    let stamps = timestamps.filter_map(|(uav, stamp)| Some((seconds(stamp?)?, uav)));
    let ahead = stamps.inspect(|_| context.covered()).map(|(stamp, uav)| (stamp - time - offset, uav));
    ahead.filter(|(ahead, _)| *ahead > TOLERANCE).collect()
}

fn detail(ahead: f64, uav: &str) -> Detail {
    let path = pointer(&["body", "status", uav, "timestamp"]);
    Detail::new(format!("{ahead:.1} s ahead of the server time")).at(path)
}
