//! UAV: the fleet (`definitions/flockwave/uav.md`).

use serde_json::{Value, json};

use super::unknown;
use crate::server::hub::{Answer, Call, Hub};
use crate::server::message::{Outcome, Parts};
use crate::server::operation::Operation;
use crate::server::request::{boolean, object, strings};
use crate::server::uav::{Altitude, Command, Target, Uav};

/// How long operations take, in seconds.
const CALIBRATION: f64 = 4.0;
const TEST: f64 = 2.0;
const RESTART: f64 = 3.0;

/// How long a UAV draws attention where nobody says it, in seconds.
const USUAL_SIGNAL: f64 = 5.0;

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    match call.kind {
        "UAV-LIST" => Ok(list(hub)),
        "UAV-INF" => state(hub, call),
        "UAV-PREFLT" => checks(hub, call),
        "UAV-VER" => versions(hub, call),
        "UAV-CALIB" => examine(hub, call, CALIBRATION, &["baro", "compass", "esc", "gyro", "rc"]),
        "UAV-TEST" => examine(hub, call, TEST, &["led", "motor"]),
        "UAV-RST" => restart(hub, call),
        _ => command(hub, call),
    }
}

fn list(hub: &Hub) -> Value {
    let ids: Vec<&String> = hub.world.uavs.iter().map(|uav| &uav.id).collect();
    json!({ "type": "UAV-LIST", "ids": ids })
}

fn no_such() -> String {
    "there is no such UAV".to_owned()
}

fn state(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let ids = strings(call.body, "ids")?;
    let given = call.body["ids"].as_array().map_or(0, Vec::len);
    if hub.breaks("FW-UAV-INF-07") && (given != ids.len() || given == 0) {
        return Err("the ids are empty or not unique".to_owned());
    }
    let mut parts = Parts::new(call.kind, "status");
    for id in ids {
        if hub.uav(&id).is_none() && hub.breaks("FW-UAV-INF-06") {
            return Err(no_such());
        }
        parts.put(&id, hub.uav(&id).map(|uav| Outcome::Value(uav.status())).ok_or_else(no_such));
    }
    Ok(parts.into_body())
}

fn checks(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let mut parts = Parts::new(call.kind, "status");
    for id in strings(call.body, "ids")? {
        let info = hub.uav(&id).map(|uav| Outcome::Value(checks_of(uav)));
        parts.put(&id, info.ok_or_else(no_such));
    }
    Ok(parts.into_body())
}

fn checks_of(uav: &Uav) -> Value {
    let worst = |low: u16, high: u16| uav.codes().iter().any(|code| (low..=high).contains(code));
    let battery = match () {
        () if uav.percentage() < 20 => "failure",
        () if uav.percentage() < 30 => "warning",
        () => "pass",
    };
    let errors = match () {
        () if worst(128, 255) => "failure",
        () if worst(64, 127) => "warning",
        () => "pass",
    };
    let both = [battery, errors];
    let result = ["failure", "warning", "pass"].into_iter().find(|result| both.contains(result));
    json!({
        "result": result.unwrap_or("pass"),
        "items": [
            { "id": "battery", "result": battery, "label": "Battery" },
            { "id": "errors", "result": errors, "label": "Error codes" },
        ],
    })
}

fn versions(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let version = json!({ "simulation": env!("CARGO_PKG_VERSION") });
    each(hub, call, |hub, id| {
        reach(hub, call, id, |_| Ok(()))?.map_or_else(|| Ok(Outcome::Value(version.clone())), Ok)
    })
}

/// Asks each UAV of a request.
fn each(
    hub: &mut Hub,
    call: &Call<'_>,
    mut ask: impl FnMut(&mut Hub, &str) -> Result<Outcome, String>,
) -> Answer {
    let mut parts = Parts::new(call.kind, "result");
    for id in strings(call.body, "ids")? {
        let outcome = ask(hub, &id);
        parts.put(&id, outcome);
    }
    Ok(parts.into_body())
}

/// Tells a UAV something. Nothing is heard of one that sleeps: then this is the receipt under which that will show.
fn reach(
    hub: &mut Hub,
    call: &Call<'_>,
    id: &str,
    tell: impl FnOnce(&mut Uav) -> Result<(), String>,
) -> Result<Option<Outcome>, String> {
    let uav = hub.uav(id).ok_or_else(no_such)?;
    if uav.is_sleeping() && !["UAV-WAKEUP", "UAV-SLEEP"].contains(&call.kind) {
        return hub.start(call.session, Operation::unanswered).map(Outcome::Receipt).map(Some);
    }
    tell(uav).map(|()| None)
}

