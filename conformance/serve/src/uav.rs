//! A simulated UAV: its activity, position and battery.

mod state;

use uavspec_runtime::ErrorClass;
use uavspec_types::flockwave::ErrorCode;

use super::error_code::normalize;
use super::random::Random;

/// The position of the fleet: a gliding airfield on a hill, in degrees.
const ORIGIN: [f64; 2] = [50.498, 9.952];

/// The altitude of the origin above mean sea level, in metres.
const ORIGIN_ALTITUDE: f64 = 905.0;

/// Metres per degree of latitude.
const DEGREE: f64 = 111_320.0;

/// The altitude above the home position after takeoff, in metres.
const TAKEOFF_ALTITUDE: f64 = 10.0;

/// Speeds in metres per second: cruising, climbing, descending, and falling with stopped motors.
const CRUISE: f64 = 8.0;
const CLIMB: f64 = 2.5;
const DESCENT: f64 = 1.5;
const FALL: f64 = 15.0;

/// Battery drain in percent per second: in the air, on the ground with running motors, and on the ground with stopped
/// motors.
const FLYING_DRAIN: f64 = 100.0 / 1200.0;
const IDLE_DRAIN: f64 = FLYING_DRAIN / 3.0;
const STANDBY_DRAIN: f64 = FLYING_DRAIN / 60.0;

/// The distance from the target at which a UAV counts as arrived, in metres.
const CLOSE: f64 = 0.05;

/// A position relative to the origin in metres: north, east, up.
type Position = [f64; 3];

/// The activity of a UAV.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Activity {
    Sleeping,
    OnGround,
    MotorsOn,
    TakingOff,
    Hovering,
    FlyingTo(Position),
    Returning,
    Landing,
    Falling,
}

/// A target position: latitude and longitude in 1e-7 degrees, and an altitude in millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Target {
    pub(super) latitude: i64,
    pub(super) longitude: i64,
    pub(super) altitude: Option<Altitude>,
}

/// An altitude with its reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Altitude {
    AboveSeaLevel(i64),
    AboveHome(i64),
}

/// A command to a UAV.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Command {
    TakeOff,
    Land,
    ReturnHome,
    Hover,
    Halt,
    FlyTo(Target),
    Motors { is_start: bool, is_forced: bool },
    Signal { seconds: f64 },
    Sleep,
    WakeUp,
    Restart,
}

/// A simulated UAV.
#[derive(Clone, Debug)]
pub(super) struct Uav {
    pub(super) id: String,
    home: Position,
    position: Position,
    velocity: Position,
    heading: f64,
    activity: Activity,
    charge: f64,
    /// Codes that a client has set, and codes that remain until the UAV restarts.
    errors: Vec<ErrorCode>,
    signal: f64,
    random: Random,
    /// The time of the last message from the UAV, in milliseconds since 1970.
    last_received: u64,
}

