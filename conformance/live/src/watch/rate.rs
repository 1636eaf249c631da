//! The rate of messages.

use std::time::Duration;

/// The number of seconds over which the rate is averaged.
const WINDOW: usize = 5;

/// Counts messages per second.
#[derive(Clone, Debug, Default)]
pub(super) struct Rate {
    /// The number of messages in each second of the window, and in the current second. Each entry also contains the
    /// second. The latest comes first.
    seconds: [(u64, u32); WINDOW + 1],
}

impl Rate {
    /// Counts a message. `elapsed` is the time since the first one.
    pub(super) fn count(&mut self, elapsed: Duration) {
        let second = elapsed.as_secs();
        if self.seconds[0].0 != second {
            self.seconds.rotate_right(1);
            self.seconds[0] = (second, 0);
        }
        let counted = &mut self.seconds[0];
        counted.1 = counted.1.saturating_add(1);
    }

    /// The average number per second over the completed seconds of the window.
    pub(super) fn per_second(&self, elapsed: Duration) -> f64 {
        let second = elapsed.as_secs();
        let window = second.saturating_sub(WINDOW as u64)..second;
        let counted = self.seconds.iter().filter(|(second, _)| window.contains(second));
        let sum: u32 = counted.map(|(_, count)| *count).fold(0, u32::saturating_add);
        let over = u32::try_from(window.end - window.start).unwrap_or(u32::MAX);
        f64::from(sum) / f64::from(over.max(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averages_over_completed_seconds() {
        let at = Duration::from_secs_f64;
        let mut rate = Rate::default();
        let per_second = |rate: &Rate, seconds: f64| format!("{:.2}", rate.per_second(at(seconds)));
        assert_eq!(per_second(&rate, 1.0), "0.00");
        for tenth in 0..100 {
            rate.count(at(f64::from(tenth) / 10.0 + 0.05));
        }
        for (seconds, expected) in [(10.1, "10.00"), (12.5, "6.00"), (20.0, "0.00")] {
            assert_eq!(per_second(&rate, seconds), expected);
        }
    }
}
