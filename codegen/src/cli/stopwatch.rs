//! The duration of a command, which the command prints.

use std::time::Instant;

/// Measures the time since its start.
#[derive(Clone, Copy)]
pub(super) struct Stopwatch(Instant);

#[allow(clippy::disallowed_methods, reason = "nothing but the printed duration depends on it")]
impl Stopwatch {
    pub(super) fn start() -> Self {
        Self(Instant::now())
    }

    pub(super) fn milliseconds(self) -> u128 {
        self.0.elapsed().as_millis()
    }
}
