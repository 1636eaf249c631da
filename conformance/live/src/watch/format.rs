//! Values as text: a dash for missing values, `?` for values of a wrong type.

use std::time::Duration;

use super::state::{Battery, Field};

/// The text for a missing value.
pub(super) const MISSING_VALUE: &str = "-";

/// The text for a value of a wrong type.
pub(super) const INVALID_VALUE: &str = "?";

/// Formats a field.
pub(super) fn field<T>(field: &Field<T>, format: impl FnOnce(&T) -> String) -> String {
    match field {
        Field::Absent => MISSING_VALUE.to_owned(),
        Field::Invalid => INVALID_VALUE.to_owned(),
        Field::Known(value) => format(value),
    }
}

/// Formats a numeric field.
pub(super) fn number(number: &Field<i64>, format: impl FnOnce(i64) -> String) -> String {
    field(number, |number| format(*number))
}

/// Formats a numeric part of an optional field. `part` returns this part of the whole.
pub(super) fn part<T>(
    whole: Option<&Field<T>>,
    part: impl FnOnce(&T) -> &Field<i64>,
    format: impl FnOnce(i64) -> String,
) -> String {
    match whole {
        None => MISSING_VALUE.to_owned(),
        Some(whole) => field(whole, |whole| number(part(whole), format)),
    }
}

/// Formats `number` × 10^-`digits` with some decimals.
pub(super) fn fixed(number: i64, digits: u32, decimals: u32) -> String {
    let divisor = 10_u128.pow(digits.saturating_sub(decimals));
    let rounded = (u128::from(number.unsigned_abs()) + divisor / 2) / divisor;
    let sign = if number < 0 && rounded != 0 { "-" } else { "" };
    let unit = 10_u128.pow(decimals);
    if decimals == 0 {
        return format!("{sign}{rounded}");
    }
    format!("{sign}{}.{:0width$}", rounded / unit, rounded % unit, width = decimals as usize)
}

/// Latitude and longitude in degrees.
pub(super) fn coordinates(position: Option<&Field<[Field<i64>; 5]>>, decimals: u32) -> [String; 2] {
    [0, 1].map(|at| part(position, |position| &position[at], |number| fixed(number, 7, decimals)))
}

/// Formats millimetres as metres.
pub(super) fn metres(millimetres: i64) -> String {
    fixed(millimetres, 3, 1)
}

/// Formats tenths of volts as volts.
pub(super) fn volts(tenths: i64) -> String {
    fixed(tenths, 1, 1)
}

/// The charge of a battery, followed by a plus sign while the battery is charging.
pub(super) fn charge(battery: Option<&Field<Battery>>) -> String {
    let percent = part(battery, |battery| &battery.percent, |percent| format!("{percent}%"));
    let is_charging = battery.and_then(Field::known).map(|battery| &battery.is_charging);
    if is_charging == Some(&Field::Known(true)) { percent + "+" } else { percent }
}

/// A duration in its largest unit, in at most five characters.
pub(super) fn age(age: Option<Duration>) -> String {
    let Some(age) = age else { return MISSING_VALUE.to_owned() };
    match age.as_secs() {
        seconds @ 0..60 => format!("{seconds}s"),
        seconds @ 60..3600 => format!("{}min", seconds / 60),
        seconds @ 3600..86_400 => format!("{}h", seconds / 3600),
        seconds @ 86_400..8_640_000 => format!("{}d", seconds / 86_400),
        _ => ">99d".to_owned(),
    }
}

/// The first sentence of a text.
pub(super) fn first_sentence(text: &str) -> &str {
    text.split_once(". ").map_or(text, |(first, _)| first).trim_end_matches('.')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_numbers() {
        for (number, digits, decimals, text) in [
            (504_980_000, 7, 5, "50.49800"),
            (-1_799_999_999, 7, 5, "-180.00000"),
            (-1_799_999_999, 7, 7, "-179.9999999"),
            (-49, 3, 1, "0.0"),
            (-50, 3, 1, "-0.1"),
            (126, 1, 1, "12.6"),
            (1449, 1, 0, "145"),
            (i64::MIN, 3, 1, "-9223372036854775.8"),
        ] {
            assert_eq!(fixed(number, digits, decimals), text);
        }
    }

    #[test]
    fn ages_are_short() {
        let shown = |seconds| age(Some(Duration::from_secs(seconds)));
        let texts = [0, 59, 60, 3599, 3600, 86_400, 8_639_999, u64::MAX].map(shown);
        assert_eq!(texts, ["0s", "59s", "1min", "59min", "1h", "1d", "99d", ">99d"]);
        assert_eq!(age(None), MISSING_VALUE);
    }

    #[test]
    fn marks_missing_and_invalid_values() {
        let battery =
            |percent, is_charging| Field::Known(Battery { percent, is_charging, voltage: Field::Absent });
        for (battery, text) in [
            (None, "-"),
            (Some(Field::Invalid), "?"),
            (Some(battery(Field::Invalid, Field::Invalid)), "?"),
            (Some(battery(Field::Absent, Field::Known(true))), "-+"),
            (Some(battery(Field::Known(7), Field::Known(false))), "7%"),
        ] {
            assert_eq!(charge(battery.as_ref()), text);
        }
        assert_eq!(first_sentence("Strong wind. Use it rarely."), "Strong wind");
    }
}
