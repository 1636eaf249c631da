//! The clock of a capture, which places findings in time.

use uavspec_schema::Date;

/// The earliest plausible time in UTC, in µs: 9 September 2001. Clocks that were never set show earlier times.
const MIN_UTC: u64 = 1_000_000_000_000_000;

/// The clock of a capture.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock {
    /// The time of the start of the capture, in µs.
    start: Option<u64>,
    /// The difference between the time in UTC (since 1970) and the time of the capture, in µs, if it is known.
    utc_offset: Option<u64>,
}

impl Clock {
    /// Sets the time of the start, unless it is already set.
    pub(super) fn start(&mut self, time: u64) {
        self.start.get_or_insert(time);
    }

    /// Sets the time in UTC that corresponds to a time of the capture, unless one is already set or the time in UTC is
    /// implausible.
    pub(super) fn set_utc(&mut self, time: u64, utc: u64) {
        if self.utc_offset.is_none() && utc >= MIN_UTC {
            self.utc_offset = utc.checked_sub(time);
        }
    }

    /// The time of the start, in µs, if it is known.
    pub(crate) const fn start_time(&self) -> Option<u64> {
        self.start
    }

    /// The time since the start, in s. Negative for a record that is older than the start.
    pub fn seconds(&self, time: u64) -> Option<f64> {
        let difference = i128::from(time) - i128::from(self.start?);
        #[allow(clippy::cast_precision_loss)] // µs are exact for centuries
        Some(difference as f64 / 1e6)
    }

    /// The time in UTC, in µs since 1970.
    pub fn utc_micros(&self, time: u64) -> Option<u64> {
        time.checked_add(self.utc_offset?)
    }

    /// The start in UTC, in µs since 1970.
    pub fn start_utc(&self) -> Option<u64> {
        self.utc_micros(self.start?)
    }

    /// The time in UTC, such as `2026-11-23T10:20:30.123Z`.
    pub fn utc(&self, time: u64) -> Option<String> {
        let millis = self.utc_micros(time)? / 1_000;
        let (seconds, millis) = (millis / 1_000, millis % 1_000);
        let (hour, minute, second) = (seconds / 3_600 % 24, seconds / 60 % 60, seconds % 60);
        Some(format!("{}T{hour:02}:{minute:02}:{second:02}.{millis:03}Z", Date::at(seconds)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn converts_times_since_boot() {
        let mut clock = Clock::default();
        assert_eq!((clock.seconds(1), clock.utc(1)), (None, None));
        clock.start(2_000_000);
        clock.set_utc(2_000_000, 1_000_000);
        assert_eq!((clock.seconds(3_500_000), clock.seconds(500_000)), (Some(1.5), Some(-1.5)));
        assert_eq!(clock.utc(2_000_000), None, "the time was never set");
        clock.set_utc(2_000_000, 1_793_442_030_500_000);
        clock.set_utc(2_000_000, 1_800_000_000_000_000);
        assert_eq!(clock.utc(3_000_000).as_deref(), Some("2026-10-31T10:20:31.500Z"));
        assert_eq!(clock.utc(u64::MAX), None);
    }
}
