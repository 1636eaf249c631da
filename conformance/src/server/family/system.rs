//! SYS: the server itself (`definitions/flockwave/sys.md`).

use serde_json::json;

use super::{clock, unknown};
use crate::server::hub::{Answer, Call, Hub};
use crate::server::message::acknowledgment;

/// The furthest that the clock can be put forward in all, in milliseconds: a hundred years.
const ADJUSTMENT_LIMIT: u64 = 100 * 365 * 86_400_000;

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    match call.kind {
        "SYS-PING" => Ok(acknowledgment()),
        "SYS-PORTS" => Ok(json!({ "type": call.kind, "ports": hub.ports })),
        "SYS-TIME" => time(hub, call),
        "SYS-VER" => {
            Ok(json!({ "type": call.kind, "software": "uavspec", "version": env!("CARGO_PKG_VERSION") }))
        }
        _ => Err(unknown(call)),
    }
}

fn time(hub: &mut Hub, call: &Call<'_>) -> Answer {
    if let Some(adjustment) = call.body.get("adjustment") {
        let adjustment = adjustment.as_f64().ok_or("adjustment is no number")?;
        adjust(hub, adjustment)?;
    }
    Ok(json!({ "type": call.kind, "timestamp": hub.now() }))
}

fn adjust(hub: &mut Hub, adjustment: f64) -> Result<(), String> {
    if hub.breaks("FW-SYS-TIME-03") && adjustment == 0.0 {
        hub.adjustment += 3_600_000;
    }
    if adjustment < 0.0 {
        // Timestamps of UAVs would lie in the future, or go back.
        return Err("the clock is put forward only".to_owned());
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a cast takes the closest there is"
    )]
    let adjusted = hub.adjustment.saturating_add(adjustment.round() as u64);
    if adjusted > ADJUSTMENT_LIMIT {
        return Err("that is too far".to_owned());
    }
    if adjusted != hub.adjustment {
        hub.adjustment = adjusted;
        let status = clock::status(hub, "system");
        hub.notify_all(&json!({ "type": "CLK-INF", "status": { "system": status } }));
    }
    Ok(())
}
