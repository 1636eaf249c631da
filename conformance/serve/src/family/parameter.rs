//! PRM: parameters of UAVs (`definitions/flockwave/prm.md`).

use std::collections::BTreeMap;

use serde_json::{Value, json};
use uavspec_types::flockwave::json::{ParameterOutcome, Request, prm_get, prm_set, prm_set_many};

use super::unknown;
use crate::hub::{Answer, Hub, SessionId};
use crate::message::{Outcome, Outcomes};
use crate::world::PARAMETERS;

pub(super) fn answer(hub: &mut Hub, _session: SessionId, request: Request) -> Answer {
    match request {
        Request::PrmGet(request) => {
            let outcomes =
                Outcomes::collect(request.ids, |id| get(hub, id, &request.name).map(Outcome::Value))?;
            let (result, error, receipt) = outcomes.into_maps_with_receipts();
            Ok(prm_get::Response { result, error, receipt }.into())
        }
        Request::PrmSet(request) => {
            let outcomes = Outcomes::collect(request.ids, |id| {
                set(hub, id, &request.name, &request.value).map(|()| Outcome::Value(true))
            })?;
            let (result, error, receipt) = outcomes.into_maps_with_receipts();
            Ok(prm_set::Response { result, error, receipt }.into())
        }
        Request::PrmSetMany(request) => {
            let outcomes = Outcomes::collect(request.ids, |id| {
                set_many(hub, id, &request.parameters).map(Outcome::Value)
            })?;
            let (result, error, receipt) = outcomes.into_maps_with_receipts();
            Ok(prm_set_many::Response { result, error, receipt }.into())
        }
        other => Err(unknown(&other)),
    }
}

/// The name and the default of a parameter.
fn parameter(hub: &mut Hub, id: &str, name: &str) -> Result<(&'static str, i64), String> {
    if hub.uav(id).is_none() {
        return Err("no such UAV".to_owned());
    }
    PARAMETERS.into_iter().find(|(known, _)| *known == name).ok_or_else(|| "no such parameter".to_owned())
}

fn get(hub: &mut Hub, id: &str, name: &str) -> Result<Value, String> {
    let (name, usual) = parameter(hub, id, name)?;
    let changed = hub.world.parameters.get(&(id.to_owned(), name));
    Ok(changed.cloned().unwrap_or_else(|| json!(usual)))
}

fn set(hub: &mut Hub, id: &str, name: &str, value: &Value) -> Result<(), String> {
    let (name, _) = parameter(hub, id, name)?;
    let value = number(value).ok_or("expected a number")?;
    hub.world.parameters.insert((id.to_owned(), name), value);
    Ok(())
}

/// Returns a number, or the number in a string. Clients that read parameters from text files send strings.
fn number(value: &Value) -> Option<Value> {
    match value {
        Value::Number(_) => Some(value.clone()),
        Value::String(text) => serde_json::from_str(text.trim()).ok().filter(Value::is_number),
        _ => None,
    }
}

fn set_many(hub: &mut Hub, id: &str, values: &BTreeMap<String, Value>) -> Result<ParameterOutcome, String> {
    if hub.uav(id).is_none() {
        return Err("no such UAV".to_owned());
    }
    let is_refused = |(name, value): &(&String, &Value)| set(hub, id, name, value).is_err();
    let failed: Vec<String> = values.iter().filter(is_refused).map(|(name, _)| name.clone()).collect();
    Ok(ParameterOutcome {
        success: failed.is_empty(),
        failed: Some(failed).filter(|names| !names.is_empty()),
    })
}
