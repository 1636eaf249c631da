//! CONN: connections of the server to things other than clients (`definitions/flockwave/conn.md`).

use serde_json::{Value, json};

use super::unknown;
use crate::server::hub::{Answer, Call, Hub};
use crate::server::message::{Outcome, Parts};
use crate::server::request::strings;

/// The radio link to the UAVs, and the one that corrections come in by.
const CONNECTIONS: [&str; 2] = ["radio-1", CORRECTIONS];

/// The connection that corrections come in by.
pub(super) const CORRECTIONS: &str = "base-1";

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    match call.kind {
        "CONN-LIST" => Ok(json!({ "type": call.kind, "ids": CONNECTIONS })),
        "CONN-INF" => {
            let mut parts = Parts::new(call.kind, "status");
            for id in strings(call.body, "ids")? {
                let status = status(hub, &id).map(Outcome::Value);
                parts.put(&id, status.ok_or_else(|| "there is no such connection".to_owned()));
            }
            Ok(parts.into_body())
        }
        _ => Err(unknown(call)),
    }
}

/// The state of a connection.
pub(super) fn status(hub: &Hub, id: &str) -> Option<Value> {
    let (purpose, status, description) = match id {
        "radio-1" => ("uavRadioLink", "connected", "Simulated radio link"),
        CORRECTIONS if hub.world.preset.is_some() => ("dgps", "connected", "Simulated base station"),
        CORRECTIONS => ("dgps", "disconnected", "Simulated base station"),
        _ => return None,
    };
    Some(json!({
        "id": id, "purpose": purpose, "status": status, "description": description, "timestamp": hub.now(),
    }))
}
