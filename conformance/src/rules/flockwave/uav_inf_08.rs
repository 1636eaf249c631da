//! `FW-UAV-INF-08`.

use super::{
    Bug, Check, Checker, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, Tree, fw,
};
use crate::flockwave::session::ids::Ids;
use crate::json::pointer;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-08",
        level: Level::Info,
        status: Status::Advisory,
        statement: "The timestamp of a UAV doesn't go back.",
        source: fw::DERIVED,
        applies_to: "UAV-INF over time",
    },
    check: Check::State(|| Box::new(Latest::default())),
    covers: &[],
    bug: Bug::message("Every other time stamp lies ten seconds back.", |out| {
        let is_odd = out.number % 2 == 1;
        out.shift_timestamps(|time| if is_odd { time - 10_000 } else { time });
    }),
    trial: None,
    mutants: &[Mutant {
        name: "it goes back",
        make: || fw::state(|kite| kite["timestamp"] = 1_789_000_000_000_u64.into()),
        also: &[],
    }],
};

/// How much is kept, in bytes.
const LIMIT: usize = 4 << 20;

/// The longest id that is kept, in bytes: 64 characters of up to four.
const MAX_ID: usize = 256;

/// The latest timestamp of each UAV, by its connection and id.
struct Latest(Ids<i128>);

impl Default for Latest {
    fn default() -> Self {
        Self(Ids::new(LIMIT))
    }
}

impl Checker for Latest {
    fn exchanged(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if !exchange.record.connection.is_told {
            return;
        }
        for (uav, state) in fw::states(exchange, "UAV-INF") {
            let Some(Tree::Int(now)) = state.get("timestamp") else { continue };
            if uav.len() > MAX_ID {
                continue;
            }
            context.covered();
            match self.0.get_mut(exchange.serial, uav) {
                None => self.0.insert(exchange.serial, uav, *now, uav.len()),
                Some(latest) => {
                    let before = std::mem::replace(latest, *now);
                    if *now < before {
                        exchange.breaks(context, || {
                            Detail::differs(format!("{before} or more, as before"), now).at(pointer(&[
                                "body",
                                "status",
                                uav,
                                "timestamp",
                            ]))
                        });
                    }
                }
            }
        }
    }
}
