//! Makes JSON Lines of one message, and captures of a fleet. The benchmark `checking` also uses this file.

use std::io::{Result, Write};

use serde_json::{Map, json};
use uavspec_types::px4::FailsafeFlags;

/// The number of UAVs in a fleet.
const FLEET: usize = 1_000;

/// Writes this many messages without findings, one on each line.
pub(crate) fn write_lines(count: usize, out: &mut impl Write) -> Result<()> {
    for number in 0..count {
        let mut message = serde_json::to_value(FailsafeFlags::default())?;
        message["timestamp"] = (1_000_000 + 20_000 * number).into();
        message["geofence_breached"] = (number % 3 == 0).into();
        writeln!(out, "{message}")?;
    }
    out.flush()
}

/// Writes a fleet's status reports, as a capture without findings. Each report contains the states of `each` UAVs, and
/// all reports together contain `total` states.
pub(crate) fn write_reports(total: usize, each: usize, out: &mut impl Write) -> Result<()> {
    for first in (0..total).step_by(each) {
        let time = 1_790_000_000_000 + first / 5;
        let mut status = Map::new();
        for at in first..first + each {
            let uav = format!("glider-{:03}", at % FLEET);
            #[allow(clippy::cast_possible_wrap, reason = "the value is small")]
            let value = (at * 7_919 % 100_000) as i64;
            let state = json!({
                "id": uav, "timestamp": time, "mode": "mission", "heading": value % 3_600,
                "position": [465_410_000 + value, 115_520_000 - value, 812_000 + value, value % 900],
                "velocity": [value % 900, 400 - value % 800, -(value % 90)], "gps": [4, 8 + value % 12],
                "battery": [110 + value % 16, value % 101], "light": value % 65_536, "rssi": [value % 101],
                "errors": [], "debug": "",
            });
            status.insert(uav, state);
        }
        let body = json!({ "type": "UAV-INF", "status": status });
        let message = json!({ "$fw.version": "1.0", "id": format!("say-{first}"), "body": body });
        #[allow(clippy::cast_precision_loss, reason = "times are small enough")]
        let time = time as f64 / 1e3;
        writeln!(out, "{}", json!({ "t": time, "conn": "tcp#1", "dir": "in", "msg": message }))?;
    }
    out.flush()
}
