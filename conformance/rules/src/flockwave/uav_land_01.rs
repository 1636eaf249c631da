//! `FW-UAV-LAND-01`.
//!
//! The rule applies only if the UAV is far above its home position, reports new states in responses to UAV-INF, and
//! receives no other command. A UAV may take some time to stop its climb. Each state is therefore compared with the
//! greatest height since the command.

use std::collections::BTreeMap;

use super::prelude::*;
use crate::limits::MAX_UAVS;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-LAND-01",
    name: "UAVs that accept UAV-LAND descend",
    level: Level::Should,
    status: Status::Advisory,
    statement: "A UAV in the air begins to descend within 3 s after the server accepts UAV-LAND for it.",
    source: source::DERIVED,
    applies_to: "UAV-LAND, UAV-INF over time",
    why: "The operator believes that the UAV is landing, but it keeps flying.",
    example: r#"→ {"type":"UAV-LAND","ids":["uav-1"]}
← {"type":"UAV-LAND","result":{"uav-1":true}}
← {"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000}}}
(4 s later)
→ {"type":"UAV-INF","ids":["uav-1"]}
← {"type":"UAV-INF","status":{"uav-1":{"timestamp":1790000004000,"position":[0,0,null,9000]}}}"#,
    fix: "Make UAV-LAND end the takeoff and every other activity, or refuse the command in `error` while \
          the UAV can't land.",
})
.checks(&[Check::Session(|| Box::new(Descents::default()))])
.bug(Bug::behaviour(
    "A UAV ignores the first UAV-LAND of a flight, which the server accepts. After UAV-RTH, the UAV \
     only hovers.",
))
.mutants(&[Mutant::connection("a UAV that keeps its height after UAV-LAND", "tcp#9", |session| {
    session.lands(json!({ "result": { "kite": true } }), &[9_000, 10_000, 10_000, 10_000]);
})]);

/// The time for a UAV to begin to descend, in seconds.
const REACTION: f64 = 3.0;

/// The minimum height above the home position from which a UAV has to descend, and the loss of height that counts as a
/// descent, both in mm.
const IN_AIR: i128 = 1_500;
const DESCENT: i128 = 200;

/// The speed in mm/s above which a UAV moves sideways.
const SIDEWAYS: u128 = 500;

/// The commands that end the validity of an earlier UAV-LAND.
const COMMANDS: [&str; 9] = [
    "UAV-FLY",
    "UAV-HALT",
    "UAV-HOVER",
    "UAV-MOTOR",
    "UAV-RST",
    "UAV-RTH",
    "UAV-SLEEP",
    "UAV-TAKEOFF",
    "SHOW-CRTH-START",
];

/// A UAV after UAV-LAND.
struct Landing {
    /// The time since which the command is accepted; `None` until then.
    accepted: Option<f64>,
    /// The receipt of the operation, until its end.
    receipt: Option<String>,
    /// The first timestamp since the command was accepted.
    first: Option<i128>,
    /// The greatest height in mm since the command was accepted.
    highest: Option<i128>,
}

/// The UAVs after UAV-LAND, by connection.
#[derive(Default)]
struct Descents(PerConnection<BTreeMap<String, Landing>>);

impl SessionCheck for Descents {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        let landings = self.0.get(exchange);
        let Some(now) = exchange.time.filter(|_| exchange.record.connection.is_ordered) else {
            return landings.clear();
        };
        if exchange.role == Role::Request && exchange.type_name.is_some_and(|name| COMMANDS.contains(&name)) {
            // The command may concern any UAV.
            return landings.clear();
        }
        accept(landings, exchange, now);
        for (uav, state) in body::members(exchange.body_of("UAV-INF"), "status") {
            let Some(landing) = landings.get_mut(uav.as_ref()) else { continue };
            let progress = landing.see(state, now, context);
            if !matches!(progress, Progress::Undecided) {
                landings.remove(uav.as_ref());
            }
            if let Progress::Ignored { height } = progress {
                let path = || pointer(&["body", "status", uav, "position", "3"]);
                exchange.violates(context, || {
                    Detail::new(format!("{} accepted UAV-LAND but did not descend", body::quoted(uav)))
                        .expected(format!("a descent within {REACTION} s"))
                        .actual(format!("a height of {height} mm"))
                        .at(path())
                });
            }
        }
    }

    fn status_report(&mut self, report: &StatusReport<'_>, _: &mut RuleContext<'_>) {
        let landings = self.0.at(report.connection_id());
        if landings.is_empty() {
            return;
        }
        for (uav, timestamp) in report.timestamps() {
            let landing = landings.get_mut(uav).filter(|landing| landing.accepted.is_some());
            if let (Some(landing), Some(Tree::Int(timestamp))) = (landing, timestamp) {
                landing.first.get_or_insert(*timestamp);
            }
        }
    }

    fn corruption(&mut self, _: Location) {
        self.0.clear();
    }
}

