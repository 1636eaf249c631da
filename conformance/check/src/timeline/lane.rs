//! Lanes: the values of one field, error code or state over time. The size of all lanes is limited.

use std::collections::HashMap;

use serde::Serialize;
use uavspec_model::text::start_of;

use super::label::Label;
use crate::limits::{MAX_ALL_CHANGES, MAX_CHANGES, MAX_LANE_NAME, MAX_LANES, MAX_VALUES};

/// A lane of the timeline.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Lane {
    /// The topic, or the type of the messages.
    pub topic: String,
    /// The instance, component, UAV or connection, if there can be several.
    pub subject: Option<String>,
    /// The name of the field, or the error code.
    pub name: String,
    /// The label.
    pub label: Option<Label>,
    /// The heading of the field's group in its definition.
    pub group: Option<Label>,
    /// The kind.
    pub kind: LaneKind,
    /// The number of messages that contained a value of this lane.
    pub messages: u64,
    /// The distinct values. In a lane of kind `flag`, the first value means that the flag is cleared, the second value
    /// that it is set.
    pub values: Vec<Value>,
    /// The changes, in chronological order.
    pub changes: Vec<Change>,
    /// The number of further changes that aren't listed.
    pub more_changes: u64,
    /// The current value and the time at which it began.
    #[serde(skip)]
    pub(super) current: Option<(usize, u64)>,
    /// The position in the timeline: lanes are sorted by it.
    #[serde(skip)]
    pub(super) rank: usize,
}

/// The kind of a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum LaneKind {
    /// A flag is set or cleared.
    Flag,
    /// A state has one of several values.
    State,
    /// Each message is an event.
    Event,
    /// A mode or a component in health and arming reports. A first value without a problem isn't news.
    Check,
}

/// A value of a lane.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Value {
    /// The parts of the value. An empty list means none.
    pub parts: Vec<Part>,
    /// The severity.
    pub severity: Severity,
    /// The total time for which the lane had this value, in µs.
    pub duration_us: u64,
}

/// A part of a value, such as a constant, a reason or a field.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, schemars::JsonSchema)]
pub struct Part {
    /// The name, without the prefix of the enum.
    pub name: String,
    /// The label.
    pub label: Option<Label>,
}

/// The severity of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// No problem.
    Normal,
    /// Information.
    Info,
    /// A warning.
    Warning,
    /// An error.
    Error,
}

/// A change of a lane's value, or an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Change {
    /// The time in µs since the start of the capture; negative for messages that are older.
    pub time_us: i64,
    /// The index of the new value in `values`.
    pub value: usize,
    /// True if this is the first value of the lane. The lane may have had this value before.
    pub is_first: bool,
}

impl Part {
    /// A part; a long name is shortened.
    pub(super) fn new(name: impl Into<String>, label: Option<Label>) -> Self {
        Self { name: shortened(&name.into()), label }
    }

    /// True if a text is the name or the English label, ignoring case.
    pub fn is_named(&self, text: &str) -> bool {
        let is_same = |known: &str| known.eq_ignore_ascii_case(text);
        is_same(&self.name) || self.label.as_ref().is_some_and(|label| is_same(&label.text))
    }
}

impl Value {
    pub(super) const fn new(parts: Vec<Part>, severity: Severity) -> Self {
        Self { parts, severity, duration_us: 0 }
    }

    fn is_same(&self, other: &Self) -> bool {
        self.severity == other.severity && self.parts == other.parts
    }
}

impl Lane {
    /// A lane without values.
    pub(super) fn new(topic: &str, name: impl Into<String>, kind: LaneKind) -> Self {
        let flag = |name, severity| Value::new(vec![Part::new(name, None)], severity);
        let values = match kind {
            LaneKind::Flag => vec![flag("cleared", Severity::Normal), flag("set", Severity::Error)],
            LaneKind::State | LaneKind::Event | LaneKind::Check => Vec::new(),
        };
        Self {
            topic: topic.to_owned(),
            subject: None,
            name: shortened(&name.into()),
            label: None,
            group: None,
            kind,
            messages: 0,
            values,
            changes: Vec::new(),
            more_changes: 0,
            current: None,
            rank: 0,
        }
    }

    /// The total time for which a flag was set, in µs.
    pub fn set_us(&self) -> u64 {
        self.values.get(1).filter(|_| self.kind == LaneKind::Flag).map_or(0, |set| set.duration_us)
    }

    /// The changes that a report lists. A flag that is cleared at the start isn't listed.
    pub fn listed(&self) -> impl Iterator<Item = &Change> {
        self.changes.iter().filter(|change| !self.is_quiet(change))
    }

    /// The number of listed changes, plus the number of changes that aren't stored.
    pub fn num_changes(&self) -> u64 {
        self.listed().count() as u64 + self.more_changes
    }

    fn is_quiet(&self, change: &Change) -> bool {
        let has_problem =
            self.values.get(change.value).is_some_and(|value| value.severity != Severity::Normal);
        change.is_first && matches!(self.kind, LaneKind::Flag | LaneKind::Check) && !has_problem
    }

