//! `FW-UAV-INF-09`.
//!
//! The time of the server is known from SYS-TIME, as far as it can be: up to the time that its answer took.

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, StatusReport,
    Tree, body, mutant, source,
};
use crate::flockwave::session::seconds;
use crate::json::pointer;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-09",
        level: Level::Info,
        status: Status::Advisory,
        statement: "The timestamp of a UAV isn't after the time of the server.",
        source: source::DERIVED,
        applies_to: "UAV-INF over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check), Check::StatusReport(check_status_report)],
    covers: &[],
    bug: Bug::message("Time stamps lie an hour ahead.", |out| {
        out.shift_timestamps(|time| time + 3_600_000);
    }),
    trial: None,
    mutants: &[Mutant {
        name: "a state of tomorrow",
        make: || mutant::state(|kite| kite["timestamp"] = 1_790_086_400_000_u64.into()),
        also: &[],
    }],
};

/// How much clocks may have drifted apart since, in seconds.
const TOLERANCE: f64 = 1.0;

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let states = body::members(exchange.body_of("UAV-INF"), "status");
    let timestamps = states.iter().map(|(uav, state)| (uav.as_ref(), state.get("timestamp")));
    for (early, uav) in too_early(timestamps, exchange.time, exchange.clock, context) {
        exchange.violates(context, || detail(early, uav));
    }
}

fn check_status_report(report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
    for (early, uav) in too_early(report.timestamps(), report.time(), report.clock(), context) {
        report.violates(context, || detail(early, uav));
    }
}

/// The timestamps that are after the time of the server: by how much, in seconds, and of which UAV.
fn too_early<'t>(
    timestamps: impl Iterator<Item = (&'t str, Option<&'t Tree<'t>>)>,
    time: Option<f64>,
    clock: Option<(f64, f64)>,
    context: &mut RuleContext<'_>,
) -> Vec<(f64, &'t str)> {
    let (Some(time), Some((_, ahead))) = (time, clock) else { return Vec::new() };
    let stamps = timestamps.filter_map(|(uav, stamp)| Some((seconds(stamp?)?, uav)));
    let early = stamps.inspect(|_| context.covered()).map(|(stamp, uav)| (stamp - time - ahead, uav));
    early.filter(|(early, _)| *early > TOLERANCE).collect()
}

fn detail(early: f64, uav: &str) -> Detail {
    let path = pointer(&["body", "status", uav, "timestamp"]);
    Detail::new(format!("{early:.1} s after the time of the server")).at(path)
}
