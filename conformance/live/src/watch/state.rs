//! The reported state of a UAV (`UAVStatusInfo`). A value of the wrong type is stored as invalid and does not cause an
//! error.

use uavspec_model::json::Tree;

use super::words::truncated;
use crate::limits::{MAX_CODES, MAX_OTHERS, MAX_VALUES};

/// A value that may be missing or have the wrong type.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Field<T> {
    /// The value is missing, or marked as unknown.
    #[default]
    Absent,
    /// The value has the wrong type.
    Invalid,
    /// The value is valid.
    Known(T),
}

impl<T> Field<T> {
    /// The value, if it is valid.
    pub(crate) fn known(&self) -> Option<&T> {
        if let Self::Known(value) = self { Some(value) } else { None }
    }

    fn new(value: Option<T>) -> Self {
        value.map_or(Self::Invalid, Self::Known)
    }

    /// Makes a value absent if it denotes an unknown value.
    fn unless(self, is_unknown: impl Fn(&T) -> bool) -> Self {
        match self {
            Self::Known(value) if is_unknown(&value) => Self::Absent,
            other => other,
        }
    }
}

/// The state of a battery.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Battery {
    /// The voltage, in tenths of volts.
    pub voltage: Field<i64>,
    /// The charge, in percent.
    pub percent: Field<i64>,
    /// True if the battery is charging.
    pub is_charging: Field<bool>,
}

/// The error codes of a UAV.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Errors {
    /// The codes, most severe first.
    pub codes: Vec<u32>,
    /// The number of entries that are not codes.
    pub invalid: usize,
    /// The number of entries beyond the limit.
    pub more: usize,
}

/// The reported state of a UAV.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct State {
    /// The id of the UAV, according to this state.
    pub id: Field<String>,
    /// The time of the state according to the server's clock, in milliseconds since 1970.
    pub timestamp: Field<i64>,
    /// The mode.
    pub mode: Field<String>,
    /// The latitude and the longitude, in 1e-7 degrees, and three altitudes, in millimetres: above mean sea level,
    /// above the home position and above the ground.
    pub position: Field<[Field<i64>; 5]>,
    /// The position in local coordinates, in millimetres.
    pub position_xyz: Field<[Field<i64>; 3]>,
    /// The kind of satellite fix, from 0 to 7, the number of satellites, and the horizontal and vertical accuracy, in
    /// millimetres.
    pub gps: Field<[Field<i64>; 4]>,
    /// The heading, in tenths of degrees.
    pub heading: Field<i64>,
    /// Roll, pitch and yaw, in tenths of degrees.
    pub attitude: Field<[Field<i64>; 3]>,
    /// The velocity north, east and down, in millimetres per second.
    pub velocity: Field<[Field<i64>; 3]>,
    /// The velocity in local coordinates, in millimetres per second.
    pub velocity_xyz: Field<[Field<i64>; 3]>,
    /// The battery.
    pub battery: Field<Battery>,
    /// The colour of the light, as RGB565.
    pub light: Field<i64>,
    /// The signal strength of each radio link, in percent.
    pub rssi: Field<Vec<Field<i64>>>,
    /// The error codes.
    pub errors: Field<Errors>,
    /// Debug data, in base64.
    pub debug: Field<String>,
    /// The names and values of other fields.
    pub others: Vec<(String, String)>,
}

impl State {
    /// Reads a state; `None` if the value is not an object.
    pub(crate) fn read(tree: &Tree<'_>) -> Option<Self> {
        let Tree::Object(members) = tree else { return None };
        let mut state = Self::default();
        // If a key is repeated, the first value is used, as everywhere in this program.
        for (key, value) in members.iter().rev() {
            state.set(key, value);
        }
        Some(state)
    }

