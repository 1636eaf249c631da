//! Pause, steps and speed of a display. Another thread receives the messages. While the display is paused, a live
//! vehicle continues, and a replay waits.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use ratatui::crossterm::event::{KeyCode, KeyEvent};
use uavspec_check::Observer;
use uavspec_check::timeline::Texts;
use uavspec_flockwave::record::SessionRecord;
use uavspec_model::clock::Clock;
use uavspec_model::{Channel, Message};
use uavspec_rules::definitions::{Definitions, EventMetadata};
use uavspec_rules::px4::Interest;

use super::Vehicle;
use crate::bus;
use crate::watch::fleet::Link;
use crate::watch::screen::{Pages, Step};

/// The maximum number of changes of a live vehicle that are stored while the display is paused.
const MAX_CHANGES: usize = 1_000;

/// The maximum number of notes.
const MAX_NOTES: usize = 4;

/// The maximum time without messages in a replay. Longer gaps are skipped.
const MAX_GAP: Duration = Duration::from_secs(5);

/// The lowest and the highest speed of a replay, as powers of two.
const SPEEDS: (i32, i32) = (-2, 8);

/// The kind of message source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A live vehicle.
    Live,
    /// A capture that is shown at the speed at which it was recorded.
    Replay,
    /// A capture that is read as fast as possible, up to this time after its start.
    State(Duration),
}

/// The state of a display, which two threads share.
pub struct Playback {
    kind: Kind,
    clock: Clock,
    state: Mutex<State>,
    changed: Condvar,
}

/// The state of a display.
#[derive(Default)]
pub struct State {
    /// The number of changes.
    changes: u64,
    vehicle: Vehicle,
    /// The state of the connection.
    pub link: Link,
    /// Problems and remarks.
    pub notes: VecDeque<String>,
    /// The number of lost messages.
    pub lost: u64,
    /// The end of a replay. The error is the reason why nothing more can be read.
    pub end: Option<Result<(), String>>,
    /// True if the display is paused.
    pub is_paused: bool,
    /// True if a replay continues only until the next change.
    is_stepping: bool,
    /// The displayed state of a live vehicle, if the display is paused.
    frozen: Option<Vehicle>,
    /// The states that follow `frozen`.
    pub waiting: VecDeque<Vehicle>,
    /// The speed of a replay, as a power of two.
    speed: i32,
    /// A time of the capture, in µs, and the time at which the replay reached it.
    anchor: Option<(u64, Instant)>,
}

/// The state that a frame shows.
pub struct Shown<'p> {
    /// The state of the display.
    pub state: &'p State,
    /// The vehicle.
    pub vehicle: &'p Vehicle,
    /// The kind of source.
    pub kind: Kind,
    /// The current time in µs, by the clock of the messages.
    pub now: u64,
}

