//! Progress bars, on standard error if it is a terminal.

use std::io::{self, IsTerminal as _, Read};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// The interval at which the elapsed time is updated.
const TICK: Duration = Duration::from_millis(500);

/// A progress bar. It disappears when it is dropped.
pub(super) struct Progress(ProgressBar, AtomicU64);

impl Progress {
    /// Creates a bar that counts steps. `noun` names the steps, such as `cases`.
    pub(super) fn steps(noun: &'static str) -> Self {
        Self::shown("{wide_bar} {human_pos} of {human_len} {msg}, {elapsed}").with_message(noun)
    }

    /// Sets the number of finished steps and the total. If a terminal accepts no output, only a new total may block the
    /// caller, because a probe must be able to land UAVs.
    pub(super) fn set(&self, done: usize, total: usize) {
        if self.1.swap(total as u64, Ordering::Relaxed) != total as u64 {
            self.0.set_length(total as u64);
        }
        self.0.set_position(done as u64);
    }

    /// Replaces the text next to the bar.
    pub(super) fn describe(&self, text: String) {
        self.0.set_message(text);
    }

    /// Creates a bar for an elapsing time. `describe` sets the text next to it.
    pub(super) fn time() -> Self {
        Self::shown("{wide_bar} {msg}, {elapsed}")
    }

    /// Creates a bar that counts bytes up to a total.
    pub(super) fn bytes(total: u64) -> Self {
        let progress =
            Self::shown("{wide_bar} {bytes} of {total_bytes} ({bytes_per_sec}), {elapsed}, {eta} left");
        progress.0.set_length(total);
        progress
    }

    /// Returns a reader that reads `input` and advances the bar.
    pub(super) fn reading(&self, input: impl Read + Send + 'static) -> Box<dyn Read + Send> {
        Box::new(self.0.wrap_read(input))
    }

    /// Hides the bar while `write` writes to the terminal.
    pub(super) fn pausing<T>(&self, write: impl FnOnce() -> T) -> T {
        self.0.suspend(write)
    }

    fn shown(template: &str) -> Self {
        if !io::stderr().is_terminal() {
            return Self(ProgressBar::hidden(), AtomicU64::new(0));
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        // If the template is invalid, the default style is used.
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(TICK);
        Self(bar, AtomicU64::new(0))
    }

    fn with_message(self, message: &'static str) -> Self {
        self.0.set_message(message);
        self
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