    fn set(&mut self, key: &str, value: &Tree<'_>) {
        match key {
            "id" => self.id = text(value),
            "timestamp" => self.timestamp = integer(value),
            "mode" => self.mode = text(value),
            "position" => self.position = entries(value),
            "positionXYZ" => self.position_xyz = entries(value),
            "gps" => self.gps = entries(value),
            "heading" => self.heading = integer(value),
            "attitude" => self.attitude = entries(value),
            "velocity" => self.velocity = entries(value),
            "velocityXYZ" => self.velocity_xyz = entries(value),
            "battery" => self.battery = battery(value),
            "light" => self.light = integer(value),
            "rssi" => {
                let integers = |values: &[Tree<'_>]| values.iter().take(MAX_VALUES).map(integer).collect();
                self.rssi = Field::new(list(value).map(integers));
            }
            "errors" => self.errors = Field::new(list(value).map(errors)),
            "debug" => self.debug = text(value),
            other if self.others.len() < MAX_OTHERS => {
                self.others.push((truncated(other), truncated(&value.to_string())));
            }
            _ => {}
        }
    }
}

fn text(value: &Tree<'_>) -> Field<String> {
    Field::new(value.as_str().map(truncated))
}

fn integer(value: &Tree<'_>) -> Field<i64> {
    let Tree::Int(value) = value else { return Field::Invalid };
    Field::new(i64::try_from(*value).ok())
}

fn list<'v, 't>(value: &'v Tree<'t>) -> Option<&'v [Tree<'t>]> {
    if let Tree::List(values) = value { Some(values) } else { None }
}

/// Reads an entry of a list. `null` denotes an unknown value.
fn entry(values: &[Tree<'_>], index: usize) -> Field<i64> {
    values.get(index).filter(|value| **value != Tree::Null).map_or(Field::Absent, integer)
}

fn entries<const N: usize>(value: &Tree<'_>) -> Field<[Field<i64>; N]> {
    Field::new(list(value).map(|values| std::array::from_fn(|index| entry(values, index))))
}

fn battery(value: &Tree<'_>) -> Field<Battery> {
    Field::new(list(value).map(|values| Battery {
        voltage: entry(values, 0).unless(|voltage| *voltage == 0),
        percent: entry(values, 1).unless(|percent| *percent < 0),
        is_charging: match values.get(2) {
            None | Some(Tree::Null) => Field::Absent,
            Some(Tree::Bool(is_charging)) => Field::Known(*is_charging),
            Some(_) => Field::Invalid,
        },
    }))
}

fn errors(values: &[Tree<'_>]) -> Errors {
    let code = |value: &Tree<'_>| integer(value).known().and_then(|code| u32::try_from(*code).ok());
    let truncated = &values[..values.len().min(MAX_CODES)];
    let mut codes: Vec<u32> = truncated.iter().filter_map(code).collect();
    let invalid = truncated.len() - codes.len();
    codes.sort_by_key(|code| (std::cmp::Reverse(uavspec_runtime::Severity::of(*code)), *code));
    codes.dedup();
    // 0 means no error.
    codes.retain(|code| *code != 0);
    Errors { codes, invalid, more: values.len() - truncated.len() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> State {
        State::read(&Tree::read(text).expect("JSON")).expect("an object")
    }

    #[test]
    fn distinguishes_missing_and_invalid_values() {
        let state = read(
            r#"{"mode": 7, "position": [504980000, "east", null, -1500], "battery": [0, -1, true],
                "gps": {}, "heading": 3.5, "heading": 450, "wind": [1, 2], "rssi": [80, null]}"#,
        );
        assert_eq!(state.mode, Field::Invalid);
        let position =
            [Field::Known(504_980_000), Field::Invalid, Field::Absent, Field::Known(-1500), Field::Absent];
        assert_eq!(state.position, Field::Known(position));
        let battery =
            Battery { voltage: Field::Absent, percent: Field::Absent, is_charging: Field::Known(true) };
        assert_eq!(state.battery, Field::Known(battery));
        assert_eq!((state.gps, state.heading), (Field::Invalid, Field::Invalid));
        assert_eq!(state.others, [("wind".to_owned(), "an array of 2".to_owned())]);
        assert_eq!(state.rssi, Field::Known(vec![Field::Known(80), Field::Invalid]));
        assert_eq!(state.timestamp, Field::Absent);
        assert_eq!(State::read(&Tree::Null), None);
    }

    #[test]
    fn the_most_severe_codes_come_first() {
        let state = read(r#"{"errors": [1, 0, 66, 199, 1, -1, 193, 65733, "x", 99999999999]}"#);
        let errors = state.errors.known().expect("a list");
        assert_eq!(errors.codes, [193, 199, 65733, 66, 1]);
        assert_eq!((errors.invalid, errors.more), (3, 0));
        let many: Vec<String> = (0..100).map(|code| code.to_string()).collect();
        let state = read(&format!(r#"{{"errors": [{}]}}"#, many.join(",")));
        assert_eq!(state.errors.known().map(|errors| errors.more), Some(100 - MAX_CODES));
    }
}
