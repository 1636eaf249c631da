//! Pause, steps and speed. Another thread receives the messages: a live vehicle continues while the display is paused,
//! and a replay waits.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use uavspec_check::Observer;
use uavspec_check::timeline::Texts;
use uavspec_flockwave::record::SessionRecord;
use uavspec_model::clock::Clock;
use uavspec_model::{Channel, Message};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::px4::Interest;

use super::Vehicle;
use crate::bus;
use crate::watch::fleet::Link;

/// The maximum number of changes of a live vehicle that are stored while the display is paused.
const MAX_CHANGES: usize = 1_000;

/// The maximum number of notes.
const MAX_NOTES: usize = 4;

/// The maximum time without messages. A replay skips longer gaps.
const MAX_GAP: Duration = Duration::from_secs(5);

/// The lowest and the highest speed of a replay.
const SPEEDS: (f64, f64) = (0.25, 256.0);

/// The kind of source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A live vehicle.
    Live,
    /// A capture that is shown at the speed at which it was recorded.
    Replay,
    /// A capture that is read as fast as possible, up to this time after its start.
    State(Duration),
}

/// The state of a vehicle that two threads share.
pub struct Playback {
    kind: Kind,
    clock: Clock,
    inner: Mutex<Inner>,
    changed: Condvar,
}

struct Inner {
    /// The number of changes.
    changes: u64,
    vehicle: Vehicle,
    link: Link,
    notes: VecDeque<String>,
    /// The number of lost messages.
    lost: u64,
    /// The end of a replay. An error is the reason why nothing more can be read.
    end: Option<Result<(), String>>,
    is_paused: bool,
    /// True if a replay continues until the next change.
    is_stepping: bool,
    /// The state of a paused live vehicle, and the following states.
    frozen: Option<Vehicle>,
    waiting: VecDeque<Vehicle>,
    speed: f64,
    /// A time of the capture in µs, and the time at which the replay reached it.
    anchor: Option<(u64, Instant)>,
}

/// The state for a frame.
pub struct Shown<'p> {
    /// The vehicle.
    pub vehicle: &'p Vehicle,
    /// The state of the connection.
    pub link: &'p Link,
    /// The kind of source.
    pub kind: Kind,
    /// Problems and remarks.
    pub notes: &'p VecDeque<String>,
    /// The number of lost messages.
    pub lost: u64,
    /// True if the replay has ended.
    pub is_ended: bool,
    /// True if the display is paused.
    pub is_paused: bool,
    /// The number of later changes, if the display of a live vehicle is paused.
    pub waiting: usize,
    /// The speed of a replay.
    pub speed: f64,
    /// The current time in µs, by the clock of the messages.
    pub now: u64,
}

