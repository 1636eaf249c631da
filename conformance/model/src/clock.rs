//! The clock for all waits. It runs in real time for users, and in simulated time for tests and for the self-test.
//!
//! Simulated time takes no real time, and results don't depend on the speed of the computer: one thread runs at a time,
//! and time passes only when all threads wait.
//!
//! ```
//! # use std::time::Duration;
//! # use uavspec_model::clock::Clock;
//! let clock = Clock::simulated();
//! let start = clock.now();
//! clock.sleep(Duration::from_secs(3600));
//! assert_eq!(clock.now() - start, Duration::from_secs(3600));
//! ```

mod simulation;

use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, Scope, ScopedJoinHandle};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use self::simulation::Participant;

/// The length of a single wait if there is no time limit, about a year. After it, the condition is checked again.
const LONG: Duration = Duration::from_secs(1 << 25);

/// A source of time. Use clones only in the same thread. [`spawn`](Self::spawn) creates a clock for another thread.
#[derive(Clone, Debug, Default)]
pub struct Clock(Option<Arc<Participant>>);

#[allow(clippy::disallowed_methods, reason = "this is the only place that uses the real clock")]
impl Clock {
    /// The clock of the system.
    #[must_use]
    pub const fn real() -> Self {
        Self(None)
    }

    /// Starts a simulation, in which time passes only while all its threads wait. Returns the clock of the calling
    /// thread, which is the first thread of the simulation.
    #[must_use]
    pub fn simulated() -> Self {
        Self(Some(Arc::new(Participant::first())))
    }

    /// The time. Any thread can call this.
    #[must_use]
    pub fn now(&self) -> Instant {
        self.0.as_ref().map_or_else(Instant::now, |participant| participant.now())
    }

    /// The time since 1970. Simulated time starts at the same time in each run.
    #[must_use]
    pub fn since_1970(&self) -> Duration {
        match &self.0 {
            None => SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default(),
            Some(participant) => participant.since_1970(),
        }
    }

    /// The duration until a time; zero if it has passed.
    #[must_use]
    pub fn left(&self, until: Instant) -> Duration {
        until.saturating_duration_since(self.now())
    }

    /// Waits for a duration.
    pub fn sleep(&self, duration: Duration) {
        self.sleep_until(self.now() + duration);
    }

    /// Waits until a time.
    pub fn sleep_until(&self, until: Instant) {
        match &self.0 {
            None => thread::sleep(self.left(until)),
            Some(participant) => participant.wait(until, || None).unwrap_or_default(),
        }
    }

    /// Calls a function repeatedly until it returns a value; `None` if the time limit is reached first. In real time,
    /// `interval` is the pause between calls. In simulated time, the function is called when another thread may have
    /// changed something.
    pub fn poll<T>(
        &self,
        until: Instant,
        interval: Duration,
        mut check: impl FnMut() -> Option<T>,
    ) -> Option<T> {
        if let Some(participant) = &self.0 {
            return participant.wait(until, check);
        }
        loop {
            let (value, left) = (check(), self.left(until));
            if value.is_some() || left.is_zero() {
                return value;
            }
            thread::sleep(interval.min(left));
        }
    }

    /// Waits until a condition on shared data no longer holds, or until the time limit, if there is one. Other threads
    /// must notify `changed` after they change the data.
    pub fn wait_while<'m, T>(
        &self,
        (shared, changed): (&'m Mutex<T>, &Condvar),
        until: Option<Instant>,
        mut condition: impl FnMut(&mut T) -> bool,
    ) -> MutexGuard<'m, T> {
        let lock = || shared.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(participant) = &self.0 {
            let until = until.unwrap_or_else(|| self.now() + LONG);
            participant.wait(until, || (!condition(&mut *lock())).then_some(()));
            return lock();
        }
        let mut guard = lock();
        while condition(&mut guard) {
            let left = until.map_or(LONG, |until| self.left(until));
            if left.is_zero() {
                break;
            }
            guard = changed.wait_timeout(guard, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        guard
    }

    /// Receives a value from a channel, and waits for it until a given time.
    ///
    /// # Errors
    /// Fails if no value arrives in time, or if all senders have been dropped.
    pub fn receive<T>(&self, channel: &Receiver<T>, until: Instant) -> Result<T, RecvTimeoutError> {
        let Some(participant) = &self.0 else { return channel.recv_timeout(self.left(until)) };
        let received = participant.wait(until, || match channel.try_recv() {
            Ok(value) => Some(Ok(value)),
            Err(TryRecvError::Disconnected) => Some(Err(RecvTimeoutError::Disconnected)),
            Err(TryRecvError::Empty) => None,
        });
        received.unwrap_or(Err(RecvTimeoutError::Timeout))
    }

    /// Runs a function in another thread, and passes it a clock that shows the same time.
    pub fn spawn<'s, T: Send + 's>(
        &self,
        scope: &'s Scope<'s, '_>,
        run: impl FnOnce(&Self) -> T + Send + 's,
    ) -> Task<'s, T> {
        let clock = Self(self.0.as_ref().map(|participant| Arc::new(participant.another())));
        let simulated = self.0.clone().zip(clock.0.as_ref().map(|participant| participant.id()));
        let thread = scope.spawn(move || {
            if let Some(participant) = &clock.0 {
                participant.await_turn();
            }
            run(&clock)
        });
        Task { thread: Some(thread), simulated }
    }
}

