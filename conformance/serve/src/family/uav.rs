//! UAV: the fleet (`definitions/flockwave/uav.md`).

use std::collections::BTreeMap;

use serde_json::json;
use uavspec_rules::flockwave::{uav_inf_06, uav_inf_07, uav_land_01};
use uavspec_runtime::ErrorClass;
use uavspec_types::flockwave::json::{
    CalibrationComponent, GPSCoordinate, ObjectId, PreflightCheckInfo, PreflightCheckItem,
    PreflightCheckResult, Request, uav_calib, uav_fly, uav_halt, uav_hover, uav_inf, uav_land, uav_list,
    uav_motor, uav_preflt, uav_rst, uav_rth, uav_signal, uav_sleep, uav_takeoff, uav_test, uav_ver,
    uav_wakeup,
};

use super::unknown;
use crate::hub::{Answer, Hub, SessionId};
use crate::message::{Outcome, Outcomes};
use crate::operation::Operation;
use crate::uav::{Altitude, Command, Target, Uav};

/// The durations of operations, in seconds.
const CALIBRATION: f64 = 4.0;
const TEST: f64 = 2.0;
const RESTART: f64 = 3.0;

/// The default duration of a signal, in seconds.
const DEFAULT_SIGNAL: f64 = 5.0;

/// The result of a command for each UAV, usually `true` on success.
type CommandResults<T = bool> = Result<Outcomes<Outcome<T>>, String>;

/// Builds the response to a command. All responses to commands have the same three maps.
macro_rules! respond {
    ($body:ident, $outcomes:expr) => {{
        let (result, error, receipt) = $outcomes?.into_maps_with_receipts();
        Ok($body::Response { result, error, receipt }.into())
    }};
}

pub(super) fn answer(hub: &mut Hub, session: SessionId, request: Request) -> Answer {
    let mut execute = |ids, command| execute(hub, session, ids, command);
    match request {
        Request::UavTakeoff(requested) => respond!(uav_takeoff, execute(requested.ids, Command::TakeOff)),
        Request::UavHover(requested) => respond!(uav_hover, execute(requested.ids, Command::Hover)),
        Request::UavHalt(requested) => respond!(uav_halt, execute(requested.ids, Command::Halt)),
        Request::UavSleep(requested) => respond!(uav_sleep, execute(requested.ids, Command::Sleep)),
        Request::UavWakeup(requested) => respond!(uav_wakeup, execute(requested.ids, Command::WakeUp)),
        Request::UavFly(requested) => {
            let command = Command::FlyTo(target(&requested.target)?);
            respond!(uav_fly, execute(requested.ids, command))
        }
        Request::UavMotor(requested) => {
            let is_forced = requested.force.unwrap_or_default();
            let command = Command::Motors { is_start: requested.start, is_forced };
            respond!(uav_motor, execute(requested.ids, command))
        }
        Request::UavSignal(requested) => {
            let command = Command::Signal { seconds: signal(requested.duration)? };
            respond!(uav_signal, execute(requested.ids, command))
        }
        Request::UavLand(requested) => respond!(uav_land, land(hub, session, requested.ids)),
        Request::UavRth(requested) => {
            let is_deaf = hub.has_bug(&uav_land_01::RULE);
            let command = if is_deaf { Command::Hover } else { Command::ReturnHome };
            respond!(uav_rth, self::execute(hub, session, requested.ids, command))
        }
        Request::UavCalib(requested) => {
            let component = requested.component.as_ref();
            let is_there = component.is_none_or(CalibrationComponent::is_known);
            // The UAV must be turned by hand while its compass is calibrated.
            let is_suspending = component == Some(&CalibrationComponent::Compass);
            let kind = if is_suspending { Operation::suspending } else { Operation::lasting };
            let operation = |receipt| kind(receipt, CALIBRATION, json!(true));
            respond!(uav_calib, examine(hub, session, requested.ids, is_there, operation))
        }
        Request::UavTest(requested) => {
            let is_there = requested.component.is_none_or(|component| component.is_known());
            let operation = |receipt| Operation::lasting(receipt, TEST, json!(true));
            respond!(uav_test, examine(hub, session, requested.ids, is_there, operation))
        }
        Request::UavRst(requested) => {
            let is_whole = requested.component.is_none_or(|component| component.is_empty());
            respond!(uav_rst, restart(hub, session, requested.ids, is_whole))
        }
        Request::UavVer(requested) => respond!(uav_ver, versions(hub, session, requested.ids)),
        Request::UavInf(requested) => state(hub, requested.ids),
        Request::UavList(_) => Ok(list(hub).into()),
        Request::UavPreflt(requested) => {
            let outcomes = Outcomes::collect(requested.ids, |id| {
                hub.uav(id).map(|uav| checks(uav)).ok_or_else(no_such)
            })?;
            let (status, error) = outcomes.into_maps();
            Ok(uav_preflt::Response { status, error }.into())
        }
        other => Err(unknown(&other)),
    }
}

fn list(hub: &Hub) -> uav_list::Response {
    uav_list::Response { ids: hub.world.uavs.iter().map(|uav| ObjectId::from(uav.id.as_str())).collect() }
}

fn no_such() -> String {
    "no such UAV".to_owned()
}

fn state(hub: &mut Hub, ids: Vec<ObjectId>) -> Answer {
    if hub.has_bug(&uav_inf_07::RULE) && ids.is_empty() {
        return Err("there must be at least one id".to_owned());
    }
    if hub.has_bug(&uav_inf_06::RULE) && ids.iter().any(|id| hub.uav(&id.0).is_none()) {
        return Err(no_such());
    }
    let outcomes = Outcomes::collect(ids, |id| hub.uav(id).map(|uav| uav.status()).ok_or_else(no_such))?;
    let (status, error) = outcomes.into_maps();
    Ok(uav_inf::Response { status, error }.into())
}

