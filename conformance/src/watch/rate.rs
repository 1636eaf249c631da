//! How many messages come a second.

use std::time::Instant;

/// Over how many seconds it is reckoned.
const WINDOW: u64 = 5;

/// How many seconds are counted: also the one that isn't over.
const NUM_SECONDS: usize = 6;

/// Counts what happens, second by second.
#[derive(Debug, Default)]
pub(super) struct Rate {
    start: Option<Instant>,
    /// For each of the last seconds which it is, and what happened in it, the latest first.
    seconds: [(u64, u32); NUM_SECONDS],
}

impl Rate {
    /// Counts something that happens now.
    pub(super) fn count(&mut self, now: Instant) {
        let start = *self.start.get_or_insert(now);
        let second = now.saturating_duration_since(start).as_secs();
        if self.seconds[0].0 != second {
            self.seconds.rotate_right(1);
            self.seconds[0] = (second, 0);
        }
        let counted = &mut self.seconds[0];
        counted.1 = counted.1.saturating_add(1);
    }

    /// How many come a second, by those seconds that are over.
    pub(super) fn per_second(&self, now: Instant) -> f64 {
        let Some(start) = self.start else { return 0.0 };
        let second = now.saturating_duration_since(start).as_secs();
        let window = second.saturating_sub(WINDOW)..second;
        let counted = self.seconds.iter().filter(|(second, _)| window.contains(second));
        let sum: u32 = counted.map(|(_, count)| *count).fold(0, u32::saturating_add);
        let over = u32::try_from(window.end - window.start).unwrap_or(u32::MAX);
        f64::from(sum) / f64::from(over.max(1))
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn it_is_reckoned_over_the_seconds_that_are_over() {
        let start = Instant::now();
        let at = |seconds: f64| start + Duration::from_secs_f64(seconds);
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