    fn value(&mut self, value: Value) -> usize {
        if let Some(known) = self.values.iter().position(|known| known.is_same(&value)) {
            return known;
        }
        if self.values.len() < MAX_VALUES {
            self.values.push(value);
        } else if self.values.len() == MAX_VALUES {
            self.values.push(Value::new(vec![Part::new("another value", None)], Severity::Normal));
        }
        self.values.len() - 1
    }

    /// Ends the current value.
    fn close(&mut self, time: u64) {
        if let Some((value, since)) = self.current.take() {
            let held = &mut self.values[value].duration_us;
            *held = held.saturating_add(time.saturating_sub(since));
        }
    }
}

/// All lanes.
#[derive(Default)]
pub(super) struct Lanes {
    pub(super) all: Vec<Lane>,
    /// The index of each lane, by topic, subject and name.
    by_key: HashMap<(String, String, String), usize>,
    num_changes: usize,
    /// The number of times a lane couldn't be created, because there were too many.
    pub(super) more: u64,
}

impl Lanes {
    /// Returns the index of a lane. If the lane doesn't exist, creates it with `make`, unless there are too many lanes.
    pub(super) fn get(
        &mut self,
        (topic, subject, name): (&str, &str, &str),
        make: impl FnOnce() -> Lane,
    ) -> Option<usize> {
        let key = (topic.to_owned(), subject.to_owned(), name.to_owned());
        if let Some(known) = self.by_key.get(&key) {
            return Some(*known);
        }
        if self.all.len() >= MAX_LANES {
            self.more += 1;
            return None;
        }
        let subject = Some(shortened(subject)).filter(|subject| !subject.is_empty());
        self.all.push(Lane { subject, ..make() });
        self.by_key.insert(key, self.all.len() - 1);
        Some(self.all.len() - 1)
    }

    /// Changes the subject of a lane, unless the new subject already has a lane.
    pub(super) fn rename(&mut self, (topic, subject, name): (&str, &str, &str), renamed: &str) {
        let key = |subject: &str| (topic.to_owned(), subject.to_owned(), name.to_owned());
        if self.by_key.contains_key(&key(renamed)) {
            return;
        }
        if let Some(lane) = self.by_key.remove(&key(subject)) {
            self.all[lane].subject = Some(shortened(renamed));
            self.by_key.insert(key(renamed), lane);
        }
    }

    /// Ends the current value of a lane, if the lane exists. The lane may get further values later.
    pub(super) fn end(&mut self, (topic, subject, name): (&str, &str, &str), time: u64) {
        let key = (topic.to_owned(), subject.to_owned(), name.to_owned());
        if let Some(lane) = self.by_key.get(&key) {
            self.all[*lane].close(time);
        }
    }

    /// Counts a message with the value that the lane already has.
    pub(super) fn count(&mut self, lane: usize) {
        self.all[lane].messages += 1;
    }

    /// Records the value of a flag or a state.
    pub(super) fn set(&mut self, lane: usize, time: u64, value: Value) {
        let value = self.all[lane].value(value);
        self.set_index(lane, time, value);
    }

    /// Records the value of a flag.
    pub(super) fn set_flag(&mut self, lane: usize, time: u64, is_set: bool) {
        self.set_index(lane, time, is_set.into());
    }

    /// Records that a flag was cleared when its subject first appeared.
    pub(super) fn start_cleared(&mut self, lane: usize, time: u64) {
        self.all[lane].current.get_or_insert((0, time));
    }

    fn set_index(&mut self, lane: usize, time: u64, value: usize) {
        self.count(lane);
        let current = self.all[lane].current;
        if current.is_none_or(|(known, _)| known != value) {
            self.all[lane].close(time);
            self.all[lane].current = Some((value, time));
            // A lane that has ended may have earlier values.
            let is_first = current.is_none() && self.all[lane].messages == 1;
            self.push(lane, time, value, is_first);
        }
    }

    /// Records an event.
    pub(super) fn event(&mut self, lane: usize, time: u64, value: Value) {
        self.count(lane);
        if self.all[lane].changes.len() >= MAX_CHANGES {
            self.all[lane].more_changes += 1;
            return;
        }
        let value = self.all[lane].value(value);
        self.push(lane, time, value, false);
    }

    fn push(&mut self, lane: usize, time: u64, value: usize, is_first: bool) {
        let lane = &mut self.all[lane];
        if lane.changes.len() < MAX_CHANGES && self.num_changes < MAX_ALL_CHANGES {
            self.num_changes += 1;
            let time_us = i64::try_from(time).unwrap_or(i64::MAX);
            lane.changes.push(Change { time_us, value, is_first });
        } else {
            lane.more_changes += 1;
        }
    }

    /// Returns the lanes in the order of the timeline, with times relative to `start`.
    pub(super) fn finish(self, start: u64, end: u64) -> Vec<Lane> {
        let mut lanes = self.all;
        let start = i64::try_from(start).unwrap_or(i64::MAX);
        for lane in &mut lanes {
            lane.close(end);
            lane.changes.iter_mut().for_each(|change| change.time_us -= start);
        }
        // Lanes with the same rank and subject stay in the order of appearance.
        lanes.sort_by(|left, right| (left.rank, &left.subject).cmp(&(right.rank, &right.subject)));
        lanes
    }
}

/// A name, shortened if it is too long.
fn shortened(name: &str) -> String {
    start_of(name, MAX_LANE_NAME).into_owned()
}
