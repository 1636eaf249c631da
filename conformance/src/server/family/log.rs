//! LOG: flight logs (`definitions/flockwave/log.md`).

use serde_json::{Value, json};

use super::unknown;
use crate::server::hub::{Answer, Call, Hub};
use crate::server::message::{Outcome, Parts};
use crate::server::operation::Operation;
use crate::server::request::{string, strings};

/// The one log that each UAV has.
const LOG: &str = "1";

/// What is in it.
const TEXT: &str = "took off\nlanded\n";

/// How long it takes to fetch a log, in seconds.
const FETCHING: f64 = 2.0;

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    match call.kind {
        "LOG-INF" => list(hub, call),
        "LOG-DATA" => fetch(hub, call),
        _ => Err(unknown(call)),
    }
}

fn metadata() -> Value {
    json!({ "id": LOG, "kind": "text", "size": TEXT.len() })
}

fn list(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let mut parts = Parts::new(call.kind, "result");
    for id in strings(call.body, "ids")? {
        let logs = hub.uav(&id).map(|_| Outcome::Value(json!([metadata()])));
        parts.put(&id, logs.ok_or_else(|| "there is no such UAV".to_owned()));
    }
    Ok(parts.into_body())
}

fn fetch(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let (uav, log) = (string(call.body, "uavId")?, string(call.body, "logId")?);
    let error = |text: &str| json!({ "type": call.kind, "error": text });
    if hub.uav(uav).is_none() {
        return Ok(error("there is no such UAV"));
    }
    if log != LOG {
        return Ok(error("there is no such log"));
    }
    let mut log = metadata();
    log["body"] = json!(TEXT);
    let receipt = hub.start(call.session, |receipt| Operation::lasting(receipt, FETCHING, log))?;
    Ok(json!({ "type": call.kind, "receipt": receipt }))
}