impl Playback {
    /// Creates the display of a source. `clock` belongs to the calling thread.
    pub fn new(kind: Kind, clock: Clock) -> Arc<Self> {
        Arc::new(Self { kind, clock, state: Mutex::default(), changed: Condvar::new() })
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Calls `change` to change the state, and wakes all waiting threads.
    fn change(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.lock();
        state.changes += 1;
        change(&mut state);
        drop(state);
        self.changed.notify_all();
    }

    /// Passes the current state to `show`.
    pub fn show<T>(&self, show: impl FnOnce(&Shown<'_>) -> T) -> T {
        let (state, time) = (self.lock(), self.clock.now());
        let vehicle = state.frozen.as_ref().unwrap_or(&state.vehicle);
        let latest = vehicle.latest.unwrap_or_default();
        let now = match (self.kind, state.anchor) {
            _ if state.is_paused || state.end.is_some() => latest,
            (Kind::Live, _) => (bus::nanoseconds(&self.clock) / 1_000).max(latest),
            (_, Some(anchor)) => state.position(anchor, time).max(latest),
            (_, None) => latest,
        };
        show(&Shown { state: &state, vehicle, kind: self.kind, now })
    }

    /// Handles a key.
    pub fn press(&self, pages: &mut Pages, key: KeyEvent) -> Step {
        match pages.press(key) {
            Ok(step) => return step,
            Err(KeyCode::Char('p' | ' ')) => self.pause(),
            Err(KeyCode::Char('.')) => self.step(),
            Err(KeyCode::Char('+' | '=')) => self.accelerate(1),
            Err(KeyCode::Char('-')) => self.accelerate(-1),
            Err(other) => _ = pages.scroll(other),
        }
        Step::Stay
    }

    /// Pauses, or continues.
    pub(super) fn pause(&self) {
        self.change(|state| {
            state.is_paused = !state.is_paused;
            state.is_stepping = false;
            state.anchor = None;
            state.waiting.clear();
            let is_frozen = state.is_paused && self.kind == Kind::Live;
            state.frozen = is_frozen.then(|| state.vehicle.clone());
        });
    }

    /// Advances to the next change. Pauses the display first if necessary.
    pub(super) fn step(&self) {
        if !self.lock().is_paused {
            self.pause();
        }
        self.change(|state| {
            state.is_stepping = true;
            if let Some(next) = state.waiting.pop_front() {
                state.frozen = Some(next);
            }
        });
    }

    /// Multiplies the speed of a replay by a power of two.
    pub(super) fn accelerate(&self, power: i32) {
        self.change(|state| {
            let now = self.clock.now();
            state.anchor = state.anchor.map(|anchor| (state.position(anchor, now), now));
            state.speed = (state.speed + power).clamp(SPEEDS.0, SPEEDS.1);
        });
    }

    /// Sets the state of the connection.
    pub(super) fn set_link(&self, link: Link) {
        self.change(|state| state.link = link);
    }

    /// Ends a replay. The error is the reason why nothing more can be read.
    pub(crate) fn end(&self, result: Result<(), String>) {
        self.change(|state| state.end = Some(result));
    }

    pub(super) fn note(&self, note: String) {
        self.change(|state| {
            if !state.notes.contains(&note) {
                state.notes.truncate(MAX_NOTES - 1);
                state.notes.push_front(note);
            }
        });
    }

    /// Forgets the channels of a connection that was lost. The known state remains.
    pub(super) fn forget_channels(&self) {
        self.change(|state| state.vehicle.forget_channels());
    }

    /// Counts lost messages.
    pub(super) fn lose(&self, count: u64) {
        self.change(|state| state.lost = state.lost.saturating_add(count));
    }

    /// Waits until a connection exists or has failed, or until a replay ends. Returns the problem, if any.
    pub fn wait_for_start(&self) -> Result<(), String> {
        let is_starting = |state: &mut State| state.link == Link::Connecting && state.end.is_none();
        let state = self.clock.wait_while((&self.state, &self.changed), None, is_starting);
        match (&state.link, &state.end) {
            (_, Some(result)) => result.clone(),
            (Link::Lost { reason, .. }, None) => Err(reason.clone()),
            (Link::Connected | Link::Connecting, None) => Ok(()),
        }
    }

    /// The reason why a replay can't be read.
    pub fn problem(&self) -> Option<String> {
        self.lock().end.clone()?.err()
    }

    /// Waits until a replay reaches a time, according to `clock`. Returns false if the capture isn't shown up to this
    /// time.
    fn reach(&self, time: u64, clock: &Clock) -> bool {
        let mut state = self.lock();
        if let Kind::State(limit) = self.kind {
            return state.vehicle.elapsed(time) <= limit;
        }
        if self.kind == Kind::Live {
            return true;
        }
        while !(state.is_paused && state.is_stepping) {
            let due = state.due(time, clock.now());
            if due.is_some_and(|due| due <= clock.now()) {
                break;
            }
            let changes = state.changes;
            drop(state);
            state = clock.wait_while((&self.state, &self.changed), due, |state| state.changes == changes);
        }
        true
    }
}

impl State {
    /// The speed of a replay.
    pub(crate) fn speed(&self) -> f64 {
        f64::from(self.speed).exp2()
    }

    /// The position of a replay at `now`, in µs. The replay reached `time` at `since`.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)] // a sum saturates
    fn position(&self, (time, since): (u64, Instant), now: Instant) -> u64 {
        let elapsed = now.saturating_duration_since(since);
        time.saturating_add((elapsed.as_micros() as f64 * self.speed()) as u64)
    }

    /// The time at which a replay reaches `time`, a time of the capture. `None` if the replay is paused.
    #[allow(clippy::cast_precision_loss)] // the speed is approximate
    fn due(&mut self, time: u64, now: Instant) -> Option<Instant> {
        if self.is_paused {
            return None;
        }
        let latest = self.vehicle.latest.unwrap_or(time);
        let is_skipped = Duration::from_micros(time.saturating_sub(latest)) > MAX_GAP;
        let start = if is_skipped { time } else { latest };
        let anchor = self.anchor.filter(|_| !is_skipped).unwrap_or((start, now));
        self.anchor = Some(anchor);
        let left = time.saturating_sub(self.position(anchor, now));
        Some(now + Duration::from_secs_f64(left as f64 / 1e6 / self.speed()))
    }
}

/// An observer that passes the records from a checker to a playback.
pub struct Watcher<'w> {
    /// The recording.
    pub playback: &'w Playback,
    /// The texts that describe values.
    pub texts: &'w Texts,
    /// The clock of the thread that reads the records.
    pub clock: Clock,
}

impl Observer for Watcher<'_> {
    fn opened(&mut self, channel: &Channel<'_>, definitions: &Definitions) -> Interest {
        self.playback.lock().vehicle.opened(channel, definitions)
    }

    fn metadata(&mut self, metadata: &Arc<EventMetadata>) {
        self.playback.lock().vehicle.metadata = Arc::clone(metadata);
    }

    fn undecided(&mut self, channel: &Channel<'_>, definitions: &Definitions) {
        self.playback.lock().vehicle.undecided(channel, definitions);
    }

    fn message(
        &mut self,
        channel: &Channel<'_>,
        message: &Message<'_>,
        time: Option<u64>,
        definitions: &Definitions,
    ) {
        if !time.is_none_or(|time| self.playback.reach(time, &self.clock)) {
            return;
        }
        self.playback.change(|state| {
            let is_changed = state.vehicle.message(channel, message, time, (definitions, self.texts));
            if !is_changed {
                return;
            }
            state.is_stepping &= self.playback.kind == Kind::Live;
            if state.frozen.is_some() && state.waiting.len() < MAX_CHANGES {
                state.waiting.push_back(state.vehicle.clone());
            }
        });
    }

    fn session_record(&mut self, _: &SessionRecord<'_>, _: Option<u64>, _: &Definitions) {}
}
