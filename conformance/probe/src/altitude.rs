//! Altitudes of UAVs, and how the probe decides that a UAV is on the ground.

use std::time::{Duration, Instant};

use serde_json::Value;
use uavspec_types::flockwave::ErrorCode;

use super::commanded::has_code;

/// The height in mm above which a UAV is in the air, and below which it is on the ground. The reported altitude of a
/// UAV on the ground varies.
pub(super) const AIRBORNE: i64 = 1_500;
const LANDED: i64 = 700;

/// The time for which a UAV must be still before it counts as landed, and the maximum change in altitude, in mm, of a
/// UAV that is still.
const STILL_TIME: Duration = Duration::from_secs(2);
const STILL: u64 = 200;

/// The altitude of a UAV, in mm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Altitude {
    AboveHome(i64),
    AboveSea(i64),
}

impl Altitude {
    /// The altitude in the status of a UAV, if it is known.
    pub(super) fn of(status: &Value) -> Option<Self> {
        let position = &status["position"];
        let above_home = position[3].as_i64().map(Self::AboveHome);
        above_home.or_else(|| position[2].as_i64().map(Self::AboveSea))
    }

    /// The height above another altitude, in mm. `None` if the altitudes have different references.
    pub(super) fn above(self, other: Self) -> Option<i64> {
        match (self, other) {
            (Self::AboveHome(now), Self::AboveHome(before))
            | (Self::AboveSea(now), Self::AboveSea(before)) => now.checked_sub(before),
            _ => None,
        }
    }
}

/// The altitude of a UAV before its flight, and the state of the flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Flight {
    ground: Altitude,
    /// True if the UAV has been in the air.
    was_in_air: bool,
}

impl Flight {
    /// The flight of a UAV that is on the ground.
    pub(super) fn new(ground: Altitude) -> Self {
        Self { ground, was_in_air: false }
    }

    /// Takes an altitude of the UAV. Returns the height above the ground in mm, if it is known.
    pub(super) fn see(&mut self, altitude: Altitude) -> Option<i64> {
        let height = altitude.above(self.ground)?;
        self.was_in_air |= height > AIRBORNE;
        Some(height)
    }
}

/// The height of a UAV above the ground in mm. `None` if the height is unknown.
pub(super) fn height(flight: Option<&mut Flight>, status: &Value) -> Option<i64> {
    flight?.see(Altitude::of(status)?)
}

/// The descent of a UAV after a command to land.
#[derive(Debug, Default)]
pub(super) struct Descent {
    /// The greatest height since the UAV last descended, in mm.
    highest: Option<i64>,
    /// The time at which the UAV last descended. `None` if it hasn't descended.
    pub(super) progressed_at: Option<Instant>,
}

impl Descent {
    /// Takes a height of the UAV in mm.
    pub(super) fn see(&mut self, height: i64, now: Instant) {
        match self.highest {
            Some(highest) if height <= highest => {
                if height.abs_diff(highest) >= STILL {
                    (self.highest, self.progressed_at) = (Some(height), Some(now));
                }
            }
            _ => self.highest = Some(height),
        }
    }
}

/// Decides from consecutive statuses of a UAV that it is on the ground. A UAV that passes through a low height, or that
/// has stopped reporting, doesn't count as being on the ground.
#[derive(Debug, Default)]
pub(super) struct Touchdown {
    /// The first status since which the UAV has been still near the ground: its time, its altitude in mm, and its
    /// timestamp.
    since: Option<(Instant, i64, Value)>,
}

