//! WTH: the weather (`definitions/flockwave/wth.md`).

use serde_json::{Value, json};

use super::unknown;
use crate::server::hub::{Answer, Call, Hub};
use crate::server::message::{Outcome, Parts};
use crate::server::request::strings;

/// The one station that there is.
const STATION: &str = "wind-1";

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    match call.kind {
        "WTH-LIST" => Ok(json!({ "type": call.kind, "ids": [STATION] })),
        "WTH-AT" => {
            let position = call.body.get("position").and_then(Value::as_array);
            let is_place = |place: &&Vec<Value>| place.len() >= 2 && place[..2].iter().all(Value::is_i64);
            position.filter(is_place).ok_or("position is no list of integers")?;
            Ok(json!({ "type": call.kind, "weather": weather(hub) }))
        }
        "WTH-INF" => {
            let mut parts = Parts::new(call.kind, "status");
            for id in strings(call.body, "ids")? {
                let weather = (id == STATION).then(|| Outcome::Value(weather(hub)));
                parts.put(&id, weather.ok_or_else(|| "there is no such station".to_owned()));
            }
            Ok(parts.into_body())
        }
        _ => Err(unknown(call)),
    }
}

/// The weather, which is always fine.
fn weather(hub: &Hub) -> Value {
    json!({
        "position": [504_977_000, 99_512_000, 905_000],
        "timestamp": hub.now(),
        "stationId": STATION,
        "code": 801,
        "temperature": 2902,
        "pressure": 101_800,
        "humidity": 54,
        "windDirection": 2350,
        "windSpeed": 3400,
        "windGust": 5200,
    })
}
