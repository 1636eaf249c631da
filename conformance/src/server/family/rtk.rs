//! RTK: corrections (`definitions/flockwave/rtk.md`).

use serde_json::{Value, json};

use super::connection::{CORRECTIONS, status};
use super::unknown;
use crate::server::hub::{Answer, Call, Hub};
use crate::server::message::{Outcome, Parts, acknowledgment};
use crate::server::request::{Body, object, strings};
use crate::server::world::PRESETS;

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    match call.kind {
        "RTK-LIST" => Ok(json!({ "type": call.kind, "ids": PRESETS.map(|preset| preset.id) })),
        "RTK-INF" => presets(call),
        "RTK-SOURCE" => source(hub, call),
        "RTK-STAT" => Ok(statistics(hub)),
        "RTK-SURVEY" => survey(hub, call),
        _ => Err(unknown(call)),
    }
}

fn presets(call: &Call<'_>) -> Answer {
    let mut parts = Parts::new(call.kind, "preset");
    for id in strings(call.body, "ids")? {
        let preset = PRESETS.iter().find(|preset| preset.id == id).map(|preset| {
            let (title, format) = (preset.title, preset.format);
            Outcome::Value(
                json!({ "title": title, "format": format, "sources": [preset.source], "type": "builtin" }),
            )
        });
        parts.put(&id, preset.ok_or_else(|| "there is no such preset".to_owned()));
    }
    Ok(parts.into_body())
}

fn source(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let chosen = match call.body.get("id") {
        None => return Ok(json!({ "type": call.kind, "id": hub.world.preset.map(|preset| preset.id) })),
        Some(Value::Null) => None,
        Some(Value::String(id)) => {
            Some(PRESETS.iter().find(|preset| preset.id == id).ok_or("there is no such preset")?)
        }
        Some(_) => return Err("id is neither a string nor null".to_owned()),
    };
    if hub.world.preset.is_some() != chosen.is_some() {
        hub.world.preset = chosen;
        let status = status(hub, CORRECTIONS);
        hub.notify_all(&json!({ "type": "CONN-INF", "status": { CORRECTIONS: status } }));
    }
    hub.world.preset = chosen;
    Ok(acknowledgment())
}

fn statistics(hub: &Hub) -> Value {
    if hub.world.preset.is_none() {
        let survey = json!({ "accuracy": 0, "flags": 0 });
        return json!({
            "type": "RTK-STAT", "antenna": {}, "messages": {}, "messages_tx": {}, "cnr": {}, "survey": survey,
        });
    }
    json!({
        "type": "RTK-STAT",
        "antenna": { "stationId": 7, "descriptor": "Mast", "position": [504_980_500, 99_525_000, 908_000] },
        "messages": { "rtcm3/1005": [480, 160], "rtcm3/1077": [120, 2400] },
        "messages_tx": { "rtcm3/1077": [150, 2400] },
        "cnr": { "G04": 44.5, "G17": 39, "E11": 41 },
        "survey": { "accuracy": 0.8, "flags": 5 },
    })
}

fn survey(hub: &mut Hub, call: &Call<'_>) -> Answer {
    if let Some(settings) = object(call.body, "settings")? {
        hub.world.survey = checked(settings)?;
    }
    let mut body = json!({ "type": call.kind });
    if !hub.world.survey.is_empty() {
        body["settings"] = Value::Object(hub.world.survey.clone());
    }
    Ok(body)
}

/// The settings of a survey that the server keeps: those of the definition.
fn checked(settings: &Body) -> Result<Body, String> {
    let mut kept = Body::new();
    for name in ["duration", "accuracy"] {
        let value = settings.get(name).filter(|value| value.is_number());
        let value = value.ok_or_else(|| format!("settings must have a number {name}"))?;
        kept.insert(name.to_owned(), value.clone());
    }
    match settings.get("messageSet").map(Value::as_str) {
        None => {}
        Some(Some(set @ ("msm4" | "msm7"))) => {
            kept.insert("messageSet".to_owned(), json!(set));
        }
        Some(_) => return Err("messageSet is neither msm4 nor msm7".to_owned()),
    }
    Ok(kept)
}
