//! PX4 events, and the health and arming reports that consist of events.

use std::collections::BTreeMap;
use std::sync::Arc;

use uavspec_dynamic::DynamicView;
use uavspec_dynamic::event::DecodedEvent;
use uavspec_px4::checks::{Component, ModeGroup, Problem, Reports, Step};
use uavspec_px4::event::{EventMetadata, RawEvent};
use uavspec_runtime::event::LogLevel;

use super::flights::{Flights, refused_modes};
use super::{RANKS, rank_of};
use crate::limits::MAX_EVENTS;
use crate::timeline::context::Context;
use crate::timeline::label::{Label, Texts};
use crate::timeline::lane::{Lane, LaneKind, Lanes, Part, Severity, Value};

pub(super) const TOPIC: &str = "event";

/// The name of the lane that shows the lines of text in a log.
const TEXTS: &str = "logging";

/// The end of a line of text that repeats an event. PX4 doesn't record all of these events.
const REPEATED: &str = "\t";

/// The maximum time between a line of text and the event that it repeats, in µs.
const NEAR: u64 = 2_000_000;

/// The groups of the lanes that show health and arming reports: the modes, the components and the problems.
const MODES: &str = "Arming";
const COMPONENTS: &str = "Health";
const PROBLEMS: &str = "Problems";

/// An event that PX4 sent.
#[derive(Clone, Debug)]
pub struct SentEvent {
    /// The time since the start, in µs. Negative if the event is older than the start.
    pub time_us: i64,
    /// The instance in a log, or the topic, if there are several.
    pub subject: Option<Arc<str>>,
    /// The event.
    pub event: RawEvent,
}

/// Follows the events of all channels.
#[derive(Default)]
pub(in crate::timeline) struct Events {
    /// The first events, each with its time and its subject.
    listed: Vec<(u64, Arc<str>, RawEvent)>,
    /// The reports of each subject.
    followed: BTreeMap<Arc<str>, Followed>,
}

/// The reports of a subject.
#[derive(Default)]
struct Followed {
    reports: Reports,
    /// The problems in the latest report, each with its lane.
    problems: Vec<(Problem, usize)>,
}

impl Events {
    /// Records a message of the topic `event`.
    pub(super) fn event(
        &mut self,
        values: DynamicView<'_>,
        subject: &Arc<str>,
        flights: &mut Flights,
        context: &mut Context<'_>,
    ) {
        let lane = context.lane((TOPIC, subject, TOPIC), rank_of(TOPIC), LaneKind::Event);
        let Some(raw) = RawEvent::read(values) else { return };
        if self.listed.len() < MAX_EVENTS {
            self.listed.push((context.time, Arc::clone(subject), raw));
        }
        let decoded = raw.decode(context.metadata.events()).ok();
        let followed = self.followed.entry(Arc::clone(subject)).or_default();
        let step = followed.reports.follow(&raw, decoded.as_ref());
        if step == Step::Complete {
            followed.report(subject, context);
            flights.reporter(subject);
            if let Some(report) = followed.reports.latest() {
                let refused = refused_modes(report, context.metadata, context.texts);
                flights.report(report, refused, context.time);
            }
        }
        if let Some(event) = &decoded {
            flights.event(event, context.time);
        }
        // The lanes of the report show the content of this event.
        if step != Step::Unrelated || decoded.is_some() && raw.level() == Some(LogLevel::Protocol) {
            return;
        }
        let Some(lane) = lane else { return };
        let value = Value::new(vec![part(&raw, context.metadata, context.texts)], severity(raw.level()));
        context.lanes.event(lane, context.time, value);
    }

