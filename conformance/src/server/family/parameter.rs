//! PRM: parameters of UAVs (`definitions/flockwave/prm.md`).

use serde_json::{Value, json};

use super::unknown;
use crate::server::hub::{Answer, Call, Hub};
use crate::server::message::{Outcome, Parts};
use crate::server::request::{object, string, strings};
use crate::server::world::PARAMETERS;

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let ids = strings(call.body, "ids")?;
    let mut parts = Parts::new(call.kind, "result");
    for id in &ids {
        let outcome = match call.kind {
            "PRM-GET" => get(hub, id, string(call.body, "name")?),
            "PRM-SET" => {
                let value = call.body.get("value").ok_or("value is missing")?;
                set(hub, id, string(call.body, "name")?, value).map(|()| json!(true))
            }
            "PRM-SET-MANY" => set_many(hub, id, call),
            _ => return Err(unknown(call)),
        };
        parts.put(id, outcome.map(Outcome::Value));
    }
    Ok(parts.into_body())
}

/// The name and the usual value of a parameter of a UAV.
fn parameter(hub: &mut Hub, id: &str, name: &str) -> Result<(&'static str, i64), String> {
    if hub.uav(id).is_none() {
        return Err("there is no such UAV".to_owned());
    }
    PARAMETERS
        .into_iter()
        .find(|(known, _)| *known == name)
        .ok_or_else(|| "there is no such parameter".to_owned())
}

fn get(hub: &mut Hub, id: &str, name: &str) -> Result<Value, String> {
    let (name, usual) = parameter(hub, id, name)?;
    let changed = hub.world.parameters.get(&(id.to_owned(), name));
    Ok(changed.cloned().unwrap_or_else(|| json!(usual)))
}

fn set(hub: &mut Hub, id: &str, name: &str, value: &Value) -> Result<(), String> {
    let (name, _) = parameter(hub, id, name)?;
    if !value.is_number() {
        return Err("its value is a number".to_owned());
    }
    hub.world.parameters.insert((id.to_owned(), name), value.clone());
    Ok(())
}

fn set_many(hub: &mut Hub, id: &str, call: &Call<'_>) -> Result<Value, String> {
    let values = object(call.body, "parameters")?.ok_or("parameters is missing")?;
    if hub.uav(id).is_none() {
        return Err("there is no such UAV".to_owned());
    }
    let failed: Vec<&String> = values
        .iter()
        .filter(|(name, value)| set(hub, id, name, value).is_err())
        .map(|(name, _)| name)
        .collect();
    if failed.is_empty() {
        Ok(json!({ "success": true }))
    } else {
        Ok(json!({ "success": false, "failed": failed }))
    }
}