impl Touchdown {
    /// Takes a status of the UAV. Returns an error with the reason if the UAV isn't known to be on the ground.
    pub(super) fn see(
        &mut self,
        flight: Option<&mut Flight>,
        status: &Value,
        now: Instant,
    ) -> Result<(), String> {
        let seen = flight.zip(Altitude::of(status));
        let seen = seen.and_then(|(flight, altitude)| Some((flight.see(altitude)?, flight.was_in_air)));
        let Some((height, was_in_air)) = seen else {
            self.since = None;
            return Err("its altitude is unknown".to_owned());
        };
        if height >= LANDED {
            self.since = None;
            return Err(format!("its altitude is {height} mm above the ground"));
        }
        // A UAV may wait on the ground before it climbs. This isn't a landing.
        if [ErrorCode::TAKEOFF, ErrorCode::MOTORS, ErrorCode::RTH].iter().any(|code| has_code(status, *code))
        {
            self.since = None;
            return Err("it may be taking off".to_owned());
        }
        let timestamp = &status["timestamp"];
        match &self.since {
            Some((since, before, reported)) if height.abs_diff(*before) < STILL => {
                if now.saturating_duration_since(*since) < STILL_TIME {
                    Err("it may be moving".to_owned())
                } else if timestamp == reported && !was_in_air {
                    // Otherwise, the change in altitude shows that the status is new.
                    Err("it no longer reports its altitude".to_owned())
                } else {
                    Ok(())
                }
            }
            _ => {
                self.since = Some((now, height, timestamp.clone()));
                Err("it may be moving".to_owned())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;
    use uavspec_model::clock::Clock;

    use super::*;

    /// The result for a UAV whose altitude at takeoff was 3 m. Each status consists of a time in seconds, an altitude
    /// in mm, and a timestamp.
    fn last(states: &[(u64, Value, u64)]) -> Result<(), String> {
        let (mut touchdown, start) = (Touchdown::default(), Clock::simulated().now());
        let mut flight = Flight::new(Altitude::AboveHome(3_000));
        let mut result = Err("no state".to_owned());
        for (seconds, altitude, timestamp) in states {
            let body = json!({ "timestamp": timestamp, "position": [1, 2, 900_000, altitude] });
            result = touchdown.see(Some(&mut flight), &body, start + Duration::from_secs(*seconds));
        }
        result
    }

    #[test]
    fn a_uav_that_is_still_near_the_ground_has_landed() {
        assert_eq!(last(&[(0, json!(3_050), 1), (1, json!(3_150), 2), (2, json!(3_000), 3)]), Ok(()));
        // The altitude may be lower than at takeoff.
        assert_eq!(last(&[(0, json!(9_000), 1), (5, json!(2_900), 5), (7, json!(2_950), 7)]), Ok(()));
    }

    #[test]
    fn a_uav_that_passes_hovers_or_bounces_has_not_landed() {
        for (states, reason) in [
            (vec![(0, json!(3_000), 1)], "moving"),
            (vec![(0, json!(3_600), 1), (2, json!(3_000), 3)], "moving"),
            (vec![(0, json!(3_000), 1), (1, json!(3_000), 2)], "moving"),
            (vec![(0, json!(3_000), 1), (1, json!(8_000), 2), (2, json!(3_000), 3)], "moving"),
            (vec![(0, json!(3_800), 1), (9, json!(3_800), 9)], "800 mm above the ground"),
            (vec![(0, json!(i64::MIN + 3_000), 1), (9, json!(0), 9)], "moving"),
        ] {
            let error = last(&states).expect_err(reason);
            assert!(error.contains(reason), "{states:?}: {error}");
        }
    }

    #[test]
    fn a_uav_whose_altitude_is_unknown_or_old_has_not_landed() {
        let old = last(&[(0, json!(3_000), 1), (9, json!(3_000), 1)]).expect_err("old");
        assert!(old.contains("no longer reports"), "{old}");
        // A server may not set timestamps, but the UAV has descended.
        assert_eq!(last(&[(0, json!(9_000), 0), (5, json!(3_000), 0), (9, json!(3_000), 0)]), Ok(()));
        // The other altitude has a different reference.
        let unknown = last(&[(0, json!(3_000), 1), (9, Value::Null, 9)]).expect_err("unknown");
        assert_eq!(unknown, "its altitude is unknown");
        let (mut touchdown, now) = (Touchdown::default(), Clock::simulated().now());
        let status = json!({ "timestamp": 1, "position": [1, 2, 900_000, 0] });
        assert_eq!(touchdown.see(None, &status, now).expect_err("unknown"), "its altitude is unknown");
        let mut flight = Flight::new(Altitude::AboveSea(0));
        assert!(touchdown.see(Some(&mut flight), &Value::Null, now).is_err());
    }

    #[test]
    fn a_uav_that_waits_for_its_takeoff_has_not_landed() {
        let mut flight = Flight::new(Altitude::AboveSea(0));
        for (codes, is_safe) in [(vec![5], false), (vec![8], false), (vec![63], false), (vec![1], true)] {
            let (mut touchdown, now) = (Touchdown::default(), Clock::simulated().now());
            let mut see = |seconds: u64| {
                let status = json!({ "timestamp": seconds, "position": [1, 2, 0], "errors": codes });
                touchdown.see(Some(&mut flight), &status, now + Duration::from_secs(seconds))
            };
            assert!(see(0).is_err());
            assert_eq!(see(3).is_ok(), is_safe, "{codes:?}");
        }
    }

    #[test]
    fn a_uav_descends_if_it_drops_below_its_greatest_height() {
        let (mut descent, now) = (Descent::default(), Clock::simulated().now());
        let mut at = |seconds: u64, height: i64| {
            let now = now + Duration::from_secs(seconds);
            descent.see(height, now);
            descent.progressed_at == Some(now)
        };
        let seen = [(0, 5_000), (1, 6_000), (2, 5_900), (3, 5_800), (4, 5_700), (5, 5_500)];
        let seen: Vec<bool> = seen.map(|(seconds, height)| at(seconds, height)).into();
        assert_eq!(seen, [false, false, false, true, false, true]);
        assert!(at(6, i64::MIN) && !at(7, i64::MAX), "heights may be any numbers");
    }

    #[test]
    fn altitudes_prefer_the_height_above_home() {
        let altitude = |position: Value| Altitude::of(&json!({ "position": position }));
        assert_eq!(altitude(json!([1, 2, 900, 5])), Some(Altitude::AboveHome(5)));
        assert_eq!(altitude(json!([1, 2, 900])), Some(Altitude::AboveSea(900)));
        assert_eq!(altitude(json!([1, 2])), None);
        assert_eq!(Altitude::AboveSea(9).above(Altitude::AboveHome(1)), None);
        assert_eq!(Altitude::AboveSea(i64::MAX).above(Altitude::AboveSea(-1)), None);
    }
}