impl Uav {
    /// The UAV with this number, starting at 0.
    pub(super) fn new(number: usize, charge: f64, seed: u64, now: u64) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "fleets are small")]
        let home = [(number / 10) as f64 * 3.0, (number % 10) as f64 * 3.0, 0.0];
        let random = Random::new(seed.wrapping_add(number as u64));
        Self {
            id: format!("glider-{}", number + 1),
            home,
            position: home,
            velocity: [0.0; 3],
            heading: 45.0,
            activity: Activity::OnGround,
            charge,
            errors: Vec::new(),
            signal: 0.0,
            random,
            last_received: now,
        }
    }

    pub(super) fn is_sleeping(&self) -> bool {
        self.activity == Activity::Sleeping
    }

    pub(super) fn is_flying(&self) -> bool {
        !matches!(self.activity, Activity::Sleeping | Activity::OnGround | Activity::MotorsOn)
    }

    /// Executes a command, or returns the reason why the UAV can't execute it.
    pub(super) fn command(&mut self, command: Command) -> Result<(), String> {
        let is_flying = self.is_flying();
        match command {
            Command::Sleep | Command::Restart if is_flying => return Err("the UAV is in the air".to_owned()),
            Command::Sleep => self.activity = Activity::Sleeping,
            Command::WakeUp => {
                if self.is_sleeping() {
                    self.activity = Activity::OnGround;
                }
            }
            Command::Signal { seconds } => self.signal = seconds,
            Command::Halt => {
                self.activity = if is_flying { Activity::Falling } else { Activity::OnGround };
            }
            Command::Restart => {
                self.activity = Activity::OnGround;
                self.errors.clear();
            }
            Command::Motors { is_start: false, is_forced: false } if is_flying => {
                return Err("the UAV is in the air; set force to stop its motors".to_owned());
            }
            Command::Motors { is_start, .. } => self.turn_motors(is_start),
            Command::TakeOff => self.take_off()?,
            _ if self.activity == Activity::Falling => return Err("it is falling".to_owned()),
            _ if !is_flying => return Err("the UAV is on the ground".to_owned()),
            Command::Land => self.activity = Activity::Landing,
            Command::ReturnHome => self.activity = Activity::Returning,
            Command::Hover => self.activity = Activity::Hovering,
            Command::FlyTo(target) => self.activity = Activity::FlyingTo(self.position_of(target)),
        }
        Ok(())
    }

    fn turn_motors(&mut self, is_start: bool) {
        match (is_start, self.is_flying()) {
            (true, false) => self.activity = Activity::MotorsOn,
            (false, false) => self.activity = Activity::OnGround,
            (false, true) => self.activity = Activity::Falling,
            (true, true) => {}
        }
    }

    fn take_off(&mut self) -> Result<(), String> {
        if self.is_flying() {
            return Err("the UAV is in the air".to_owned());
        }
        let is_severe = |code: &ErrorCode| matches!(code.class(), ErrorClass::Error | ErrorClass::Fatal);
        if let Some(code) = self.codes().into_iter().find(is_severe) {
            return Err(format!("the UAV has error code {code}"));
        }
        self.activity = Activity::TakingOff;
        Ok(())
    }

    /// Adds codes, which remain until all are cleared.
    pub(super) fn set_errors(&mut self, codes: &[ErrorCode]) {
        self.errors.extend_from_slice(codes);
        let is_flying = self.is_flying();
        normalize(&mut self.errors, is_flying);
    }

    pub(super) fn clear_errors(&mut self) {
        self.errors.clear();
    }

    pub(super) fn set_charge(&mut self, percent: f64) {
        self.charge = percent.clamp(0.0, 100.0);
    }

    /// Advances the simulation by this many seconds. `now` is in milliseconds since 1970.
    pub(super) fn advance(&mut self, seconds: f64, now: u64) {
        if self.is_sleeping() {
            self.velocity = [0.0; 3];
            return;
        }
        self.last_received = self.last_received.max(now);
        self.signal = (self.signal - seconds).max(0.0);
        let drain = match self.activity {
            Activity::MotorsOn => IDLE_DRAIN,
            _ if self.is_flying() => FLYING_DRAIN,
            _ => STANDBY_DRAIN,
        };
        self.charge = (self.charge - drain * seconds).max(0.0);
        self.react_to_battery();
        let before = self.position;
        self.fly(seconds);
        for (axis, velocity) in self.velocity.iter_mut().enumerate() {
            *velocity = (self.position[axis] - before[axis]) / seconds;
        }
        if self.velocity[0].hypot(self.velocity[1]) > 0.5 {
            self.heading = self.velocity[1].atan2(self.velocity[0]).to_degrees();
        }
    }

    /// Changes the activity if the battery is low.
    fn react_to_battery(&mut self) {
        let is_busy = matches!(
            self.activity,
            Activity::TakingOff | Activity::Hovering | Activity::FlyingTo(_) | Activity::Returning
        );
        match self.battery_code() {
            Some(ErrorCode::LOWBAT_FATAL) if is_busy => self.activity = Activity::Landing,
            Some(ErrorCode::LOWBAT_ERROR) if is_busy => self.activity = Activity::Returning,
            _ => {}
        }
    }

    fn fly(&mut self, seconds: f64) {
        match self.activity {
            Activity::Sleeping | Activity::OnGround | Activity::MotorsOn | Activity::Hovering => {}
            Activity::TakingOff => {
                let target = [self.position[0], self.position[1], TAKEOFF_ALTITUDE];
                if self.approach(target, seconds) {
                    self.activity = Activity::Hovering;
                }
            }
            Activity::FlyingTo(target) => {
                if self.approach(target, seconds) {
                    self.activity = Activity::Hovering;
                }
            }
            Activity::Returning => {
                let target = [self.home[0], self.home[1], TAKEOFF_ALTITUDE];
                if self.approach(target, seconds) {
                    self.activity = Activity::Landing;
                }
            }
            Activity::Landing => self.sink(DESCENT * seconds),
            Activity::Falling => {
                self.sink(FALL * seconds);
                if !self.is_flying() {
                    self.set_errors(&[ErrorCode::CRASH]);
                }
            }
        }
    }

    fn sink(&mut self, distance: f64) {
        self.position[2] = (self.position[2] - distance).max(0.0);
        if self.position[2] <= 0.0 {
            self.activity = Activity::OnGround;
        }
    }

    /// Moves towards a position. Returns true on arrival.
    fn approach(&mut self, target: Position, seconds: f64) -> bool {
        let [north, east, up] = [0, 1, 2].map(|axis| target[axis] - self.position[axis]);
        let distance = north.hypot(east);
        let along = if distance > 0.0 { (CRUISE * seconds / distance).min(1.0) } else { 1.0 };
        self.position[0] += north * along;
        self.position[1] += east * along;
        self.position[2] += up.clamp(-DESCENT * seconds, CLIMB * seconds);
        (0..3).all(|axis| (target[axis] - self.position[axis]).abs() < CLOSE)
    }

    fn position_of(&self, target: Target) -> Position {
        #[expect(
            clippy::cast_precision_loss,
            reason = "the rounding error is far below the precision of the simulation"
        )]
        let [latitude, longitude] = [target.latitude, target.longitude].map(|value| value as f64 / 1e7);
        let north = (latitude - ORIGIN[0]) * DEGREE;
        let east = (longitude - ORIGIN[1]) * DEGREE * ORIGIN[0].to_radians().cos();
        #[expect(clippy::cast_precision_loss, reason = "as above")]
        let up = match target.altitude {
            None => self.position[2],
            Some(Altitude::AboveHome(altitude)) => altitude as f64 / 1000.0,
            Some(Altitude::AboveSeaLevel(altitude)) => altitude as f64 / 1000.0 - ORIGIN_ALTITUDE,
        };
        // The UAV stays near the origin, regardless of the target.
        [north.clamp(-5000.0, 5000.0), east.clamp(-5000.0, 5000.0), up.clamp(2.0, 500.0)]
    }
}

