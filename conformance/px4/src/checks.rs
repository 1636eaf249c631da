//! PX4's health and arming reports: the problems of the vehicle, and the reasons that prevent arming.
//!
//! A report is a sequence of events: a summary of the group `arming_check`, any number of events about problems, and a
//! summary of the group `health`. PX4 may split a report into chunks.

use std::collections::BTreeMap;

use uavspec_dynamic::event::{DecodedEvent, EventValue};
use uavspec_schema::event::{ARMING_CHECK, HEALTH};
use uavspec_schema::{EventEnum, EventKind};

use crate::event::RawEvent;
use crate::limits::{MAX_CHUNKS, MAX_PROBLEMS};

/// The maximum number of problems that PX4 sends in a report. The summaries also contain the bits of dropped problems.
const MAX_SENT: usize = 14;

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

/// The role of an event in a report.
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

/// Combines events into reports.
#[derive(Clone, Debug, Default)]
pub struct Reports {
    /// The open chunk of the current report, with its number.
    open: Option<(u8, Report)>,
    /// The latest complete chunk of each number.
    chunks: BTreeMap<u8, Report>,
    latest: Option<Report>,
    /// The number of the latest event.
    number: Option<u16>,
    /// The number of the chunk that was completed last.
    completed: Option<u8>,
    /// True if the open or latest chunk follows one with the same number.
    is_only_chunk: bool,
    /// True if a report has begun since events were lost.
    has_begun: bool,
    /// True if there was an unknown event since the start of the latest report.
    has_unknown: bool,
}

impl Reports {
    /// The latest complete report.
    pub fn latest(&self) -> Option<&Report> {
        self.latest.as_ref()
    }

    /// The latest complete report, if all of its events are known and PX4 dropped none. Both this report and the
    /// previous one must consist of a single chunk.
    pub fn known(&self) -> Option<&Report> {
        let is_known = !self.has_unknown && self.is_only_chunk && self.chunks.len() == 1;
        self.latest().filter(|report| is_known && report.problems.len() < MAX_SENT)
    }

