//! Health and arming reports: what prevents arming, and what is wrong with the vehicle, as PX4 reports it in events.
//!
//! A report is a sequence of events: a summary of the group `arming_check`, any number of events about problems, and a
//! summary of the group `health`. PX4 may split a report into chunks.

use std::collections::BTreeMap;

use uavspec_dynamic::event::{DecodedEvent, EventValue};
use uavspec_schema::{EventEnum, EventKind};

use crate::event::RawEvent;
use crate::limits::{MAX_CHUNKS, MAX_PROBLEMS};

/// A report. The modes, components and problems of all chunks are combined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// The groups of navigation modes, by their bit.
    pub modes: BTreeMap<u32, ModeGroup>,
    /// The components of the vehicle, by their bit.
    pub components: BTreeMap<u32, Component>,
    /// The problems, in the order of the events.
    pub problems: Vec<Problem>,
}

/// The state of a group of navigation modes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModeGroup {
    /// The name in the metadata.
    pub name: String,
    /// The description in the metadata.
    pub description: String,
    /// True if the vehicle can arm in these modes.
    pub can_arm: bool,
    /// True if the vehicle can switch to these modes.
    pub can_run: bool,
}

/// The state of a component of the vehicle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Component {
    /// The name in the metadata.
    pub name: String,
    /// The description in the metadata.
    pub description: String,
    /// True if the component is part of the vehicle.
    pub is_present: bool,
    /// True if the component has an error.
    pub has_error: bool,
    /// True if the component has a warning.
    pub has_warning: bool,
}

/// A problem, from an event.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The id of the event.
    pub id: u32,
    /// The values of its arguments.
    pub values: Vec<EventValue>,
    /// The groups of modes that the problem affects, as a mask.
    pub modes: u64,
    /// The bit of the component; 0 if there is none.
    pub component: u32,
}

/// Two problems are the same if the ids and all bits of the arguments are the same.
impl PartialEq for Problem {
    fn eq(&self, other: &Self) -> bool {
        let is_same = |(left, right): (&EventValue, &EventValue)| match (left, right) {
            (EventValue::Float(left), EventValue::Float(right)) => left.to_bits() == right.to_bits(),
            (left, right) => left == right,
        };
        self.id == other.id
            && self.values.len() == other.values.len()
            && self.values.iter().zip(&other.values).all(is_same)
    }
}

/// The part of an event in a report.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// The event isn't part of a report.
    Unrelated,
    /// The event starts or continues a report.
    Open,
    /// The event completes a report, which [`Reports::latest`] returns.
    Complete,
    /// The event isn't the next part of a report.
    Unexpected(&'static str),
}

/// Combines events to reports.
#[derive(Clone, Debug, Default)]
pub struct Reports {
    /// The chunk of the report that has begun.
    open: Option<u8>,
    /// The latest report of each chunk.
    chunks: BTreeMap<u8, Report>,
    latest: Option<Report>,
    /// The number of the latest event.
    number: Option<u16>,
    /// True if a report has begun since events were lost.
    has_begun: bool,
    /// True if an event is unknown since the latest report has begun.
    has_unknown: bool,
}

impl Reports {
    /// The latest complete report.
    pub fn latest(&self) -> Option<&Report> {
        self.latest.as_ref()
    }

    /// The latest complete report, if all of its events are known, and no part of it is from an earlier report.
    pub fn known(&self) -> Option<&Report> {
        self.latest().filter(|_| !self.has_unknown && self.chunks.len() == 1)
    }

    /// Follows an event, which is `None` if it is unknown. Where events are missing, the report that has begun is
    /// forgotten. An event that is recorded twice is skipped.
    pub fn follow(&mut self, raw: &RawEvent, event: Option<&DecodedEvent<'_>>) -> Step {
        let before = std::mem::replace(&mut self.number, raw.sequence);
        match before.zip(raw.sequence).map(|(before, number)| number.wrapping_sub(before)) {
            Some(0) => return Step::Unrelated,
            Some(1) | None => {}
            Some(_) => (self.open, self.has_begun) = (None, false),
        }
        let Some(event) = event else {
            self.has_unknown = true;
            return Step::Unrelated;
        };
        let step = match (event.event.group.as_str(), event.event.kind) {
            ("arming_check", EventKind::Summary) => self.start(event),
            ("health", EventKind::Summary) => self.end(event),
            _ if event.event.is_check() => self.problem(event),
            _ => Step::Unrelated,
        };
        match step {
            // The capture may start within a report.
            Step::Unexpected(_) if !self.has_begun => Step::Unrelated,
            step => {
                self.has_begun |= step == Step::Open;
                step
            }
        }
    }

