//! `FW-VAL-01`.
//!
//! The specification sets no limits for these values, except that timestamps count from 1970. The rule's limits are so
//! wide that only a wrong unit or a wrong epoch exceeds them.

use super::prelude::*;
use super::uav_inf_08;

pub(crate) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-VAL-01",
    name: "Plausible values",
    level: Level::Should,
    status: Status::Advisory,
    statement: "Timestamps are from 2001 to 2099. In the state of a UAV, the battery voltage is at most 1 \
                kV, altitudes are from -20 km to 100 km, and velocities are at most 10 km/s in each \
                direction.",
    source: source::DERIVED,
    applies_to: "messages from the server",
    why: "An implausible value usually has the wrong unit. A timestamp in seconds, or in milliseconds \
          since the server started, makes current data look decades old.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000}}}"#,
    fix: "Send timestamps in milliseconds since 1970, in UTC. Check the units of the other values.",
})
.checks(&[
    Check::Message(check_values),
    Check::Exchange(check_timestamps),
    Check::StatusReport(check_status_report),
])
.bug(Bug::message("The battery voltage of a UAV is in microvolts.", |out| {
    out.set_in_state("battery", json!([11_800_000, 84]));
}))
.mutants(&[
    Mutant::state("a timestamp in seconds", |state| state["timestamp"] = json!(1_790_000_000))
        .also(&[&uav_inf_08::RULE.rule]),
    Mutant::connection("a server time measured from the start of the server", "tcp#9", |session| {
        session.exchange(json!({ "type": "SYS-TIME" }), json!({ "timestamp": 1 }));
    }),
    Mutant::notice("a connection timestamp in seconds", "CONN-INF", |body| {
        body["status"]["winch"]["timestamp"] = 1_790_000_000.into();
    }),
    Mutant::state("a voltage in microvolts", |state| state["battery"] = json!([11_800_000, 84])),
    Mutant::state("an altitude in nanometres", |state| {
        state["position"] = json!([465_410_000, 115_520_000, 812_000_000_000_i64]);
    }),
    Mutant::state("a velocity in micrometres per second", |state| {
        state["velocity"] = json!([0, -20_000_000, 0]);
    }),
]);

/// The range of plausible timestamps in milliseconds, from 2001-01-01 up to 2100-01-01.
pub(super) const TIMES: (i64, i64) = (978_307_200_000, 4_102_444_800_000);

/// The range of plausible altitudes, in mm.
const ALTITUDES: (i64, i64) = (-20_000_000, 100_000_000);

/// The range of plausible velocity components, in mm/s.
const VELOCITIES: (i64, i64) = (-10_000_000, 10_000_000);

/// The plausible values in UAV states: the field, the index of the element, and the range.
const VALUES: [(&str, usize, (i64, i64)); 10] = [
    ("battery", 0, (0, 10_000)),
    ("position", 2, ALTITUDES),
    ("position", 3, ALTITUDES),
    ("position", 4, ALTITUDES),
    ("velocity", 0, VELOCITIES),
    ("velocity", 1, VELOCITIES),
    ("velocity", 2, VELOCITIES),
    ("velocityXYZ", 0, VELOCITIES),
    ("velocityXYZ", 1, VELOCITIES),
    ("velocityXYZ", 2, VELOCITIES),
];

/// The message types with a `timestamp` in the body or in each state. `FW-WTH-01` checks the timestamps of weather data.
const TIMED: [&str; 5] = ["BCN-INF", "CONN-INF", "DOCK-INF", "SYS-TIME", "UAV-INF"];

/// The range of plausible values for an element of a field in UAV states.
pub fn plausible(field: &str, index: usize) -> Option<(i64, i64)> {
    VALUES.iter().find(|(name, at, _)| *name == field && *at == index).map(|(.., range)| *range)
}

/// Checks the values in UAV states, except timestamps.
fn check_values(message: &Message<'_>, context: &mut RuleContext<'_>) {
    for (uav, state) in body::states(message, "UAV-INF") {
        context.covered();
        for (name, index, range) in VALUES {
            let Some(Tree::List(values)) = state.get(name) else { continue };
            let Some(value) = values.get(index).filter(|value| !is_within(value, range)) else { continue };
            message.violates_in(name, context, || {
                let path = pointer(&["body", "status", uav, name, &index.to_string()]);
                Detail::differs(format!("a value from {} to {}", range.0, range.1), value).at(path)
            });
        }
    }
}

/// Checks the timestamps in messages other than status reports.
fn check_timestamps(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let is_timed = exchange.type_name.is_some_and(|name| TIMED.contains(&name));
    if !is_timed || exchange.message().is_none() {
        return;
    }
    let states = body::members(exchange.body, "status").iter();
    let states = states.map(|(id, state)| (pointer(&["body", "status", id]), state));
    let body = exchange.body.map(|body| ("/body".to_owned(), body));
    for (path, holder) in states.chain(body) {
        if let Some(detail) = implausible_time(holder.get("timestamp"), context) {
            exchange.violates_in("timestamp", context, || detail.at(path + "/timestamp"));
        }
    }
}

/// Checks the timestamps in a status report.
fn check_status_report(report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
    for (uav, timestamp) in report.timestamps() {
        if let Some(detail) = implausible_time(timestamp, context) {
            let path = pointer(&["body", "status", uav, "timestamp"]);
            report.violates_in("timestamp", context, || detail.at(path));
        }
    }
}

/// The violation of a timestamp, if any. Other rules report a value that is not a number.
fn implausible_time(value: Option<&Tree<'_>>, context: &mut RuleContext<'_>) -> Option<Detail> {
    let value = value?;
    context.covered();
    let wrong = || Detail::differs("milliseconds since 1970, from 2001 to 2099", value);
    (!is_within(value, TIMES)).then(wrong)
}

/// True if a value is within a range, or is not a number.
pub(super) fn is_within(value: &Tree<'_>, (low, high): (i64, i64)) -> bool {
    #[allow(clippy::cast_precision_loss)] // the limits are small enough
    match value {
        Tree::Int(value) => (i128::from(low)..=i128::from(high)).contains(value),
        Tree::Float(value, _) => (low as f64..=high as f64).contains(value),
        Tree::Huge(_) => false,
        _ => true,
    }
}
