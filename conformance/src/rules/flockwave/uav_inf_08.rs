//! `FW-UAV-INF-08`.

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, SessionCheck, Status,
    StatusReport, Tree, body, mutant, source,
};
use crate::flockwave::session::ConnectionId;
use crate::flockwave::session::ids::Ids;
use crate::json::pointer;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-08",
        level: Level::Info,
        status: Status::Advisory,
        statement: "The timestamp of a UAV doesn't go back.",
        source: source::DERIVED,
        applies_to: "UAV-INF over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Session(|| Box::new(Latest::default()))],
    covers: &[],
    bug: Bug::message("Every other time stamp lies ten seconds back.", |out| {
        let is_odd = out.number % 2 == 1;
        out.shift_timestamps(|time| if is_odd { time - 10_000 } else { time });
    }),
    trial: None,
    mutants: &[Mutant {
        name: "it goes back",
        make: || mutant::state(|kite| kite["timestamp"] = 1_789_000_000_000_u64.into()),
        also: &[],
    }],
};

/// How much is kept, in bytes.
const MEMORY_LIMIT: usize = 4 << 20;

/// The longest id that is kept, in bytes: 64 characters of up to four.
const MAX_ID: usize = 256;

/// The latest timestamp of each UAV, by its connection and id.
struct Latest(Ids<i128>);

impl Default for Latest {
    fn default() -> Self {
        Self(Ids::new(MEMORY_LIMIT))
    }
}

impl SessionCheck for Latest {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if !exchange.record.connection.is_ordered {
            return;
        }
        for (uav, state) in body::members(exchange.body_of("UAV-INF"), "status") {
            if let Some(before) = self.later(exchange.connection_id(), uav, state.get("timestamp"), context) {
                exchange.violates(context, || before);
            }
        }
    }

    fn status_report(&mut self, report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
        if !report.connection().is_ordered {
            return;
        }
        for (uav, timestamp) in report.timestamps() {
            if let Some(before) = self.later(report.connection_id(), uav, timestamp, context) {
                report.violates(context, || before);
            }
        }
    }
}

impl Latest {
    /// Keeps the timestamp of a UAV; a violation if a later one precedes it.
    fn later(
        &mut self,
        connection: ConnectionId,
        uav: &str,
        timestamp: Option<&Tree<'_>>,
        context: &mut RuleContext<'_>,
    ) -> Option<Detail> {
        let Some(Tree::Int(now)) = timestamp.filter(|_| uav.len() <= MAX_ID) else { return None };
        context.covered();
        let Some(latest) = self.0.get_mut(connection.serial, uav) else {
            self.0.insert(connection.serial, uav, *now, uav.len());
            return None;
        };
        let before = std::mem::replace(latest, *now);
        let path = || pointer(&["body", "status", uav, "timestamp"]);
        (*now < before).then(|| Detail::differs(format!("{before} or more, as before"), now).at(path()))
    }
}