/// Calibrates or tests a component.
fn examine(hub: &mut Hub, call: &Call<'_>, seconds: f64, components: &[&str]) -> Answer {
    object(call.body, "parameters")?;
    let component = match call.body.get("component") {
        None => "",
        Some(component) => component.as_str().ok_or("component is no string")?,
    };
    each(hub, call, |hub, id| {
        let can = |_: &mut Uav| match component {
            "" => Ok(()),
            known if components.contains(&known) => Ok(()),
            _ => Err(format!("it has no such component: there are {}", components.join(", "))),
        };
        if let Some(outcome) = reach(hub, call, id, can)? {
            return Ok(outcome);
        }
        // Somebody has to turn the UAV while its compass is calibrated.
        let kind = if component == "compass" { Operation::suspending } else { Operation::lasting };
        hub.start(call.session, |receipt| kind(receipt, seconds, json!(true))).map(Outcome::Receipt)
    })
}

fn restart(hub: &mut Hub, call: &Call<'_>) -> Answer {
    transport(call)?;
    let is_whole = match call.body.get("component") {
        None => true,
        Some(component) => component.as_str().ok_or("component is no string")?.is_empty(),
    };
    each(hub, call, |hub, id| {
        let tell = |uav: &mut Uav| {
            if is_whole {
                uav.command(Command::Restart)
            } else {
                Err("it has no components that can be restarted".to_owned())
            }
        };
        if let Some(outcome) = reach(hub, call, id, tell)? {
            return Ok(outcome);
        }
        hub.start(call.session, |receipt| Operation::lasting(receipt, RESTART, json!(true)))
            .map(Outcome::Receipt)
    })
}

/// All commands that a UAV confirms at once.
fn command(hub: &mut Hub, call: &Call<'_>) -> Answer {
    transport(call)?;
    let command = match call.kind {
        "UAV-TAKEOFF" => Command::TakeOff,
        "UAV-LAND" => Command::Land,
        "UAV-RTH" => Command::ReturnHome,
        "UAV-HOVER" => Command::Hover,
        "UAV-HALT" => Command::Halt,
        "UAV-SLEEP" => Command::Sleep,
        "UAV-WAKEUP" => Command::WakeUp,
        "UAV-FLY" => Command::FlyTo(target(call)?),
        "UAV-MOTOR" => Command::Motors {
            is_start: boolean(call.body, "start", None)?,
            is_forced: boolean(call.body, "force", Some(false))?,
        },
        "UAV-SIGNAL" => Command::Signal { seconds: signal(call)? },
        _ => return Err(unknown(call)),
    };
    each(hub, call, |hub, id| {
        let outcome = reach(hub, call, id, |uav| uav.command(command))?;
        Ok(outcome.unwrap_or_else(|| Outcome::Value(json!(true))))
    })
}

fn transport(call: &Call<'_>) -> Result<(), String> {
    let Some(options) = object(call.body, "transport")? else { return Ok(()) };
    boolean(options, "broadcast", Some(false))?;
    boolean(options, "ignoreIds", Some(false))?;
    let is_channel = options.get("channel").is_none_or(Value::is_i64);
    if is_channel { Ok(()) } else { Err("channel is no integer".to_owned()) }
}

fn signal(call: &Call<'_>) -> Result<f64, String> {
    if call.body.contains_key("signals") {
        strings(call.body, "signals")?;
    }
    let Some(duration) = call.body.get("duration") else { return Ok(USUAL_SIGNAL) };
    let duration = duration.as_f64().filter(|duration| (0.0..=3_600_000.0).contains(duration));
    Ok(duration.ok_or("duration is no number from 0 to 3600000")? / 1000.0)
}

fn target(call: &Call<'_>) -> Result<Target, String> {
    let target = call.body.get("target").and_then(Value::as_array).ok_or("target is no list")?;
    if !(2..=5).contains(&target.len()) {
        return Err("target has from two to five elements".to_owned());
    }
    let degrees = |index: usize, limit: i64| {
        let value = target.get(index).and_then(Value::as_i64);
        value.filter(|value| (-limit..=limit).contains(value)).ok_or("target is no place on Earth")
    };
    let altitude = |index: usize| match target.get(index) {
        None | Some(Value::Null) => Ok(None),
        Some(value) => value.as_i64().map(Some).ok_or("an altitude is neither an integer nor null"),
    };
    let [above_sea, above_home, above_ground] = [altitude(2)?, altitude(3)?, altitude(4)?];
    // The ground is flat where the fleet flies.
    let above_home = above_home.or(above_ground).map(Altitude::AboveHome);
    Ok(Target {
        latitude: degrees(0, 900_000_000)?,
        longitude: degrees(1, 1_800_000_000)?,
        altitude: above_home.or(above_sea.map(Altitude::AboveSeaLevel)),
    })
}
