//! Calendar days, for the expiry of known findings and failures.

use std::time::{SystemTime, UNIX_EPOCH};
use std::{env, fmt};

use chrono::{DateTime, Datelike, NaiveDate, NaiveTime};
use serde::{Serialize, Serializer};

/// The environment variable that sets the current time, in seconds since 1970. See reproducible-builds.org.
const EPOCH_VARIABLE: &str = "SOURCE_DATE_EPOCH";

/// The maximum year of a TOML date.
const LAST_YEAR: u16 = 9999;

/// A day of the Gregorian calendar, in UTC.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Date {
    /// The year, up to 9999.
    pub year: u16,
    /// The month, from 1.
    pub month: u8,
    /// The day of the month, from 1.
    pub day: u8,
}

impl Date {
    /// The current day.
    ///
    /// # Errors
    ///
    /// Fails if the `SOURCE_DATE_EPOCH` environment variable is invalid.
    #[allow(clippy::disallowed_methods, reason = "tests set the environment variable")]
    pub fn today() -> Result<Self, String> {
        if let Some(value) = env::var_os(EPOCH_VARIABLE) {
            let seconds = value.to_str().and_then(|value| value.parse().ok()).and_then(Self::at);
            return seconds.ok_or_else(|| {
                format!(
                    "{EPOCH_VARIABLE}={}: expected seconds since 1970, up to the year 9999",
                    value.to_string_lossy()
                )
            });
        }
        // A clock that shows a time before 1970 was never set, so nothing counts as expired.
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self::at(since.as_secs()).ok_or_else(|| "the system clock is after the year 9999".to_owned())
    }

    /// The day that contains a time in seconds since 1970. `None` after the year 9999.
    pub fn at(seconds: u64) -> Option<Self> {
        let date = DateTime::from_timestamp(i64::try_from(seconds).ok()?, 0)?.date_naive();
        Some(Self {
            year: u16::try_from(date.year()).ok().filter(|year| *year <= LAST_YEAR)?,
            month: u8::try_from(date.month()).ok()?,
            day: u8::try_from(date.day()).ok()?,
        })
    }

    /// The time at which the day starts, in seconds since 1970. `None` before 1970, or if the day
    /// doesn't exist.
    pub fn start(self) -> Option<u64> {
        let date = NaiveDate::from_ymd_opt(self.year.into(), self.month.into(), self.day.into())?;
        u64::try_from(date.and_time(NaiveTime::MIN).and_utc().timestamp()).ok()
    }
}

impl fmt::Display for Date {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

impl Serialize for Date {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_start_and_end_at_midnight() {
        for (start, year, month, day) in [
            (0, 1970, 1, 1),
            (951_782_400, 2000, 2, 29),
            (4_107_542_400, 2100, 3, 1),
            (253_402_214_400, 9999, 12, 31),
        ] {
            let date = Date { year, month, day };
            assert_eq!((Date::at(start), Date::at(start + 86_399)), (Some(date), Some(date)));
            assert_eq!(date.start(), Some(start));
        }
        assert_eq!(Date::at(253_402_300_800), None);
        assert_eq!(Date::at(u64::MAX), None);
        for (year, month, day) in
            [(1969, 12, 31), (2026, 2, 29), (2026, 0, 1), (2026, 13, 1), (2026, 1, 0), (0, 1, 1)]
        {
            assert_eq!(Date { year, month, day }.start(), None, "{year}-{month}-{day}");
        }
    }

    #[test]
    fn dates_are_formatted_as_in_toml() {
        assert_eq!(Date::at(1_814_313_600).map(|date| date.to_string()), Some("2027-06-30".to_owned()));
    }
}
