//! BCN: beacons (`definitions/flockwave/bcn.md`).

use serde_json::json;

use super::unknown;
use crate::server::hub::{Answer, Call, Hub};
use crate::server::message::{Outcome, Parts};
use crate::server::request::strings;
use crate::server::world::FIXTURES;

/// Where the first beacon stands; the others stand north of it.
const POSITION: [i64; 2] = [504_975_000, 99_510_000];

/// How far they are apart, in 1e-7 degrees of latitude.
const DISTANCE: i64 = 30_000;

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let name = match call.kind {
        "BCN-INF" => "status",
        "BCN-PROPS" => "result",
        _ => return Err(unknown(call)),
    };
    let now = hub.now();
    let mut parts = Parts::new(call.kind, name);
    for id in strings(call.body, "ids")? {
        let mut beacons = FIXTURES.iter().filter(|(_, kind, _)| *kind == "beacon").zip(0..);
        let found = beacons.find(|((known, ..), _)| *known == id);
        let value = found.map(|((_, _, title), number)| {
            let position = [POSITION[0] + number * DISTANCE, POSITION[1]];
            match name {
                "status" => json!({ "id": id, "timestamp": now, "position": position, "active": true }),
                _ => json!({ "id": id, "name": title }),
            }
        });
        parts.put(&id, value.map(Outcome::Value).ok_or_else(|| "there is no such beacon".to_owned()));
    }
    Ok(parts.into_body())
}
