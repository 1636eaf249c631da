//! OBJ: whatever the server keeps track of (`definitions/flockwave/obj.md`).

use serde_json::{Value, json};

use super::unknown;
use crate::server::error_code::settable;
use crate::server::hub::{Answer, Call, Hub};
use crate::server::message::{Outcome, Parts};
use crate::server::request::{object, optional_strings, string, strings};
use crate::server::uav::Uav;
use crate::server::world::FIXTURES;

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    match call.kind {
        "OBJ-CMD" => command(hub, call),
        "OBJ-LIST" => list(hub, call),
        _ => Err(unknown(call)),
    }
}

fn list(hub: &Hub, call: &Call<'_>) -> Answer {
    let filter = optional_strings(call.body, "filter")?;
    let known = ["beacon", "dock", "other", "uav", "weatherStation"];
    let is_unknown = |kind: &String| !known.contains(&kind.as_str());
    if hub.breaks("FW-OBJ-LIST-03") && filter.as_ref().is_some_and(|kinds| kinds.iter().any(is_unknown)) {
        return Err("there is no such type".to_owned());
    }
    let is_wanted = |kind: &str| match &filter {
        None => kind == "uav" || !hub.breaks("FW-OBJ-LIST-04"),
        Some(_) if hub.breaks("FW-OBJ-LIST-02") => true,
        Some(kinds) => kinds.iter().any(|wanted| wanted == kind),
    };
    let objects = hub.world.objects();
    let ids: Vec<&str> = objects.into_iter().filter(|(_, kind)| is_wanted(kind)).map(|(id, _)| id).collect();
    Ok(json!({ "type": call.kind, "ids": ids }))
}

fn command(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let ids = strings(call.body, "ids")?;
    let command = string(call.body, "command")?;
    object(call.body, "kwds")?;
    let arguments = match call.body.get("args") {
        None => &[][..],
        Some(Value::Array(arguments)) => arguments,
        Some(_) => return Err("args is no list".to_owned()),
    };
    let mut parts = Parts::new(call.kind, "result");
    let mut lost = Vec::new();
    for id in &ids {
        let is_fixture = FIXTURES.iter().any(|(known, ..)| known == id);
        let outcome = match hub.uav(id) {
            Some(_) if command == "lose" => {
                lost.push(id.clone());
                Ok("nothing will be heard of it".to_owned())
            }
            Some(uav) => obey(uav, command, arguments),
            None if is_fixture => Err("it takes no commands".to_owned()),
            None => Err("there is no such object".to_owned()),
        };
        parts.put(id, outcome.map(|text| Outcome::Value(json!({ "type": "plain", "data": text }))));
    }
    hub.lose(&lost);
    Ok(parts.into_body())
}

fn obey(uav: &mut Uav, command: &str, arguments: &[Value]) -> Result<String, String> {
    match command {
        "error" if arguments.is_empty() => {
            uav.clear_errors();
            Ok("no error codes".to_owned())
        }
        "error" => {
            let code = |value: &Value| value.as_u64().and_then(|code| u16::try_from(code).ok());
            let codes =
                arguments.iter().map(|value| code(value).ok_or("an error code is a number up to 65535"));
            let codes: Vec<u16> = codes.collect::<Result<_, _>>()?;
            for code in codes.into_iter().map(settable).collect::<Result<Vec<u16>, String>>()? {
                uav.set_error(code);
            }
            Ok(format!("error codes {:?}", uav.codes()))
        }
        "battery" => {
            let percent = arguments.first().and_then(Value::as_f64).ok_or("say the charge in percent")?;
            uav.set_charge(percent);
            Ok(format!("charged to {} %", uav.percentage()))
        }
        _ => Err("there are the commands error, battery and lose".to_owned()),
    }
}
