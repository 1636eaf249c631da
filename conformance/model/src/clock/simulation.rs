//! Simulated time. The threads take turns, so their order doesn't depend on the system.

use std::collections::BTreeMap;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::LONG;

/// The time since 1970 at which simulated time starts.
const START: Duration = Duration::from_secs(1_790_000_000);

/// A thread that takes part in a simulation. It leaves the simulation when dropped.
#[derive(Debug)]
pub(super) struct Participant {
    simulation: Arc<Simulation>,
    id: usize,
}

#[derive(Debug)]
struct Simulation {
    start: Instant,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug)]
struct State {
    now: Instant,
    /// The running thread. `None` if all threads have left.
    turn: Option<usize>,
    waiting: BTreeMap<usize, Waiting>,
    next_id: usize,
}

#[derive(Debug)]
struct Waiting {
    until: Instant,
    /// True if the thread has found nothing to do since another thread last did something.
    is_idle: bool,
}

impl State {
    /// Gives the turn to a thread that may have something to do, or otherwise to the thread whose wait ends first.
    fn pass(&mut self) {
        let busy = self.waiting.iter().find(|(_, waiting)| !waiting.is_idle);
        let next = busy.or_else(|| self.waiting.iter().min_by_key(|(id, waiting)| (waiting.until, **id)));
        self.turn = next.map(|(id, _)| *id);
        if let Some(waiting) = self.turn.and_then(|id| self.waiting.remove(&id))
            && waiting.is_idle
        {
            self.now = self.now.max(waiting.until);
        }
    }
}

impl Participant {
    /// Creates a simulation, and returns its first thread, which has the turn.
    #[allow(clippy::disallowed_methods, reason = "only the differences of times count")]
    pub(super) fn first() -> Self {
        let start = Instant::now();
        let state = State { now: start, turn: Some(0), waiting: BTreeMap::new(), next_id: 1 };
        let simulation = Simulation { start, state: Mutex::new(state), changed: Condvar::new() };
        Self { simulation: Arc::new(simulation), id: 0 }
    }

    /// Adds another thread to the simulation. It waits for its turn.
    pub(super) fn another(&self) -> Self {
        let mut state = self.state();
        let id = state.next_id;
        state.next_id += 1;
        let until = state.now;
        state.waiting.insert(id, Waiting { until, is_idle: false });
        Self { simulation: Arc::clone(&self.simulation), id }
    }

    pub(super) fn id(&self) -> usize {
        self.id
    }

    pub(super) fn now(&self) -> Instant {
        self.state().now
    }

    pub(super) fn since_1970(&self) -> Duration {
        START + self.now().saturating_duration_since(self.simulation.start)
    }

    /// Waits until a function returns a value, or until the time. The function is called whenever another thread may have
    /// changed something.
    pub(super) fn wait<T>(&self, until: Instant, mut check: impl FnMut() -> Option<T>) -> Option<T> {
        // This thread may have done something since it last waited.
        self.state().waiting.values_mut().for_each(|waiting| waiting.is_idle = false);
        loop {
            let value = check();
            if value.is_some() || self.now() >= until {
                return value;
            }
            self.give_turn(Some(Waiting { until, is_idle: true }));
            self.await_turn();
        }
    }

    /// Blocks until it is this thread's turn.
    pub(super) fn await_turn(&self) {
        let state = self.simulation.changed.wait_while(self.state(), |state| state.turn != Some(self.id));
        drop(state);
    }

    /// Waits until another thread has left the simulation.
    pub(super) fn await_end(&self, id: usize) {
        let is_over = || (!self.state().waiting.contains_key(&id)).then_some(());
        while self.wait(self.now() + LONG, is_over).is_none() {}
    }

    /// Removes this thread from the simulation, so that the other threads continue without it.
    pub(super) fn leave(&self) {
        let mut state = self.state();
        state.waiting.remove(&self.id);
        // The last actions of this thread may have given the others something to do.
        state.waiting.values_mut().for_each(|waiting| waiting.is_idle = false);
        drop(state);
        self.give_turn(None);
    }

    fn give_turn(&self, waiting: Option<Waiting>) {
        let mut state = self.state();
        state.waiting.extend(waiting.map(|waiting| (self.id, waiting)));
        if state.turn == Some(self.id) {
            state.pass();
        }
        drop(state);
        self.simulation.changed.notify_all();
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.simulation.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Participant {
    fn drop(&mut self) {
        self.leave();
    }
}