#[cfg(test)]
mod tests {
    use uavspec_types::flockwave::json::FlightMode;

    use super::*;
    use crate::error_code::BATTERY;

    fn fly_for(uav: &mut Uav, seconds: u64) {
        for step in 0..seconds * 10 {
            uav.advance(0.1, 1000 + step * 100);
        }
    }

    #[test]
    fn returns_to_the_home_position() {
        let mut uav = Uav::new(12, 100.0, 7, 0);
        let home = uav.coordinates();
        assert_eq!((uav.codes(), uav.mode()), (vec![ErrorCode::GROUND], FlightMode::Stab));
        uav.command(Command::TakeOff).expect("the command is valid");
        uav.advance(0.1, 1000);
        assert_eq!((uav.codes(), uav.mode()), (vec![ErrorCode::TAKEOFF], FlightMode::Takeoff));
        assert!(uav.status().velocity.is_some_and(|speed| speed.down < 0), "`down` is negative in a climb");
        fly_for(&mut uav, 10);
        assert_eq!((uav.codes(), uav.mode(), uav.coordinates()[3]), (vec![], FlightMode::Loiter, 10_000));
        let target = Target {
            latitude: home[0] + 9000,
            longitude: home[1],
            altitude: Some(Altitude::AboveHome(20_000)),
        };
        uav.command(Command::FlyTo(target)).expect("the command is valid");
        fly_for(&mut uav, 30);
        let [latitude, longitude, _, above_home, _] = uav.coordinates();
        assert!((latitude - target.latitude).abs() < 10 && (longitude - target.longitude).abs() < 10);
        assert_eq!(above_home, 20_000);
        uav.command(Command::ReturnHome).expect("the command is valid");
        uav.advance(0.1, 1000);
        assert_eq!(uav.codes(), [ErrorCode::RTH]);
        fly_for(&mut uav, 60);
        assert_eq!((uav.codes(), uav.mode()), (vec![ErrorCode::GROUND], FlightMode::Stab));
        assert!((uav.coordinates()[0] - home[0]).abs() < 10 && uav.coordinates()[3] == 0);
    }

    #[test]
    fn returns_home_and_lands_as_the_battery_drains() {
        let mut uav = Uav::new(0, 31.0, 7, 0);
        uav.command(Command::TakeOff).expect("the command is valid");
        let mut seen = Vec::new();
        for step in 0..6000 {
            uav.advance(0.1, step * 100);
            let code = uav.codes().into_iter().find(|code| BATTERY.iter().any(|(_, known)| known == code));
            if seen.last() != code.as_ref() {
                seen.extend(code);
            }
        }
        assert_eq!(seen, [ErrorCode::LOWBAT_WARNING, ErrorCode::LOWBAT_ERROR]);
        assert_eq!(uav.mode(), FlightMode::Stab, "the UAV has returned home");
        uav.set_charge(5.0);
        assert_eq!(uav.codes(), [ErrorCode::GROUND, ErrorCode::LOWBAT_FATAL]);
        assert!(uav.command(Command::TakeOff).is_err());
    }

    #[test]
    fn crashes_after_a_halt_in_the_air() {
        let mut uav = Uav::new(0, 100.0, 7, 0);
        uav.command(Command::TakeOff).expect("the command is valid");
        fly_for(&mut uav, 10);
        assert!(uav.command(Command::Motors { is_start: false, is_forced: false }).is_err());
        uav.command(Command::Halt).expect("the command is valid");
        fly_for(&mut uav, 3);
        assert_eq!(uav.codes(), [ErrorCode::GROUND, ErrorCode::CRASH]);
        assert!(uav.command(Command::TakeOff).is_err());
        uav.command(Command::Restart).expect("the command is valid");
        assert_eq!(uav.codes(), [ErrorCode::GROUND]);
    }
}