impl Playback {
    /// The display of a source. `clock` is that of the calling thread.
    pub fn new(kind: Kind, clock: Clock) -> Arc<Self> {
        let inner = Inner {
            changes: 0,
            vehicle: Vehicle::default(),
            link: Link::Connecting,
            notes: VecDeque::new(),
            lost: 0,
            end: None,
            is_paused: false,
            is_stepping: false,
            frozen: None,
            waiting: VecDeque::new(),
            speed: 1.0,
            anchor: None,
        };
        Arc::new(Self { kind, clock, inner: Mutex::new(inner), changed: Condvar::new() })
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the state, and wakes all waiting threads.
    fn change(&self, change: impl FnOnce(&mut Inner)) {
        let mut inner = self.lock();
        inner.changes += 1;
        change(&mut inner);
        drop(inner);
        self.changed.notify_all();
    }

    /// Passes the current state to a function.
    pub fn show<T>(&self, show: impl FnOnce(&Shown<'_>) -> T) -> T {
        let (inner, time) = (self.lock(), self.clock.now());
        let vehicle = inner.frozen.as_ref().unwrap_or(&inner.vehicle);
        let latest = vehicle.latest.unwrap_or_default();
        let now = match (self.kind, inner.anchor) {
            _ if inner.is_paused || inner.end.is_some() => latest,
            (Kind::Live, _) => (bus::nanoseconds(&self.clock) / 1_000).max(latest),
            (_, Some(anchor)) => inner.position(anchor, time).max(latest),
            (_, None) => latest,
        };
        show(&Shown {
            vehicle,
            link: &inner.link,
            kind: self.kind,
            notes: &inner.notes,
            lost: inner.lost,
            is_ended: inner.end.is_some(),
            is_paused: inner.is_paused,
            waiting: inner.waiting.len(),
            speed: inner.speed,
            now,
        })
    }

    /// Pauses, or continues.
    pub fn pause(&self) {
        self.change(|inner| {
            inner.is_paused = !inner.is_paused;
            inner.is_stepping = false;
            inner.anchor = None;
            inner.waiting.clear();
            let is_frozen = inner.is_paused && self.kind == Kind::Live;
            inner.frozen = is_frozen.then(|| inner.vehicle.clone());
        });
    }

    /// Shows the next change. Pauses first if necessary.
    pub fn step(&self) {
        if !self.lock().is_paused {
            self.pause();
        }
        self.change(|inner| {
            inner.is_stepping = true;
            if let Some(next) = inner.waiting.pop_front() {
                inner.frozen = Some(next);
            }
        });
    }

    /// Doubles or halves the speed of a replay.
    pub fn accelerate(&self, is_faster: bool) {
        self.change(|inner| {
            let speed = if is_faster { inner.speed * 2.0 } else { inner.speed / 2.0 };
            let now = self.clock.now();
            inner.anchor = inner.anchor.map(|anchor| (inner.position(anchor, now), now));
            inner.speed = speed.clamp(SPEEDS.0, SPEEDS.1);
        });
    }

    /// Sets the state of the connection.
    pub(super) fn set_link(&self, link: Link) {
        self.change(|inner| inner.link = link);
    }

    /// Ends a replay. An error is the reason why nothing more can be read.
    pub(crate) fn end(&self, result: Result<(), String>) {
        self.change(|inner| inner.end = Some(result));
    }

    pub(super) fn note(&self, note: String) {
        self.change(|inner| {
            if !inner.notes.contains(&note) {
                inner.notes.truncate(MAX_NOTES - 1);
                inner.notes.push_front(note);
            }
        });
    }

    /// Forgets the channels of a connection that was lost.
    pub(super) fn forget_channels(&self) {
        self.change(|inner| inner.vehicle.forget_channels());
    }

    /// Counts lost messages.
    pub(super) fn lose(&self, count: u64) {
        self.change(|inner| inner.lost = inner.lost.saturating_add(count));
    }

    /// Waits until a connection exists or can't be made, or until a replay ends. Returns the problem.
    pub fn wait_for_start(&self) -> Result<(), String> {
        let inner = self.wait(|inner| inner.link == Link::Connecting && inner.end.is_none());
        match (&inner.link, &inner.end) {
            (_, Some(result)) => result.clone(),
            (Link::Lost { reason, .. }, None) => Err(reason.clone()),
            (Link::Connected | Link::Connecting, None) => Ok(()),
        }
    }

    /// Waits until a replay ends. Returns the problem.
    pub fn wait_for_end(&self) -> Result<(), String> {
        self.wait(|inner| inner.end.is_none()).end.clone().unwrap_or(Ok(()))
    }

    /// Waits while a condition holds.
    fn wait(&self, condition: impl Fn(&Inner) -> bool) -> MutexGuard<'_, Inner> {
        self.clock.wait_while((&self.inner, &self.changed), None, |inner| condition(inner))
    }

    /// The reason why a replay can't be read.
    pub fn problem(&self) -> Option<String> {
        self.lock().end.clone()?.err()
    }

    /// Waits by a clock until a replay reaches a time. Returns false if the time is outside the replay.
    fn reach(&self, time: u64, clock: &Clock) -> bool {
        let mut inner = self.lock();
        if let Kind::State(limit) = self.kind {
            return inner.vehicle.elapsed(time) <= limit;
        }
        if self.kind == Kind::Live {
            return true;
        }
        while !(inner.is_paused && inner.is_stepping) {
            let due = inner.due(time, clock.now());
            if due.is_some_and(|due| due <= clock.now()) {
                break;
            }
            let changes = inner.changes;
            drop(inner);
            inner = clock.wait_while((&self.inner, &self.changed), due, |inner| inner.changes == changes);
        }
        true
    }
}

impl Inner {
    /// The position of a replay, in µs.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)] // a sum saturates
    fn position(&self, (time, since): (u64, Instant), now: Instant) -> u64 {
        let elapsed = now.saturating_duration_since(since);
        time.saturating_add((elapsed.as_micros() as f64 * self.speed) as u64)
    }

    /// The time at which a replay reaches a time of the capture. `None` if it is paused.
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
        Some(now + Duration::from_secs_f64(left as f64 / 1e6 / self.speed))
    }
}

/// Passes the records of a checker to a playback.
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
        self.playback.change(|inner| {
            let is_changed = inner.vehicle.message(channel, message, time, (definitions, self.texts));
            if !is_changed {
                return;
            }
            inner.is_stepping &= self.playback.kind == Kind::Live;
            if inner.frozen.is_some() && inner.waiting.len() < MAX_CHANGES {
                inner.waiting.push_back(inner.vehicle.clone());
            }
        });
    }

    fn session_record(&mut self, _: &SessionRecord<'_>, _: Option<u64>, _: &Definitions) {}
}
