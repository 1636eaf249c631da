//! SHOW: drone shows (`definitions/flockwave/show.md`).

use uavspec_types::flockwave::json::{
    Request, TimeAxisScheduleSegment, TimeAxisScheduleSegmentEndMs, TimeAxisSegmentType, show_cfg,
    show_crth_start, show_lights,
};

use super::unknown;
use crate::hub::{Answer, Hub, SessionId};
use crate::message::{acknowledgment, text};
use crate::uav::Command;

/// The maximum length of a configuration, in bytes.
const MAX_CONFIGURATION: usize = 100_000;

/// The duration of a collective return to home, in milliseconds.
const RETURN: i64 = 60_000;

pub(super) fn answer(hub: &mut Hub, _session: SessionId, request: Request) -> Answer {
    let show = &mut hub.world.show;
    match request {
        Request::ShowCfg(_) => Ok(show_cfg::Response { configuration: show.start.clone() }.into()),
        Request::ShowLights(_) => Ok(show_lights::Response { configuration: show.lights.clone() }.into()),
        Request::ShowSetcfg(request) => set(&mut show.start, request.configuration, |new| text(new).len()),
        Request::ShowSetlights(request) => {
            set(&mut show.lights, request.configuration, |new| text(new).len())
        }
        Request::ShowCrthStart(_) => Ok(return_all(hub).into()),
        other => Err(unknown(&other)),
    }
}

fn set<T>(configuration: &mut T, new: T, length: impl FnOnce(&T) -> usize) -> Answer {
    if length(&new) > MAX_CONFIGURATION {
        return Err(format!("the configuration is longer than {MAX_CONFIGURATION} bytes"));
    }
    *configuration = new;
    Ok(acknowledgment())
}

/// Makes all flying UAVs return home.
fn return_all(hub: &mut Hub) -> show_crth_start::Response {
    for uav in &mut hub.world.uavs {
        // UAVs on the ground and sleeping UAVs refuse the command.
        let _ = uav.command(Command::ReturnHome);
    }
    let start = hub.timestamp().0;
    let segment = TimeAxisScheduleSegment {
        r#type: TimeAxisSegmentType::Rth,
        start_ms: start,
        end_ms: TimeAxisScheduleSegmentEndMs::Integer(start.saturating_add(RETURN)),
        params: None,
    };
    show_crth_start::Response { schedule: vec![segment] }
}
