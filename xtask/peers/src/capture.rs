//! Makes JSON Lines of one message, and captures of a fleet.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

use serde_json::{Map, json};
use uavspec::px4::FailsafeFlags;

use crate::Result;

/// The number of messages in the JSON Lines.
const LINES: u64 = 100_000;

/// The number of UAVs in a fleet.
const FLEET: u64 = 1_000;

/// The total number of UAV states in a capture.
const STATES: u64 = 300_000;

/// The sizes of the reports, in UAVs.
const REPORTS: [u64; 2] = [1, 50];

pub(crate) fn make(folder: &Path) -> Result<()> {
    lines(BufWriter::new(File::create(folder.join("FailsafeFlags.jsonl"))?))?;
    for each in REPORTS {
        reports(each, BufWriter::new(File::create(folder.join(format!("reports-{each}.jsonl")))?))?;
    }
    Ok(())
}

/// Writes messages without findings, one on each line.
fn lines(mut file: BufWriter<File>) -> Result<()> {
    for number in 0..LINES {
        let mut message = serde_json::to_value(FailsafeFlags::default())?;
        message["timestamp"] = (1_000_000 + 20_000 * number).into();
        message["geofence_breached"] = (number % 3 == 0).into();
        writeln!(file, "{message}")?;
    }
    Ok(file.flush()?)
}

/// Writes a fleet's status reports, as a capture without findings. Each report contains `each` UAVs.
fn reports(each: u64, mut file: BufWriter<File>) -> Result<()> {
    for first in (0..STATES).step_by(usize::try_from(each)?) {
        let time = 1_790_000_000_000 + first / 5;
        let mut status = Map::new();
        for at in first..first + each {
            let uav = format!("glider-{:03}", at % FLEET);
            let value = i64::try_from(at * 7_919 % 100_000)?;
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
        writeln!(file, "{}", json!({ "t": time, "conn": "tcp#1", "dir": "in", "msg": message }))?;
    }
    Ok(file.flush()?)
}
