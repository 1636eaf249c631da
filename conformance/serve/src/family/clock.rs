//! CLK: clocks (`definitions/flockwave/clk.md`).

use uavspec_types::flockwave::json::{ClockId, ClockInfo, Request, clk_inf, clk_list};

use super::unknown;
use crate::hub::{Answer, Hub, SessionId};
use crate::message::Outcomes;

/// The id of the server's clock.
pub(super) const SYSTEM: &str = "system";

/// All clocks: the server clock and a simulated clock.
const CLOCKS: [&str; 2] = [SYSTEM, "simulation"];

pub(super) fn answer(hub: &mut Hub, _session: SessionId, request: Request) -> Answer {
    match request {
        Request::ClkList(_) => Ok(clk_list::Response { ids: CLOCKS.map(ClockId::from).into() }.into()),
        Request::ClkInf(request) => {
            let outcomes = Outcomes::collect(request.ids, |id| match id {
                SYSTEM => Ok(system(hub)),
                "simulation" => Ok(simulation(hub)),
                _ => Err("no such clock".to_owned()),
            })?;
            let (status, error) = outcomes.into_maps();
            Ok(clk_inf::Response { status, error }.into())
        }
        other => Err(unknown(&other)),
    }
}

/// The state of the server's clock.
pub(super) fn system(hub: &Hub) -> ClockInfo {
    let now = hub.timestamp();
    #[expect(clippy::cast_precision_loss, reason = "no server runs long enough for times to lose precision")]
    let ticks = now.0 as f64;
    ClockInfo {
        id: SYSTEM.into(),
        retrieved_at: now,
        running: true,
        ticks,
        ticks_per_second: Some(1000.0),
        epoch: Some("unix".into()),
    }
}

fn simulation(hub: &Hub) -> ClockInfo {
    ClockInfo {
        id: "simulation".into(),
        retrieved_at: hub.timestamp(),
        running: true,
        ticks: hub.elapsed.as_secs_f64() * hub.options.speed,
        ..ClockInfo::default()
    }
}
