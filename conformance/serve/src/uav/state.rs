//! The status of a UAV, as reported to clients.

use uavspec_types::flockwave::ErrorCode;
use uavspec_types::flockwave::json::{
    Attitude, Base64, BatteryInfo, ColorRGB565, FlightMode, GPSCoordinate, GPSFix, GPSFixType, Heading,
    Latitude, Longitude, PositionXYZ, Rssi, SignedAngle, Timestamp, UAVStatusInfo, VelocityNED, VelocityXYZ,
};

use super::{Activity, DEGREE, ORIGIN, ORIGIN_ALTITUDE, Uav};
use crate::error_code::{BATTERY, normalize};

/// The voltages of a full and of an empty battery.
const FULL: f64 = 12.6;
const EMPTY: f64 = 9.9;

impl Uav {
    /// The error code for the battery charge.
    pub(super) fn battery_code(&self) -> Option<ErrorCode> {
        BATTERY.iter().find(|(limit, _)| self.charge < *limit).map(|(_, code)| *code)
    }

    /// All error codes that apply.
    pub(crate) fn codes(&self) -> Vec<ErrorCode> {
        let state = match self.activity {
            Activity::Sleeping => Some(ErrorCode::SLEEP),
            Activity::OnGround => Some(ErrorCode::GROUND),
            Activity::MotorsOn => Some(ErrorCode::MOTORS),
            Activity::TakingOff => Some(ErrorCode::TAKEOFF),
            Activity::Returning => Some(ErrorCode::RTH),
            Activity::Landing => Some(ErrorCode::LANDING),
            Activity::Hovering | Activity::FlyingTo(_) | Activity::Falling => None,
        };
        let mut codes: Vec<ErrorCode> =
            self.errors.iter().copied().chain(state).chain(self.battery_code()).collect();
        normalize(&mut codes, self.is_flying());
        codes
    }

    /// The flight mode in messages.
    pub(super) fn mode(&self) -> FlightMode {
        match self.activity {
            Activity::Sleeping => FlightMode::Unknown,
            Activity::OnGround | Activity::MotorsOn => FlightMode::Stab,
            Activity::TakingOff => FlightMode::Takeoff,
            Activity::Hovering => FlightMode::Loiter,
            Activity::FlyingTo(_) => FlightMode::Guided,
            Activity::Returning => FlightMode::Rth,
            Activity::Landing => FlightMode::Land,
            Activity::Falling => FlightMode::Other,
        }
    }

    /// The voltage in tenths of a volt.
    pub(crate) fn voltage(&self) -> i64 {
        rounded((EMPTY + (FULL - EMPTY) * self.charge / 100.0) * 10.0)
    }

    /// The charge in percent.
    pub(crate) fn percentage(&self) -> i64 {
        rounded(self.charge)
    }

    /// The number of visible satellites.
    pub(crate) fn satellites(&self) -> i64 {
        if self.is_sleeping() { 0 } else { 14 + self.variation(3) }
    }

    /// The position: latitude and longitude in 1e-7 degrees, altitudes in millimetres.
    pub(crate) fn coordinates(&self) -> [i64; 5] {
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

    /// A slightly varying value, at least 0 and below `span`.
    fn variation(&self, span: u64) -> i64 {
        (self.random.at(self.last_received / 500) % span).cast_signed()
    }

    /// The status in messages.
    pub(crate) fn status(&self) -> UAVStatusInfo {
        let [north, east, up] = self.velocity.map(|speed| rounded(speed * 1000.0));
        let [x, y, z] = self.position.map(|distance| rounded(distance * 1000.0));
        let heading = Heading(rounded(self.heading * 10.0).rem_euclid(3600));
        let tilt = rounded(self.velocity[0].hypot(self.velocity[1]) * 15.0);
        // White, or green while the UAV signals.
        let light = ColorRGB565(if self.signal > 0.0 { 0x07E0 } else { 0xFFFF });
        UAVStatusInfo {
            id: self.id.as_str().into(),
            timestamp: Timestamp(self.last_received.cast_signed()),
            mode: Some(self.mode()),
            position: Some(self.gps_coordinate()),
            position_xyz: Some(PositionXYZ { x, y: -y, z }),
            gps: Some(self.fix()),
            heading: Some(heading),
            attitude: Some(Attitude {
                roll: SignedAngle(self.variation(5) - 2),
                pitch: SignedAngle(-tilt),
                yaw: heading,
            }),
            velocity: Some(VelocityNED { north, east, down: -up }),
            velocity_xyz: Some(VelocityXYZ { x: north, y: -east, z: up }),
            battery: Some(BatteryInfo {
                voltage: self.voltage(),
                percentage: Some(self.percentage()),
                charging: None,
            }),
            light: Some(light),
            rssi: Some(vec![Rssi(80 + self.variation(20))]),
            errors: Some(self.codes()),
            debug: Some(Base64(data_encoding::BASE64.encode(self.mode().as_str().as_bytes()))),
        }
    }

    fn gps_coordinate(&self) -> GPSCoordinate {
        let [latitude, longitude, amsl, ahl, agl] = self.coordinates();
        GPSCoordinate {
            latitude: Latitude(latitude),
            longitude: Longitude(longitude),
            amsl: Some(amsl),
            ahl: Some(ahl),
            agl: Some(agl),
        }
    }

    fn fix(&self) -> GPSFix {
        // No fix, or a fix with altitude and corrections.
        let kind = if self.is_sleeping() { GPSFixType::Value1 } else { GPSFixType::Value4 };
        GPSFix {
            r#type: kind,
            satellites: Some(self.satellites()),
            horizontal_accuracy: Some(900),
            vertical_accuracy: Some(1400),
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "simulated values are far below the limits of an i64")]
fn rounded(value: f64) -> i64 {
    value.round() as i64
}
