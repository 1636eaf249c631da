//! OBJ: all objects of the server (`definitions/flockwave/obj.md`).

use serde_json::{Value, json};
use uavspec_rules::flockwave::{obj_list_02, obj_list_03, obj_list_04};
use uavspec_types::flockwave::ErrorCode;
use uavspec_types::flockwave::json::obj_cmd::ResponseResult;
use uavspec_types::flockwave::json::{
    CommandResponse, CommandResponseType, ObjectId, ObjectType, Request, obj_cmd, obj_list,
};

use super::unknown;
use crate::error_code::settable;
use crate::hub::{Answer, Hub, SessionId};
use crate::message::{Outcome, Outcomes};
use crate::request::limited;
use crate::uav::Uav;
use crate::world::FIXTURES;

pub(super) fn answer(hub: &mut Hub, _session: SessionId, request: Request) -> Answer {
    match request {
        Request::ObjCmd(request) => command(hub, request),
        Request::ObjList(request) => list(hub, request.filter.map(limited).transpose()?.as_deref()),
        other => Err(unknown(&other)),
    }
}

fn list(hub: &Hub, filter: Option<&[ObjectType]>) -> Answer {
    let has_unknown = filter.is_some_and(|kinds| kinds.iter().any(|kind| !kind.is_known()));
    if has_unknown && hub.has_bug(&obj_list_03::RULE) {
        return Err("no such type".to_owned());
    }
    let is_wanted = |kind: &ObjectType| match filter {
        None => *kind == ObjectType::Uav || !hub.has_bug(&obj_list_04::RULE),
        Some(_) if hub.has_bug(&obj_list_02::RULE) => true,
        Some(kinds) => kinds.contains(kind),
    };
    let wanted = hub.world.objects().filter(|(_, kind)| is_wanted(kind));
    Ok(obj_list::Response { ids: wanted.map(|(id, _)| ObjectId::from(id)).collect() }.into())
}

fn command(hub: &mut Hub, request: obj_cmd::Request) -> Answer {
    let command = request.command.as_str();
    let arguments = limited(request.args.unwrap_or_default())?;
    let mut lost = Vec::new();
    let outcomes = Outcomes::collect(request.ids, |id| {
        let is_fixture = FIXTURES.iter().any(|fixture| fixture.id == id);
        let text = match hub.uav(id) {
            Some(_) if command == "lose" => {
                lost.push(id.to_owned());
                "the UAV is lost".to_owned()
            }
            Some(uav) => obey(uav, command, &arguments)?,
            None if is_fixture => return Err("the object accepts no commands".to_owned()),
            None => return Err("no such object".to_owned()),
        };
        Ok(Outcome::Value(ResponseResult::CommandResponse(CommandResponse {
            r#type: CommandResponseType::Plain,
            data: json!(text),
        })))
    })?;
    hub.lose(&lost);
    let (result, error, receipt) = outcomes.into_maps_with_receipts();
    Ok(obj_cmd::Response { result, error, receipt }.into())
}

fn obey(uav: &mut Uav, command: &str, arguments: &[Value]) -> Result<String, String> {
    match command {
        "error" if arguments.is_empty() => {
            uav.clear_errors();
            Ok("no error codes".to_owned())
        }
        "error" => {
            let code = |value: &Value| match value {
                Value::String(text) => text.trim().parse().ok(),
                value => value.as_u64().and_then(|code| u16::try_from(code).ok()),
            };
            let codes =
                arguments.iter().map(|value| code(value).ok_or("expected an error code from 0 to 65535"));
            let codes: Vec<u16> = codes.collect::<Result<_, _>>()?;
            let codes: Vec<ErrorCode> = codes.into_iter().map(settable).collect::<Result<_, _>>()?;
            uav.set_errors(&codes);
            let codes: Vec<String> = uav.codes().iter().map(ErrorCode::to_string).collect();
            Ok(format!("error codes: {}", codes.join(", ")))
        }
        "battery" => {
            let charge = arguments.first().and_then(percentage).ok_or("expected the charge in percent")?;
            uav.set_charge(charge);
            Ok(format!("charged to {} %", uav.percentage()))
        }
        _ => Err("unknown command; expected error, battery or lose".to_owned()),
    }
}

/// Returns a percentage that is given as a number or as a string. Clients in which people type commands send strings
/// such as `90%`.
fn percentage(value: &Value) -> Option<f64> {
    let Value::String(text) = value else { return value.as_f64() };
    let text = text.trim();
    let charge: f64 = text.strip_suffix('%').unwrap_or(text).trim_end().parse().ok()?;
    Some(charge).filter(|charge| charge.is_finite())
}
