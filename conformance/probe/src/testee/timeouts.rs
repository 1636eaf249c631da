//! Counts the requests that a testee leaves unanswered, so that a run with a testee that hangs ends soon.

use super::options::Options;

/// The ratio between the maximum numbers of timeouts in total and in a row.
const IN_ALL: u32 = 3;

/// The timeouts of a testee.
#[derive(Debug, Default)]
pub(super) struct Timeouts {
    in_a_row: u32,
    in_all: u32,
}

impl Timeouts {
    /// Counts a timeout. If there are too many, returns the reason to give up.
    pub(super) fn count(&mut self, options: &Options) -> Option<String> {
        self.in_a_row += 1;
        self.in_all += 1;
        let timeouts = if self.in_a_row >= options.max_timeouts {
            format!("{} consecutive timeouts", self.in_a_row)
        } else if self.in_all >= options.max_timeouts.saturating_mul(IN_ALL) {
            format!("{} timeouts", self.in_all)
        } else {
            return None;
        };
        Some(format!("gave up after {timeouts} of {} s", options.timeout.as_secs_f32()))
    }

    /// Records a response to a request.
    pub(super) fn answered(&mut self) {
        self.in_a_row = 0;
    }
}