    fn start(&mut self, event: &DecodedEvent<'_>) -> Step {
        let was_open = self.open.take().is_some();
        self.has_unknown = false;
        let [chunk, error, warning, can_arm, can_run] = [0, 1, 2, 3, 4].map(|index| bits(event, index));
        let (Some(chunk), Some(error), Some(warning), Some(can_arm), Some(can_run)) =
            (chunk, error, warning, can_arm, can_run)
        else {
            return Step::Unexpected("the summary has too few arguments");
        };
        let (Some(components), Some(modes)) = (event.enumeration(1), event.enumeration(3)) else {
            return Step::Unexpected("the summary has no enums of components and modes");
        };
        let modes = entries(modes).map(|(bit, name, description)| {
            let is_set = |mask: u64| mask & 1 << bit != 0;
            (bit, ModeGroup { name, description, can_arm: is_set(can_arm), can_run: is_set(can_run) })
        });
        let components = entries(components).map(|(bit, name, description)| {
            let [has_error, has_warning] = [error, warning].map(|mask| mask & 1 << bit != 0);
            (bit, Component { name, description, is_present: false, has_error, has_warning })
        });
        let report =
            Report { modes: modes.collect(), components: components.collect(), problems: Vec::new() };
        let Ok(chunk) = u8::try_from(chunk) else { return Step::Unexpected("the chunk has no valid number") };
        if self.chunks.len() >= MAX_CHUNKS && !self.chunks.contains_key(&chunk) {
            self.chunks.clear();
        }
        self.chunks.insert(chunk, report);
        self.open = Some(chunk);
        if was_open { Step::Unexpected("the report before it has no end") } else { Step::Open }
    }

    fn problem(&mut self, event: &DecodedEvent<'_>) -> Step {
        let Some(report) = self.open.and_then(|chunk| self.chunks.get_mut(&chunk)) else {
            return Step::Unexpected("no report has begun");
        };
        let (Some(modes), Some(component)) = (bits(event, 0), bits(event, 1)) else {
            return Step::Unexpected("the event has no modes or no component");
        };
        if report.problems.len() < MAX_PROBLEMS {
            let component = u32::try_from(component).unwrap_or(0);
            let (id, values) = (event.event.id, event.values.clone());
            report.problems.push(Problem { id, values, modes, component });
        }
        Step::Open
    }

    fn end(&mut self, event: &DecodedEvent<'_>) -> Step {
        let Some(chunk) = self.open.take() else { return Step::Unexpected("no report has begun") };
        let [stated, present, error, warning] = [0, 1, 2, 3].map(|index| bits(event, index));
        let (Some(present), Some(error), Some(warning)) = (present, error, warning) else {
            return Step::Unexpected("the summary has too few arguments");
        };
        if stated != Some(chunk.into()) {
            return Step::Unexpected("it ends a chunk that has not begun");
        }
        if let Some(report) = self.chunks.get_mut(&chunk) {
            for (bit, component) in &mut report.components {
                let [is_present, has_error, has_warning] =
                    [present, error, warning].map(|mask| mask & 1 << bit != 0);
                component.is_present = is_present;
                component.has_error |= has_error;
                component.has_warning |= has_warning;
            }
        }
        self.latest = self.combined();
        Step::Complete
    }

    fn combined(&self) -> Option<Report> {
        let (first, others) = (self.chunks.values().next()?, self.chunks.values().skip(1));
        let mut all = first.clone();
        for chunk in others {
            for (bit, mode) in &chunk.modes {
                let known = all.modes.entry(*bit).or_insert_with(|| mode.clone());
                known.can_arm &= mode.can_arm;
                known.can_run &= mode.can_run;
            }
            for (bit, component) in &chunk.components {
                let known = all.components.entry(*bit).or_insert_with(|| component.clone());
                known.is_present |= component.is_present;
                known.has_error |= component.has_error;
                known.has_warning |= component.has_warning;
            }
            all.problems.extend_from_slice(&chunk.problems);
        }
        Some(all)
    }
}

/// The argument at an index as a mask or a number. `None` if there is no such integer.
fn bits(event: &DecodedEvent<'_>, index: usize) -> Option<u64> {
    // A negative number has the bits of its type, which is at most 64 bits wide.
    event.values.get(index)?.integer().map(|value| u64::try_from(value & i128::from(u64::MAX)).unwrap_or(0))
}

/// The bits of a bit field, each with its name and description.
fn entries(enumeration: &EventEnum) -> impl Iterator<Item = (u32, String, String)> {
    let bits = enumeration.entries.iter().filter(|entry| entry.value > 0 && entry.value.count_ones() == 1);
    bits.map(|entry| (entry.value.trailing_zeros(), entry.name.clone(), entry.description.clone()))
}