    /// Returns the events, with times since the start. `lanes` are the timeline's lanes.
    pub(in crate::timeline) fn finish(self, start: u64, lanes: &[Lane]) -> Vec<SentEvent> {
        let is_named = lanes.iter().any(|lane| lane.topic == TOPIC && lane.subject.is_some());
        let event = |(time, subject, event): (u64, Arc<str>, RawEvent)| SentEvent {
            time_us: time.cast_signed().saturating_sub_unsigned(start),
            subject: is_named.then_some(subject),
            event,
        };
        self.listed.into_iter().map(event).collect()
    }
}

impl Followed {
    /// Records a complete report.
    fn report(&mut self, subject: &str, context: &mut Context<'_>) {
        let Some(report) = self.reports.latest() else { return };
        for (rank, mode) in report.modes.values().enumerate() {
            let names = [subject, MODES, &mode.name, &mode.description];
            set(context, names, 1 + rank, state_of_mode(mode));
        }
        // Bit 0 means that a problem concerns no component.
        for (bit, component) in report.components.iter().filter(|(bit, _)| **bit != 0) {
            let rank = 100 + *bit as usize;
            let names = [subject, COMPONENTS, &component.name, &component.description];
            set(context, names, rank, state_of_component(component));
        }
        let before = std::mem::take(&mut self.problems);
        for problem in &report.problems {
            if self.problems.iter().any(|(known, _)| known == problem) {
                continue;
            }
            let lane = before.iter().find(|(known, _)| known == problem).map(|(_, lane)| *lane);
            if let Some(lane) = lane.or_else(|| lane_of(problem, subject, context)) {
                context.lanes.set_flag(lane, context.time, true);
                self.problems.push((problem.clone(), lane));
            }
        }
        for (_, lane) in before {
            if self.problems.iter().all(|(_, current)| *current != lane) {
                context.lanes.set_flag(lane, context.time, false);
            }
        }
    }
}

/// Records a line of text in a log, without its colour codes.
pub(in crate::timeline) fn logged_text(level: u8, text: &str, time: u64, lanes: &mut Lanes) {
    // Tabs are control characters too.
    let tab = text.strip_suffix(REPEATED).map_or("", |_| REPEATED);
    let text = strip_ansi_escapes::strip_str(text) + tab;
    let rank = rank_of(TOPIC) + RANKS / 2;
    let lane = lanes.get((TEXTS, "", TEXTS), || Lane { rank, ..Lane::new(TEXTS, TEXTS, LaneKind::Event) });
    if let Some(lane) = lane {
        // Syslog and events use the same levels.
        let severity = severity(LogLevel::external(level));
        lanes.event(lane, time, Value::new(vec![Part::new(text, None)], severity));
    }
}

/// Removes the lines of text that an event repeats.
pub(in crate::timeline) fn remove_repeated_texts(lanes: &mut Vec<Lane>) {
    let mut messages: BTreeMap<String, Vec<i64>> = BTreeMap::new();
    for lane in lanes.iter().filter(|lane| lane.topic == TOPIC && lane.kind == LaneKind::Event) {
        for change in &lane.changes {
            let part = lane.values.get(change.value).and_then(|value| value.parts.first());
            let message = part.map(|part| part.label.as_ref().map_or(&*part.name, |label| &label.text));
            messages.entry(words(message.unwrap_or_default())).or_default().push(change.time_us);
        }
    }
    let Some(texts) = lanes.iter_mut().find(|lane| lane.topic == TEXTS) else { return };
    let is_repeated = |text: &str, time: i64| {
        let times = messages.get(&words(text)).filter(|_| text.ends_with(REPEATED));
        times.is_some_and(|times| times.iter().any(|other| other.abs_diff(time) <= NEAR))
    };
    let values = &texts.values;
    let text =
        |value: usize| values.get(value).and_then(|value| value.parts.first()).map_or("", |part| &*part.name);
    texts.changes.retain(|change| !is_repeated(text(change.value), change.time_us));
    for part in texts.values.iter_mut().flat_map(|value| &mut value.parts) {
        part.name.truncate(part.name.trim_end_matches(REPEATED).len());
    }
    lanes.retain(|lane| lane.topic != TEXTS || !lane.changes.is_empty());
}

