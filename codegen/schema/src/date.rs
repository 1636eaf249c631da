//! Calendar days, for the expiry of known findings and failures.

use std::time::{SystemTime, UNIX_EPOCH};
use std::{env, fmt};

use serde::{Serialize, Serializer};

/// The environment variable that sets the current time, in seconds since 1970. See reproducible-builds.org.
const EPOCH_VARIABLE: &str = "SOURCE_DATE_EPOCH";

/// The length of a day in seconds.
const DAY: u64 = 86_400;

/// The number of days after which the calendar repeats: 400 years with 97 leap years.
const CYCLE: u64 = 146_097;

/// The first second after the year 9999, which is the last year in TOML dates.
const END: u64 = 253_402_300_800;

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
        if seconds >= END {
            return None;
        }
        // Years that start in March have their leap day at the end. March of the year 0 is 719468 days before 1970.
        let days = seconds / DAY + 719_468;
        let in_cycle = days % CYCLE;
        // Remove the leap days: one every 4 years, except every 100 years, and the leap day at the end of the cycle.
        let year = (in_cycle - in_cycle / 1_460 + in_cycle / 36_524 - in_cycle / 146_096) / 365;
        let in_year = in_cycle - (365 * year + year / 4 - year / 100);
        // From March on, every five months have 153 days.
        let month = (5 * in_year + 2) / 153;
        let day = in_year - (153 * month + 2) / 5 + 1;
        let (month, later) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
        let year = days / CYCLE * 400 + year + later;
        Some(Self {
            year: u16::try_from(year).ok()?,
            month: u8::try_from(month).ok()?,
            day: u8::try_from(day).ok()?,
        })
    }
}

impl Date {
    /// The first second of the day, since 1970. `None` before 1970, and if the calendar lacks the day.
    pub fn start(self) -> Option<u64> {
        // The reverse of `at`.
        let (year, month) = (u64::from(self.year), u64::from(self.month));
        let (year, month) = if month > 2 { (year, month - 3) } else { (year.checked_sub(1)?, month + 9) };
        let in_cycle = year % 400 * 365 + year % 400 / 4 - year % 400 / 100;
        let days = year / 400 * CYCLE + in_cycle + (153 * month + 2) / 5 + u64::from(self.day);
        let start = days.checked_sub(719_469)? * DAY;
        (Self::at(start) == Some(self)).then_some(start)
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
    use uavspec_test_definitions::extent;

    use super::*;

    #[test]
    fn each_day_from_1970_to_9999_follows_the_previous_one() {
        let mut expected = Date { year: 1970, month: 1, day: 1 };
        let step = extent(1, 7);
        for day in 0..END / DAY {
            if day.is_multiple_of(step) {
                assert_eq!(Date::at(day * DAY), Some(expected));
                assert_eq!(Date::at(day * DAY + DAY - 1), Some(expected));
                assert_eq!(expected.start(), Some(day * DAY));
            }
            expected = after(expected);
        }
        assert_eq!(expected, Date { year: 10_000, month: 1, day: 1 });
        assert_eq!(Date::at(END), None);
        assert_eq!(Date::at(u64::MAX), None);
        for (year, month, day) in
            [(1969, 12, 31), (2026, 2, 29), (2026, 0, 1), (2026, 13, 1), (2026, 1, 0), (0, 1, 1)]
        {
            assert_eq!(Date { year, month, day }.start(), None, "{year}-{month}-{day}");
        }
    }

    fn after(date: Date) -> Date {
        let Date { year, month, day } = date;
        let is_leap = year.is_multiple_of(4) && !year.is_multiple_of(100) || year.is_multiple_of(400);
        let length = match month {
            2 => 28 + u8::from(is_leap),
            4 | 6 | 9 | 11 => 30,
            _ => 31,
        };
        match (day == length, month == 12) {
            (false, _) => Date { day: day + 1, ..date },
            (true, false) => Date { month: month + 1, day: 1, ..date },
            (true, true) => Date { year: year + 1, month: 1, day: 1 },
        }
    }

    #[test]
    fn dates_are_formatted_as_in_toml() {
        assert_eq!(Date::at(1_814_313_600).map(|date| date.to_string()), Some("2027-06-30".to_owned()));
    }
}