/// Updates the UAVs whose UAV-LAND is accepted or refused by a response or by the end of an operation.
fn accept(landings: &mut BTreeMap<String, Landing>, exchange: &Exchange<'_>, now: f64) {
    let answer = exchange.body_of("UAV-LAND").filter(|_| exchange.role == Role::Response);
    for (uav, result) in body::members(answer, "result") {
        let is_refused = *result == Tree::Bool(false);
        add(landings, uav, (!is_refused).then_some(now), None);
    }
    for (uav, receipt) in body::members(answer, "receipt") {
        add(landings, uav, None, receipt.as_str());
    }
    for (uav, _) in body::members(answer, "error") {
        landings.remove(uav.as_ref());
    }
    let has_failed = exchange.type_name != Some("ASYNC-RESP")
        || body::is_present(exchange.field("error"))
        || exchange.field("result") == Some(&Tree::Bool(false));
    for named in exchange.operations.iter().filter(|_| exchange.type_name != Some("ASYNC-ST")) {
        for landing in
            landings.values_mut().filter(|landing| landing.receipt.as_ref() == Some(&named.receipt))
        {
            (landing.receipt, landing.accepted) = (None, (!has_failed).then_some(now));
        }
    }
}

/// Adds a UAV, unless an earlier UAV-LAND has not been obeyed yet.
fn add(landings: &mut BTreeMap<String, Landing>, uav: &str, accepted: Option<f64>, receipt: Option<&str>) {
    let is_known = landings.get(uav).is_some_and(|landing| landing.accepted.is_some());
    if is_known || landings.len() >= MAX_UAVS || accepted.or(receipt.map(|_| 0.0)).is_none() {
        return;
    }
    landings.insert(
        uav.to_owned(),
        Landing { accepted, receipt: receipt.map(str::to_owned), first: None, highest: None },
    );
}

/// The effect of a UAV-LAND command.
enum Progress {
    /// Later states decide.
    Undecided,
    /// The UAV descends, or its states don't show that it doesn't.
    Settled,
    /// The UAV hasn't descended from this height in mm.
    Ignored { height: i128 },
}

impl Landing {
    /// Processes a state of the UAV. Returns the progress of the landing that it shows.
    fn see(&mut self, state: &Tree<'_>, now: f64, context: &mut RuleContext<'_>) -> Progress {
        let Some(since) = self.accepted else { return Progress::Undecided };
        let Some((timestamp, height)) = timestamp_and_height(state) else { return Progress::Settled };
        let first = *self.first.get_or_insert(timestamp);
        let highest = height.max(self.highest.unwrap_or(height));
        self.highest = Some(highest);
        if height <= IN_AIR {
            // The UAV may be on the ground, or may have started to climb.
            return if now - since < REACTION { Progress::Undecided } else { Progress::Settled };
        }
        let has_descended = highest.saturating_sub(height) >= DESCENT;
        if !has_descended && (now - since < REACTION || timestamp <= first || is_braking(state)) {
            return Progress::Undecided;
        }
        context.covered();
        if has_descended { Progress::Settled } else { Progress::Ignored { height } }
    }
}

/// True if a UAV still moves sideways. It may have to stop before it descends.
fn is_braking(state: &Tree<'_>) -> bool {
    let Some(Tree::List(velocity)) = state.get("velocity") else { return false };
    velocity.iter().take(2).any(|part| matches!(part, Tree::Int(speed) if speed.unsigned_abs() > SIDEWAYS))
}

/// The timestamp of a state, and the height above the home position in mm.
fn timestamp_and_height(state: &Tree<'_>) -> Option<(i128, i128)> {
    let (Some(Tree::Int(timestamp)), Some(Tree::List(position))) =
        (state.get("timestamp"), state.get("position"))
    else {
        return None;
    };
    match position.get(3) {
        Some(Tree::Int(height)) => Some((*timestamp, *height)),
        _ => None,
    }
}
