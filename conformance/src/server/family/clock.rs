//! CLK: clocks (`definitions/flockwave/clk.md`).

use serde_json::{Value, json};

use super::unknown;
use crate::server::hub::{Answer, Call, Hub};
use crate::server::message::{Outcome, Parts};
use crate::server::request::strings;

/// The clocks that there are: that of the server, and one that counts the seconds of the simulation.
const CLOCKS: [&str; 2] = ["system", "simulation"];

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    match call.kind {
        "CLK-LIST" => Ok(json!({ "type": call.kind, "ids": CLOCKS })),
        "CLK-INF" => {
            let mut parts = Parts::new(call.kind, "status");
            for id in strings(call.body, "ids")? {
                let status = status(hub, &id).map(Outcome::Value);
                parts.put(&id, status.ok_or_else(|| "there is no such clock".to_owned()));
            }
            Ok(parts.into_body())
        }
        _ => Err(unknown(call)),
    }
}

/// The state of a clock.
pub(super) fn status(hub: &Hub, id: &str) -> Option<Value> {
    let now = hub.now();
    match id {
        "system" => Some(json!({
            "id": id, "retrievedAt": now, "running": true, "ticks": now, "ticksPerSecond": 1000, "epoch": "unix",
        })),
        "simulation" => {
            let ticks = hub.elapsed.as_secs_f64() * hub.options.speed;
            Some(json!({ "id": id, "retrievedAt": now, "running": true, "ticks": ticks }))
        }
        _ => None,
    }
}
