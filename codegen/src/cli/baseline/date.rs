//! Calendar days, for the expiry of entries.

use std::env;
use std::time::{SystemTime, UNIX_EPOCH};

use toml::value::Date;

/// The environment variable that sets the current time, in seconds since 1970. See reproducible-builds.org.
const EPOCH_VARIABLE: &str = "SOURCE_DATE_EPOCH";

/// The length of a day in seconds.
const DAY: u64 = 86_400;

/// True if a day is over, in UTC.
#[allow(clippy::disallowed_methods, reason = "tests set the environment variable")]
pub(super) fn is_over(date: Date) -> bool {
    let fixed = env::var(EPOCH_VARIABLE).ok().and_then(|value| value.parse().ok());
    // A clock that shows a time before 1970 was never set, so nothing counts as expired.
    let clock = || SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
    i64::try_from(fixed.unwrap_or_else(clock) / DAY).is_ok_and(|today| day(date) < today)
}

/// The number of days from 1970 to a date.
fn day(date: Date) -> i64 {
    // Years that start in March have their leap day at the end. March of the year 0 is 719468 days before 1970.
    let (month, year) = (i64::from(date.month), i64::from(date.year));
    let (month, year) = if month > 2 { (month - 3, year) } else { (month + 9, year - 1) };
    let leap_days = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    365 * year + leap_days + (153 * month + 2) / 5 + i64::from(date.day) - 1 - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_days_from_1970() {
        for ((year, month, day_of_month), expected) in [
            ((1970, 1, 1), 0),
            ((1969, 12, 31), -1),
            ((2000, 2, 29), 11_016),
            ((2000, 3, 1), 11_017),
            ((2027, 6, 30), 20_999),
            ((0, 3, 1), -719_468),
        ] {
            assert_eq!(
                day(Date { year, month, day: day_of_month }),
                expected,
                "{year}-{month}-{day_of_month}"
            );
        }
    }
}