/// The words of a message, without the name of the module that precedes it. Texts and events differ in punctuation and
/// case.
fn words(text: &str) -> String {
    let text = text.strip_prefix('[').and_then(|text| text.split_once(']')).map_or(text, |(_, text)| text);
    let words = text.split(|character: char| !character.is_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect::<Vec<_>>().join(" ")
}

/// Sets the value of a mode or a component.
fn set(
    context: &mut Context<'_>,
    [subject, group, name, description]: [&str; 4],
    rank: usize,
    (state, severity): (&str, Severity),
) {
    let name = format!("{}.{name}", group.to_lowercase());
    let lane = context.lanes.get((TOPIC, subject, &name), || Lane {
        label: Label::plain(description),
        group: Label::plain(group),
        rank: rank_of(TOPIC) + rank,
        ..Lane::new(TOPIC, &*name, LaneKind::Check)
    });
    if let Some(lane) = lane {
        context.lanes.set(lane, context.time, Value::new(vec![Part::new(state, None)], severity));
    }
}

fn state_of_mode(mode: &ModeGroup) -> (&'static str, Severity) {
    match (mode.can_arm, mode.can_run) {
        (true, true) => ("can arm", Severity::Normal),
        (false, false) => ("can't arm", Severity::Error),
        (false, true) => ("can't arm, but can switch to", Severity::Error),
        (true, false) => ("can arm, but can't switch to", Severity::Warning),
    }
}

fn state_of_component(component: &Component) -> (&'static str, Severity) {
    match component {
        Component { has_error: true, .. } => ("error", Severity::Error),
        Component { has_warning: true, .. } => ("warning", Severity::Warning),
        Component { is_present: true, .. } => ("present", Severity::Normal),
        _ => ("not present", Severity::Normal),
    }
}

/// Returns the index of the lane for a problem, and creates the lane if necessary.
fn lane_of(problem: &Problem, subject: &str, context: &mut Context<'_>) -> Option<usize> {
    let Part { name, label } = part_of(problem, context.metadata, context.texts)?;
    // If the same event is about another part, such as another battery, it is another problem. Measured values vary.
    let parts: Vec<i128> = problem.values.iter().filter_map(|value| value.integer()).collect();
    let key = format!("{name} {parts:?}");
    let lane = context.lanes.get((TOPIC, subject, &key), || Lane {
        label,
        group: Label::plain(PROBLEMS),
        rank: rank_of(TOPIC) + 200,
        ..Lane::new(TOPIC, name, LaneKind::Flag)
    })?;
    // The problem began when it was first reported.
    context.lanes.start_cleared(lane, context.time);
    Some(lane)
}

/// The name and the message of a problem.
pub(super) fn part_of(problem: &Problem, metadata: &EventMetadata, texts: &Texts) -> Option<Part> {
    let decoded = DecodedEvent::new(metadata.events(), problem.id, problem.values.clone())?;
    Some(Part::new(full_name(&decoded), texts.event(&decoded, metadata)))
}

/// The name of an event, with its namespace.
pub fn full_name(event: &DecodedEvent<'_>) -> String {
    format!("{}::{}", event.component.namespace, event.event.name)
}

/// Describes an event by its name and its message. If the event is unknown, uses its id and its bytes instead.
pub(super) fn part(raw: &RawEvent, metadata: &EventMetadata, texts: &Texts) -> Part {
    if let Ok(event) = raw.decode(metadata.events()) {
        return Part::new(full_name(&event), texts.event(&event, metadata));
    }
    Part::new(raw.undecoded(), None)
}

fn severity(level: Option<LogLevel>) -> Severity {
    match level {
        Some(level) if level <= LogLevel::Error => Severity::Error,
        Some(LogLevel::Warning) => Severity::Warning,
        _ => Severity::Info,
    }
}
