//! `FW-UAV-INF-08`.
//!
//! If a client sets the server's clock back, the timestamps may decrease. The rule then checks nothing more. A UAV that
//! appears after OBJ-DEL may be another UAV with the same id, so its timestamps are not compared with earlier ones.

use uavspec_flockwave::limits::MAX_ID;
use uavspec_flockwave::session::ConnectionId;
use uavspec_flockwave::session::remembered::ById;

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-INF-08",
    name: "UAV timestamps do not decrease",
    level: Level::Info,
    status: Status::Advisory,
    statement: "The timestamp of a UAV does not decrease.",
    source: source::DERIVED,
    applies_to: "UAV-INF over time",
    why: "Clients ignore states that are older than the current one. The UAV seems to stand still, or \
          jumps back on the map.",
    example: r#"← {"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000}}}
← {"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1789999990000}}}"#,
    fix: "Keep the latest state of each UAV, and drop data that arrives out of order. Do not set the \
          clock back during a flight.",
})
.checks(&[Check::Session(|| Box::new(Latest::default()))])
.bug(Bug::message("Every other timestamp of a UAV is ten seconds too early.", |out| {
    let is_odd = out.number % 2 == 1;
    out.shift_timestamps(|time| if is_odd { time - 10_000 } else { time });
}))
.mutants(&[Mutant::state("a timestamp that goes backwards", |state| {
    state["timestamp"] = 1_789_000_000_000_u64.into();
})]);

/// The memory limit, in bytes.
const MEMORY_LIMIT: usize = 4 << 20;

/// The latest timestamp of each UAV, by its connection and id.
struct Latest(ById<i128>);

impl Default for Latest {
    fn default() -> Self {
        Self(ById::new(MEMORY_LIMIT))
    }
}

impl SessionCheck for Latest {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if !exchange.record.connection.is_ordered || exchange.is_clock_set_back {
            return;
        }
        if exchange.notification("OBJ-DEL").is_some() {
            for uav in reply::listed(exchange).into_iter().flatten() {
                self.0.remove(&(exchange.serial, uav.clone()));
            }
        }
        for (uav, state) in body::members(exchange.body_of("UAV-INF"), "status") {
            if let Some(violation) =
                self.store(exchange.connection_id(), uav, state.get("timestamp"), context)
            {
                exchange.violates(context, || violation);
            }
        }
    }

    fn status_report(&mut self, report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
        if !report.connection().is_ordered || report.is_clock_set_back() {
            return;
        }
        for (uav, timestamp) in report.timestamps() {
            if let Some(violation) = self.store(report.connection_id(), uav, timestamp, context) {
                report.violates(context, || violation);
            }
        }
    }
}

impl Latest {
    /// Stores the timestamp of a UAV. Returns a violation if the previous timestamp is later.
    fn store(
        &mut self,
        connection: ConnectionId,
        uav: &str,
        timestamp: Option<&Tree<'_>>,
        context: &mut RuleContext<'_>,
    ) -> Option<Detail> {
        let now = timestamp.filter(|_| uav.len() <= MAX_ID).and_then(Tree::as_integer)?;
        context.covered();
        let Some(latest) = self.0.get_mut(&(connection.serial, uav.to_owned())) else {
            self.0.insert((connection.serial, uav.to_owned()), now, uav.len());
            return None;
        };
        let before = std::mem::replace(latest, now);
        let path = || pointer(&["body", "status", uav, "timestamp"]);
        (now < before)
            .then(|| Detail::differs(format!("at least {before}, the previous timestamp"), now).at(path()))
    }
}