    /// Follows an event, which is `None` if it is unknown. If events are missing, the report that has begun is
    /// discarded. An event that is recorded twice is skipped.
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
            (ARMING_CHECK, EventKind::Summary) => self.start(event),
            (HEALTH, EventKind::Summary) => self.end(event),
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
        self.is_only_chunk = self.completed == Some(chunk);
        self.open = Some((chunk, report));
        if was_open { Step::Unexpected("the report before it has no end") } else { Step::Open }
    }

    fn problem(&mut self, event: &DecodedEvent<'_>) -> Step {
        let Some((_, report)) = &mut self.open else { return Step::Unexpected("no report has begun") };
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
        let Some((chunk, mut report)) = self.open.take() else {
            return Step::Unexpected("no report has begun");
        };
        let [stated, present, error, warning] = [0, 1, 2, 3].map(|index| bits(event, index));
        let (Some(present), Some(error), Some(warning)) = (present, error, warning) else {
            return Step::Unexpected("the summary has too few arguments");
        };
        if stated != Some(chunk.into()) {
            return Step::Unexpected("it ends a chunk that has not begun");
        }
        for (bit, component) in &mut report.components {
            let [is_present, has_error, has_warning] =
                [present, error, warning].map(|mask| mask & 1 << bit != 0);
            component.is_present = is_present;
            component.has_error |= has_error;
            component.has_warning |= has_warning;
        }
        if self.chunks.len() >= MAX_CHUNKS && !self.chunks.contains_key(&chunk) {
            self.chunks.clear();
        }
        self.completed = Some(chunk);
        self.chunks.insert(chunk, report);
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
            let room = MAX_PROBLEMS.saturating_sub(all.problems.len());
            all.problems.extend(chunk.problems.iter().take(room).cloned());
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

#[cfg(test)]
mod tests {
    use uavspec_dynamic::event::Events;
    use uavspec_runtime::event::MAX_ARGUMENTS_SIZE;

    use super::*;

    /// Two modes, and the components `gps` (bit 1) and `battery` (bit 2).
    const METADATA: &str = r#"{"version": 2, "components": {"0": {"namespace": "common",
        "enums": {
            "mode_t": {"type": "uint8_t", "is_bitfield": true, "entries": {
                "1": {"name": "manual", "description": "Manual"}, "2": {"name": "auto", "description": "Auto"}}},
            "part_t": {"type": "uint64_t", "is_bitfield": true, "entries": {
                "2": {"name": "gps", "description": "GPS"}, "4": {"name": "battery", "description": "Battery"}}}},
        "event_groups": {
            "arming_check": {"events": {
                "1": {"name": "start", "message": "Start", "type": "summary", "arguments": [
                    {"name": "chunk_idx", "type": "uint8_t"}, {"name": "error", "type": "part_t"},
                    {"name": "warning", "type": "part_t"}, {"name": "can_arm", "type": "mode_t"},
                    {"name": "can_run", "type": "mode_t"}]},
                "3": {"name": "no_fix", "message": "No fix", "arguments": [
                    {"name": "modes", "type": "mode_t"}, {"name": "health_component_index", "type": "uint8_t"}]}}},
            "health": {"events": {
                "2": {"name": "end", "message": "End", "type": "summary", "arguments": [
                    {"name": "chunk_idx", "type": "uint8_t"}, {"name": "is_present", "type": "part_t"},
                    {"name": "error", "type": "part_t"}, {"name": "warning", "type": "part_t"}]},
                "4": {"name": "low", "message": "Low", "arguments": [
                    {"name": "modes", "type": "mode_t"}, {"name": "health_component_index", "type": "uint8_t"},
                    {"name": "cell", "type": "uint8_t"}]}}},
            "default": {"events": {"5": {"name": "other", "message": "Other"}}}}}}}"#;

    /// The ids of the events.
    const START: u32 = 1;
    const END: u32 = 2;
    const NO_FIX: u32 = 3;
    const LOW: u32 = 4;
    const OTHER: u32 = 5;

    const MANUAL: i128 = 1;
    const AUTO: i128 = 2;
    const GPS: i128 = 2;
    const BATTERY: i128 = 4;

    /// Follows events, each with its arguments.
    fn follow(reports: &mut Reports, events: &[(u32, &[i128])]) -> Vec<Step> {
        let (known, mistakes) = Events::read(METADATA.into());
        assert_eq!(mistakes, []);
        let step = |(id, arguments): &(u32, &[i128])| {
            let values = arguments.iter().map(|value| EventValue::Integer(*value)).collect();
            let event = DecodedEvent::new(&known, *id, values).expect("an event");
            reports.follow(&numbered(None), Some(&event))
        };
        events.iter().map(step).collect()
    }

    /// An event with a number.
    fn numbered(sequence: Option<u16>) -> RawEvent {
        RawEvent { id: OTHER, sequence, levels: 0, arguments: [0; MAX_ARGUMENTS_SIZE] }
    }

    /// The latest report after events that form reports.
    fn report(events: &[(u32, &[i128])]) -> Report {
        let mut reports = Reports::default();
        let steps = follow(&mut reports, events);
        assert!(!steps.iter().any(|step| matches!(step, Step::Unexpected(_))), "{steps:?}");
        reports.latest().expect("a report").clone()
    }

    /// The modes, each with two flags: the vehicle can arm in it, and it can run.
    fn modes(report: &Report) -> Vec<(&str, bool, bool)> {
        report.modes.values().map(|mode| (&*mode.name, mode.can_arm, mode.can_run)).collect()
    }

    /// The components, each with three flags: it is present, it has an error, and it has a warning.
    fn components(report: &Report) -> Vec<(&str, [bool; 3])> {
        let state = |found: &Component| [found.is_present, found.has_error, found.has_warning];
        report.components.values().map(|found| (&*found.name, state(found))).collect()
    }

    fn ids(report: &Report) -> Vec<u32> {
        report.problems.iter().map(|problem| problem.id).collect()
    }

    #[test]
    fn a_report_has_the_states_of_both_summaries() {
        let report = report(&[
            (START, &[0, GPS, 0, MANUAL, MANUAL | AUTO]),
            (NO_FIX, &[AUTO, 1]),
            (OTHER, &[]),
            (LOW, &[MANUAL | AUTO, 2, 3]),
            (END, &[0, GPS | BATTERY, 0, BATTERY]),
        ]);
        assert_eq!(modes(&report), [("manual", true, true), ("auto", false, true)]);
        let expected = [("gps", [true, true, false]), ("battery", [true, false, true])];
        assert_eq!(components(&report), expected);
        let problems: Vec<_> =
            report.problems.iter().map(|problem| (problem.id, problem.modes, problem.component)).collect();
        assert_eq!(problems, [(NO_FIX, 2, 1), (LOW, 3, 2)]);
    }

    #[test]
    fn chunks_are_merged() {
        let first: [(u32, &[i128]); 3] =
            [(START, &[0, 0, 0, MANUAL | AUTO, MANUAL]), (NO_FIX, &[AUTO, 1]), (END, &[0, GPS, GPS, 0])];
        let second: [(u32, &[i128]); 3] = [
            (START, &[1, 0, 0, AUTO, MANUAL | AUTO]),
            (LOW, &[MANUAL, 2, 3]),
            (END, &[1, BATTERY, 0, BATTERY]),
        ];
        let both = report(&[first, second].concat());
        // A mode is allowed only if both chunks allow it. A component combines the states of all chunks.
        assert_eq!(modes(&both), [("manual", false, true), ("auto", true, false)]);
        assert_eq!(components(&both), [("gps", [true, true, false]), ("battery", [true, false, true])]);
        assert_eq!(ids(&both), [NO_FIX, LOW]);
        // The next report of a chunk replaces the previous one.
        let fixed: [(u32, &[i128]); 2] =
            [(START, &[0, 0, 0, MANUAL | AUTO, MANUAL | AUTO]), (END, &[0, GPS, 0, 0])];
        let next = report(&[&first[..], &second, &fixed].concat());
        assert_eq!(modes(&next), [("manual", false, true), ("auto", true, true)]);
        assert_eq!(components(&next)[0], ("gps", [true, false, false]));
        assert_eq!(ids(&next), [LOW]);
    }

    #[test]
    fn events_in_another_order_make_no_report() {
        let start: (u32, &[i128]) = (START, &[0, 0, 0, 0, 0]);
        let end: (u32, &[i128]) = (END, &[0, 0, 0, 0]);
        for (events, expected) in [
            // The log may start within a report.
            (vec![end], Step::Unrelated),
            (vec![(NO_FIX, &[AUTO, 1][..])], Step::Unrelated),
            (vec![start, start], Step::Unexpected("the report before it has no end")),
            (vec![start, (END, &[1, 0, 0, 0])], Step::Unexpected("it ends a chunk that has not begun")),
            (vec![start, (START, &[0, 0])], Step::Unexpected("the summary has too few arguments")),
            (vec![start, (START, &[300, 0, 0, 0, 0])], Step::Unexpected("the chunk has no valid number")),
            (vec![start, (NO_FIX, &[AUTO])], Step::Unexpected("the event has no modes or no component")),
            (vec![(OTHER, &[])], Step::Unrelated),
        ] {
            let mut reports = Reports::default();
            assert_eq!(follow(&mut reports, &events).last(), Some(&expected), "{events:?}");
            assert_eq!(reports.latest(), None, "{events:?}");
        }
    }

    #[test]
    fn an_incomplete_chunk_does_not_count() {
        let mut reports = Reports::default();
        follow(&mut reports, &[(START, &[0, 0, 0, 0, 0]), (NO_FIX, &[AUTO, 1])]);
        // Event 8 is missing.
        for number in [7, 9] {
            assert_eq!(reports.follow(&numbered(Some(number)), None), Step::Unrelated);
        }
        let chunk = [(START, &[1, 0, 0, MANUAL, MANUAL][..]), (END, &[1, 0, 0, 0])];
        assert_eq!(follow(&mut reports, &chunk), [Step::Open, Step::Complete]);
        let report = reports.latest().expect("a report");
        assert_eq!((modes(report)[0], report.problems.len()), (("manual", true, true), 0));
        // A report that restarts has only the problems after its start.
        follow(&mut reports, &[chunk[0], (NO_FIX, &[AUTO, 1]), chunk[0], (LOW, &[AUTO, 2, 3]), chunk[1]]);
        assert_eq!(ids(reports.latest().expect("a report")), [LOW]);
    }

    #[test]
    fn the_difference_of_reports_is_what_appeared_and_what_went() {
        let with = |problems: &[(u32, &[i128])]| {
            let start = [(START, &[0, 0, 0, 0, 0][..])];
            report(&[&start[..], problems, &[(END, &[0, 0, 0, 0])]].concat())
        };
        let before = with(&[(NO_FIX, &[AUTO, 1]), (LOW, &[AUTO, 2, 3])]);
        let after = with(&[(LOW, &[AUTO, 2, 3]), (LOW, &[AUTO, 2, 4])]);
        let without = |problems: &Report, known: &Report| {
            problems.problems.iter().filter(|problem| !known.problems.contains(problem)).count()
        };
        assert_eq!((without(&after, &before), without(&before, &after)), (1, 1));
        let not_a_number = |bits: u32| Problem {
            values: vec![EventValue::Float(f32::from_bits(bits))],
            ..before.problems[0].clone()
        };
        assert_eq!(not_a_number(0x7fc0_0000), not_a_number(0x7fc0_0000));
        assert_ne!(not_a_number(0x7fc0_0000), not_a_number(0x7fc0_0001));
    }

    #[test]
    fn the_size_of_a_report_is_limited() {
        let mut reports = Reports::default();
        for chunk in 0..40 {
            follow(&mut reports, &[(START, &[chunk, 0, 0, 0, 0])]);
            follow(&mut reports, &[(NO_FIX, &[AUTO, 1][..]); 300]);
            follow(&mut reports, &[(END, &[chunk, 0, 0, 0])]);
            assert!(ids(reports.latest().expect("a report")).len() <= MAX_PROBLEMS);
        }
    }
}
