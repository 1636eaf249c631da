//! What a UAV tells of itself.

use serde_json::{Value, json};

use super::{Activity, DEGREE, ORIGIN, ORIGIN_ALTITUDE, Uav};
use crate::server::error_code::{BATTERY, GROUND, LANDING, MOTORS, RETURNING, SLEEP, TAKING_OFF, settle};

/// Volts of a battery that is full, and of one that is empty.
const FULL: f64 = 12.6;
const EMPTY: f64 = 9.9;

impl Uav {
    /// The code that the battery has.
    pub(super) fn battery_code(&self) -> Option<u16> {
        BATTERY.iter().find(|(limit, _)| self.charge < *limit).map(|(_, code)| *code)
    }

    /// All error codes that apply.
    pub(in crate::server) fn codes(&self) -> Vec<u16> {
        let state = match self.activity {
            Activity::Sleeping => Some(SLEEP),
            Activity::Standing => Some(GROUND),
            Activity::MotorsOn => Some(MOTORS),
            Activity::TakingOff => Some(TAKING_OFF),
            Activity::Returning => Some(RETURNING),
            Activity::Landing => Some(LANDING),
            Activity::Hovering | Activity::FlyingTo(_) | Activity::Falling => None,
        };
        let mut codes: Vec<u16> =
            self.errors.iter().copied().chain(state).chain(self.battery_code()).collect();
        settle(&mut codes, self.is_flying());
        codes
    }

    /// Its mode as messages have it.
    pub(super) fn mode(&self) -> &'static str {
        match self.activity {
            Activity::Sleeping => "unknown",
            Activity::Standing | Activity::MotorsOn => "stab",
            Activity::TakingOff => "takeoff",
            Activity::Hovering => "loiter",
            Activity::FlyingTo(_) => "guided",
            Activity::Returning => "rth",
            Activity::Landing => "land",
            Activity::Falling => "other",
        }
    }

    /// Its voltage in tenths of volts.
    pub(in crate::server) fn voltage(&self) -> i64 {
        rounded((EMPTY + (FULL - EMPTY) * self.charge / 100.0) * 10.0)
    }

    /// Its charge in percent.
    pub(in crate::server) fn percentage(&self) -> i64 {
        rounded(self.charge)
    }

    /// The GPS fix and the number of satellites.
    pub(in crate::server) fn gps(&self) -> (i64, i64) {
        (if self.is_sleeping() { 1 } else { 4 }, if self.is_sleeping() { 0 } else { 14 + self.wobble(3) })
    }

    /// Where it is: latitude and longitude in 1e-7 degrees, altitudes in millimetres.
    pub(in crate::server) fn coordinates(&self) -> [i64; 5] {
        let north_degrees = self.position[0] / DEGREE;
        let east_degrees = self.position[1] / (DEGREE * ORIGIN[0].to_radians().cos());
        let up = rounded(self.position[2] * 1000.0);
        [
            rounded((ORIGIN[0] + north_degrees) * 1e7),
            rounded((ORIGIN[1] + east_degrees) * 1e7),
            rounded(ORIGIN_ALTITUDE * 1000.0) + up,
            up,
            up,
        ]
    }

    /// A value that wavers a little from moment to moment, from 0 up to below `span`.
    fn wobble(&self, span: u64) -> i64 {
        (self.random.at(self.heard / 500) % span).cast_signed()
    }

    /// Its state as messages have it (`UAVStatusInfo`).
    pub(in crate::server) fn status(&self) -> Value {
        let [north, east, up] = self.velocity.map(|speed| rounded(speed * 1000.0));
        let heading = rounded(self.heading * 10.0).rem_euclid(3600);
        let tilt = rounded(self.velocity[0].hypot(self.velocity[1]) * 15.0);
        let (fix, satellites) = self.gps();
        // White, or a green that is easily told from it while it draws attention.
        let light = if self.signal > 0.0 { 0x07E0 } else { 0xFFFF };
        let codes = self.codes();
        let debug = data_encoding::BASE64.encode(self.mode().as_bytes());
        json!({
            "id": self.id,
            "timestamp": self.heard,
            "mode": self.mode(),
            "position": self.coordinates(),
            "positionXYZ": [
                rounded(self.position[0] * 1000.0),
                rounded(-self.position[1] * 1000.0),
                rounded(self.position[2] * 1000.0),
            ],
            "gps": [fix, satellites, 900, 1400],
            "heading": heading,
            "attitude": [self.wobble(5) - 2, -tilt, heading],
            "velocity": [north, east, -up],
            "velocityXYZ": [north, -east, up],
            "battery": [self.voltage(), self.percentage()],
            "light": light,
            "rssi": [80 + self.wobble(20)],
            "errors": codes,
            "debug": debug,
        })
    }
}

#[expect(clippy::cast_possible_truncation, reason = "what is simulated stays far below the limits of an i64")]
fn rounded(value: f64) -> i64 {
    value.round() as i64
}
