//! How far long work has come, on standard error where that is a terminal.

use std::io::{self, IsTerminal as _, Read};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// How often the time that it takes is shown anew where nothing else happens.
const TICK: Duration = Duration::from_millis(500);

/// A line that says how far work has come; it is gone when this is dropped.
pub(super) struct Progress(ProgressBar);

impl Progress {
    /// Work in steps, which are `what`, such as `cases`.
    pub(super) fn steps(what: &'static str) -> Self {
        Self::shown("{wide_bar} {human_pos} of {human_len} {msg}, {elapsed}").with_message(what)
    }

    /// Says how much is done, and how much there is.
    pub(super) fn set(&self, done: usize, total: usize) {
        self.0.set_length(total as u64);
        self.0.set_position(done as u64);
    }

    /// Reading of so many bytes.
    pub(super) fn bytes(total: u64) -> Self {
        let progress = Self::shown("{wide_bar} {bytes} of {total_bytes} ({bytes_per_sec}), {elapsed}");
        progress.0.set_length(total);
        progress
    }

    /// What is read of `input` is counted.
    pub(super) fn reading(&self, input: impl Read + Send + 'static) -> Box<dyn Read + Send> {
        Box::new(self.0.wrap_read(input))
    }

    /// Makes room for what is written to the terminal.
    pub(super) fn pausing<T>(&self, write: impl FnOnce() -> T) -> T {
        self.0.suspend(write)
    }

    fn shown(template: &str) -> Self {
        if !io::stderr().is_terminal() {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        // A template that can't be read gives the library's own line.
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(TICK);
        Self(bar)
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