/// A thread that [`Clock::spawn`] started. In simulated time, the spawning thread must [`join`](Self::join) it.
#[must_use]
#[derive(Debug)]
pub struct Task<'s, T> {
    thread: Option<ScopedJoinHandle<'s, T>>,
    /// The spawning thread, and the number of the spawned thread in the simulation.
    simulated: Option<(Arc<Participant>, usize)>,
}

impl<T> Task<'_, T> {
    /// Waits for the end of the thread. Returns its value.
    ///
    /// # Errors
    /// Fails if the thread panicked.
    pub fn join(mut self) -> thread::Result<T> {
        if let Some((spawner, id)) = &self.simulated {
            spawner.await_end(*id);
        }
        self.thread.take().map_or_else(|| Err(Box::new("joined twice")), ScopedJoinHandle::join)
    }
}

impl<T> Drop for Task<'_, T> {
    /// Removes the spawner from the simulation if it panics. The spawner's scope then waits for this thread, so this
    /// thread must not wait for the spawner.
    fn drop(&mut self) {
        if let Some((spawner, _)) = self.simulated.as_ref().filter(|_| thread::panicking()) {
            spawner.leave();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    #[test]
    fn threads_take_turns_in_the_order_of_time() {
        let (clock, (sender, receiver)) = (Clock::simulated(), channel());
        let start = clock.now();
        let events = thread::scope(|scope| {
            for period in [2, 3] {
                let sender = sender.clone();
                let _ = clock.spawn(scope, move |clock| {
                    for _ in 0..3 {
                        clock.sleep(SECOND * period);
                        sender.send(period).expect("a receiver");
                    }
                });
            }
            drop(sender);
            let mut events = Vec::new();
            while let Ok(period) = clock.receive(&receiver, start + SECOND * 100) {
                events.push(((clock.now() - start).as_secs(), period));
            }
            events
        });
        assert_eq!(events, [(2, 2), (3, 3), (4, 2), (6, 2), (6, 3), (9, 3)]);
    }

    #[test]
    fn waiting_ends_at_a_value_or_at_the_time() {
        let (clock, (sender, receiver)) = (Clock::simulated(), channel());
        let start = clock.now();
        assert_eq!(clock.receive(&receiver, start + SECOND), Err(RecvTimeoutError::Timeout));
        assert_eq!(clock.left(start + SECOND * 3), SECOND * 2);
        thread::scope(|scope| {
            let other = clock.spawn(scope, |clock| {
                clock.sleep(SECOND);
                sender.send(7).expect("a receiver");
                clock.now() - start
            });
            let value = clock.poll(start + SECOND * 9, SECOND * 5, || receiver.try_recv().ok());
            assert_eq!((value, clock.now() - start), (Some(7), SECOND * 2));
            assert_eq!(other.join().expect("no panic"), SECOND * 2);
        });
        clock.sleep_until(start);
        assert_eq!(clock.now() - start, SECOND * 2);
    }

    #[test]
    fn a_thread_that_panics_stops_no_other() {
        let clock = Clock::simulated();
        let panic = thread::scope(|scope| {
            let other = clock.spawn(scope, |clock| {
                clock.sleep(SECOND);
                assert!(clock.left(clock.now()) > SECOND, "on purpose");
            });
            let joined = other.join();
            clock.sleep(SECOND);
            joined
        });
        assert!(panic.is_err());
    }

    #[test]
    fn a_panic_of_the_spawner_stops_no_other() {
        let (clock, (sender, receiver)) = (Clock::simulated(), channel());
        let panic = std::panic::catch_unwind(|| {
            thread::scope(|scope| {
                let _other = clock.spawn(scope, move |clock| {
                    clock.sleep(SECOND);
                    sender.send(clock.left(clock.now())).expect("a receiver");
                });
                assert!(clock.left(clock.now()) > SECOND, "on purpose");
            });
        });
        assert_eq!((panic.is_err(), receiver.recv()), (true, Ok(Duration::ZERO)));
    }

    #[test]
    fn the_real_clock_moves_by_itself() {
        let clock = Clock::real();
        let start = clock.now();
        clock.sleep(Duration::from_nanos(1));
        assert!(clock.now() > start && clock.since_1970() > SECOND);
        let calls = clock.poll(start + SECOND * 600, Duration::ZERO, || (clock.now() > start).then_some(1));
        assert_eq!(calls, Some(1));
        assert_eq!(clock.poll(start, Duration::ZERO, || None::<()>), None);
    }
}
