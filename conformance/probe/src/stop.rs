//! Ends a probe early, on request of a signal handler or another thread.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use uavspec_model::clock::Clock;

use super::commanded::Commanded;

/// The maximum time until a waiting probe notices a request to stop.
pub(super) const NOTICE_TIME: Duration = Duration::from_millis(50);

/// A handle that ends a probe early. The probe first makes the commanded UAVs safe: it lands them, stops their motors
/// and wakes them. All clones refer to the same probe.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    is_requested: AtomicBool,
    /// True while the probe makes UAVs safe. Nothing may interrupt it then.
    is_deferred: AtomicBool,
    commanded: Mutex<Commanded>,
}

impl Stop {
    /// Requests the end of the probe. Returns false if this has already been requested.
    pub fn request(&self) -> bool {
        !self.0.is_requested.swap(true, Ordering::SeqCst)
    }

    /// True if the end of the probe has been requested.
    pub fn is_requested(&self) -> bool {
        self.0.is_requested.load(Ordering::SeqCst)
    }

    /// The UAVs that have received commands and aren't known to be safe at this moment, such as `UAV 07 may still fly`.
    /// `None` if there are none.
    pub fn at_risk(&self) -> Option<String> {
        self.commanded().at_risk()
    }

    /// True if the probe must stop what it is doing.
    pub(super) fn is_due(&self) -> bool {
        self.is_requested() && !self.0.is_deferred.load(Ordering::SeqCst)
    }

    /// Defers requests to stop until the returned value is dropped.
    pub(super) fn defer(&self) -> Deferred {
        self.0.is_deferred.store(true, Ordering::SeqCst);
        Deferred(self.clone())
    }

    /// The commands that have not been undone yet.
    pub(super) fn commanded(&self) -> MutexGuard<'_, Commanded> {
        self.0.commanded.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sleeps until the time has passed or the probe must stop.
    pub(super) fn sleep(&self, clock: &Clock, time: Duration) {
        clock.poll(clock.now() + time, NOTICE_TIME, || self.is_due().then_some(()));
    }

    /// Runs a function that may block in a separate thread. Returns `None` if the probe must stop, in which case the
    /// thread finishes by itself, or if the function panics.
    pub(super) fn run<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Option<T> {
        let (sender, result) = channel();
        thread::spawn(move || {
            // If the probe has stopped, nothing receives the result.
            let _ = sender.send(work());
        });
        loop {
            match result.recv_timeout(NOTICE_TIME) {
                Ok(result) => return Some(result),
                Err(RecvTimeoutError::Timeout) if !self.is_due() => {}
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => return None,
            }
        }
    }
}

/// Requests to stop are deferred until this value is dropped.
pub(super) struct Deferred(Stop);

impl Drop for Deferred {
    fn drop(&mut self) {
        self.0.0.is_deferred.store(false, Ordering::SeqCst);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_end_all_waits_unless_they_are_deferred() {
        let (stop, clock) = (Stop::default(), Clock::simulated());
        assert_eq!(stop.run(|| 7), Some(7));
        assert!(stop.request() && !stop.request());
        let start = clock.now();
        stop.sleep(&clock, Duration::from_secs(9));
        assert_eq!(clock.now(), start);
        // The function doesn't end, but the call does.
        let (sender, receiver) = channel::<()>();
        assert_eq!(stop.run(move || receiver.recv()), None);
        let deferred = stop.defer();
        assert!(!stop.is_due() && stop.is_requested());
        stop.sleep(&clock, Duration::from_secs(9));
        assert_eq!(clock.now() - start, Duration::from_secs(9));
        assert_eq!(stop.run(|| 7), Some(7));
        drop((deferred, sender));
        assert!(stop.is_due());
    }

    #[test]
    fn a_panic_of_a_blocking_function_is_no_result() {
        assert_eq!(Stop::default().run(|| -> u8 { panic!("expected by this test") }), None);
    }
}