/// The preflight checks of a UAV.
fn checks(uav: &Uav) -> PreflightCheckInfo {
    use PreflightCheckResult::{Failure, Pass, Warning};
    let has_code = |class| uav.codes().iter().any(|code| code.class() == class);
    let battery = match uav.percentage() {
        ..20 => Failure,
        20..30 => Warning,
        _ => Pass,
    };
    let errors = match () {
        () if has_code(ErrorClass::Error) || has_code(ErrorClass::Fatal) => Failure,
        () if has_code(ErrorClass::Warning) => Warning,
        () => Pass,
    };
    let item = |id: &str, label: &str, result| PreflightCheckItem {
        id: id.into(),
        result,
        label: Some(label.to_owned()),
        message: None,
    };
    let worst = [Failure, Warning].into_iter().find(|result| [battery, errors].contains(result));
    PreflightCheckInfo {
        result: worst.unwrap_or(Pass),
        items: vec![item("battery", "Battery", battery), item("errors", "Error codes", errors)],
        message: None,
    }
}

fn versions(
    hub: &mut Hub,
    session: SessionId,
    ids: Vec<ObjectId>,
) -> CommandResults<BTreeMap<String, String>> {
    let version = BTreeMap::from([("simulation".to_owned(), env!("CARGO_PKG_VERSION").to_owned())]);
    Outcomes::collect(ids, |id| call(hub, session, id, |_| Ok(version.clone())))
}

/// Calls a function for a UAV. A sleeping UAV doesn't respond. In that case, the result is the receipt of an operation
/// that times out.
fn call<T>(
    hub: &mut Hub,
    session: SessionId,
    id: &str,
    apply: impl FnOnce(&mut Uav) -> Result<T, String>,
) -> Result<Outcome<T>, String> {
    let uav = hub.uav(id).ok_or_else(no_such)?;
    if uav.is_sleeping() {
        return hub.start(session, Operation::unanswered).map(Outcome::Receipt);
    }
    apply(uav).map(Outcome::Value)
}

/// Starts an operation for each UAV that accepts it.
fn start_each(
    hub: &mut Hub,
    session: SessionId,
    ids: Vec<ObjectId>,
    apply: impl Fn(&mut Uav) -> Result<(), String>,
    operation: impl Fn(String) -> Operation,
) -> CommandResults {
    Outcomes::collect(ids, |id| match call(hub, session, id, &apply)? {
        Outcome::Value(()) => hub.start(session, &operation).map(Outcome::Receipt),
        Outcome::Receipt(receipt) => Ok(Outcome::Receipt(receipt)),
    })
}

/// Calibrates or tests a component.
fn examine(
    hub: &mut Hub,
    session: SessionId,
    ids: Vec<ObjectId>,
    is_there: bool,
    operation: impl Fn(String) -> Operation,
) -> CommandResults {
    let can = |_: &mut Uav| if is_there { Ok(()) } else { Err("no such component".to_owned()) };
    start_each(hub, session, ids, can, operation)
}

fn restart(hub: &mut Hub, session: SessionId, ids: Vec<ObjectId>, is_whole: bool) -> CommandResults {
    let apply = |uav: &mut Uav| {
        if is_whole { uav.command(Command::Restart) } else { Err("no component can be restarted".to_owned()) }
    };
    start_each(hub, session, ids, apply, |receipt| Operation::lasting(receipt, RESTART, json!(true)))
}

/// Executes a command that UAVs confirm immediately.
fn execute(hub: &mut Hub, session: SessionId, ids: Vec<ObjectId>, command: Command) -> CommandResults {
    // Sleeping UAVs receive these commands as well.
    let is_always_received = matches!(command, Command::Sleep | Command::WakeUp);
    let apply = |uav: &mut Uav| uav.command(command).map(|()| true);
    Outcomes::collect(ids, |id| match hub.uav(id) {
        Some(uav) if is_always_received => apply(uav).map(Outcome::Value),
        _ => call(hub, session, id, apply),
    })
}

/// Lands UAVs. With the FW-UAV-LAND-01 bug, each UAV ignores the first UAV-LAND of a flight.
fn land(hub: &mut Hub, session: SessionId, ids: Vec<ObjectId>) -> CommandResults {
    let is_deaf = hub.has_bug(&uav_land_01::RULE);
    Outcomes::collect(ids, |id| {
        let is_flying = hub.uav(id).is_some_and(|uav| uav.is_flying());
        if is_deaf && is_flying && hub.deaf.insert(id.to_owned()) {
            return Ok(Outcome::Value(true));
        }
        hub.deaf.remove(id);
        call(hub, session, id, |uav| uav.command(Command::Land).map(|()| true))
    })
}

/// Converts the duration of a signal to seconds. The default applies if there is none.
fn signal(milliseconds: Option<f64>) -> Result<f64, String> {
    let Some(duration) = milliseconds else { return Ok(DEFAULT_SIGNAL) };
    let is_possible = (0.0..=3_600_000.0).contains(&duration);
    if is_possible { Ok(duration / 1000.0) } else { Err("expected a duration from 0 to 3600000".to_owned()) }
}

fn target(target: &GPSCoordinate) -> Result<Target, String> {
    if !target.latitude.is_in_range() || !target.longitude.is_in_range() {
        return Err("expected a valid latitude and longitude in target".to_owned());
    }
    // The terrain of the simulation is flat.
    let above_home = target.ahl.or(target.agl).map(Altitude::AboveHome);
    Ok(Target {
        latitude: target.latitude.0,
        longitude: target.longitude.0,
        altitude: above_home.or(target.amsl.map(Altitude::AboveSeaLevel)),
    })
}
