//! The times of records. Programs that record sessions write them in various forms.

use uavspec_model::json::Tree;
use uavspec_schema::Date;

/// The first number that is too large for a time in seconds since 1970: it would be in the year 5138. Larger numbers
/// are in smaller units, and denote times after 1973.
const TOO_LATE: f64 = 1e11;

/// The smaller units: the number of units in a second.
const UNITS: [f64; 3] = [1e3, 1e6, 1e9];

/// A time in seconds since 1970. `None` if the value isn't a time, or is ambiguous, such as a date without a time zone.
pub(super) fn seconds(value: &Tree<'_>) -> Option<f64> {
    match value {
        #[allow(clippy::cast_precision_loss)] // times are small enough
        Tree::Int(value) => of_number(*value as f64),
        Tree::Float(value, _) => of_number(*value),
        Tree::Text(text) => of_text(text.trim()),
        _ => None,
    }
}

/// A time in seconds since 1970, from a number of seconds, milliseconds, microseconds or nanoseconds.
pub(super) fn of_number(value: f64) -> Option<f64> {
    // Small negative numbers would be rounded to 0.
    let is_plausible = |seconds: &f64| value >= 0.0 && *seconds < TOO_LATE;
    // A float can represent microseconds since 1970 exactly, but not nanoseconds.
    let smaller = UNITS.into_iter().map(|unit| (value / unit * 1e6).round() / 1e6);
    std::iter::once(value).chain(smaller).find(is_plausible)
}

fn of_text(text: &str) -> Option<f64> {
    let is_number = text.starts_with(|start: char| start.is_ascii_digit()) && !text.contains(':');
    if is_number { of_number(text.parse().ok()?) } else { of_date(text) }
}

/// A time in seconds since 1970, from a text such as `2026-09-21T14:13:28.399+02:00`.
fn of_date(text: &str) -> Option<f64> {
    let (day, time) = text.split_at_checked(10)?;
    let mut fields = day.split('-');
    let date = Date {
        year: digits(fields.next()?, 4)?,
        month: u8::try_from(digits(fields.next()?, 2)?).ok()?,
        day: u8::try_from(digits(fields.next()?, 2)?).ok()?,
    };
    let (time, ahead) = zone(time.strip_prefix(['T', 't', ' '])?)?;
    #[allow(clippy::cast_precision_loss)] // up to the year 9999
    let start = date.start()? as f64;
    of_number(start + clock(time)? - ahead)
}

/// Splits the time zone from a time. Also returns the number of seconds by which the zone is ahead of UTC.
fn zone(time: &str) -> Option<(&str, f64)> {
    if let Some(time) = time.strip_suffix(['Z', 'z']) {
        return Some((time.trim_end(), 0.0));
    }
    let at = time.rfind(['+', '-'])?;
    let (time, zone) = time.split_at(at);
    let sign = if zone.starts_with('-') { -1.0 } else { 1.0 };
    let (hours, minutes) = zone[1..].split_at_checked(2)?;
    let minutes = minutes.strip_prefix(':').unwrap_or(minutes);
    let minutes = if minutes.is_empty() { 0 } else { digits(minutes, 2)? };
    Some((time.trim_end(), sign * f64::from(digits(hours, 2)? * 60 + minutes) * 60.0))
}

/// The number of seconds since midnight, from a text such as `14:13:28.399`.
fn clock(time: &str) -> Option<f64> {
    let mut fields = time.split(':');
    let (hours, minutes) = (digits(fields.next()?, 2)?, digits(fields.next()?, 2)?);
    let seconds = fields.next()?.replace(',', ".");
    let (whole, fraction) = seconds.split_once('.').unwrap_or((&seconds, "0"));
    let is_valid = hours < 24 && minutes < 60 && digits(whole, 2)? <= 60 && fields.next().is_none();
    let is_fraction = fraction.bytes().all(|byte| byte.is_ascii_digit());
    let seconds: f64 = seconds.parse().ok().filter(|_| is_valid && is_fraction)?;
    Some(f64::from(hours) * 3_600.0 + f64::from(minutes) * 60.0 + seconds)
}

/// Parses a number with exactly this number of digits.
fn digits(text: &str, length: usize) -> Option<u16> {
    let is_number = text.len() == length && text.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| text.parse().ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Option<f64> {
        seconds(&Tree::read(text).expect("JSON"))
    }

    #[test]
    fn reads_unambiguous_times() {
        let texts = [
            "1790000008.5",
            "17900000085e-1",
            "1790000008500",
            "1790000008500000",
            "1790000008500000000",
            "\"1790000008.5\"",
            "\" 1790000008500 \"",
            "\"2026-09-21T14:13:28.5Z\"",
            "\"2026-09-21 14:13:28.500000+00:00\"",
            "\"2026-09-21t14:13:28,5 z\"",
            "\"2026-09-21T16:13:28.5+02:00\"",
            "\"2026-09-21T16:13:28.5+02\"",
            "\"2026-09-20T23:43:28.5-1430\"",
        ];
        for text in texts {
            assert_eq!(read(text), Some(1_790_000_008.5), "{text}");
        }
        assert_eq!(read("0"), Some(0.0));
        assert_eq!(read("12.5"), Some(12.5), "a time since another moment");
        assert_eq!(read("\"2024-02-29T00:00:60Z\""), Some(1_709_164_860.0));
    }

    #[test]
    fn other_times_are_not_read() {
        let texts = [
            "-1790000000.0",
            "-1",
            "1e20",
            "1e400",
            "true",
            "{}",
            "[1790000000]",
            "\"\"",
            "\"now\"",
            "\"nan\"",
            "\"1e999\"",
            "\"2026-09-21T14:13:28\"",
            "\"2026-09-21\"",
            "\"14:13:28Z\"",
            "\"2026-02-29T00:00:00Z\"",
            "\"2026-13-01T00:00:00Z\"",
            "\"2026-09-21T24:00:00Z\"",
            "\"2026-09-21T14:13Z\"",
            "\"2026-09-21T14:13:28.+5Z\"",
            "\"1969-12-31T23:59:59Z\"",
            "\"2026-09-\u{e9}1T14:13:28Z\"",
            "\"2026-09-21T14:13:28+\u{e9}\"",
        ];
        for text in texts {
            assert_eq!(read(text), None, "{text}");
        }
    }
}
