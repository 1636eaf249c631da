//! The timeline of a flight in each format.
//!
//! All texts from captures are escaped when a report is rendered.

mod html;
mod overview;
#[cfg(test)]
mod schema;
mod text;

use uavspec_check::ReleaseMatch;
use uavspec_check::timeline::{Change, Lane, LaneKind, Timeline, TopicStatus, Value};
use uavspec_model::text::{plural, shown};
use uavspec_schema::json_text;

pub use self::html::to_html;
pub use self::overview::WhyNotArm;
pub use self::text::to_text;

/// The texts for the statuses of topics, in the order in which reports list them.
const STATUSES: [(TopicStatus, &str); 4] = [
    (TopicStatus::Explained, "in the timeline"),
    (TopicStatus::Differs, "in the timeline, but the format differs from the definition"),
    (TopicStatus::Undefined, "in the capture, but without a definition"),
    (TopicStatus::Absent, "not in the capture"),
];

/// The timeline in JSON.
pub fn to_json(timeline: &Timeline) -> String {
    json_text::pretty(timeline)
}

/// A change of a lane.
#[derive(Clone, Copy)]
struct Entry<'s> {
    lane: &'s Lane,
    change: &'s Change,
    value: &'s Value,
}

/// All listed changes in chronological order, starting with the first values of all lanes.
fn entries(timeline: &Timeline) -> Vec<Entry<'_>> {
    let mut entries: Vec<Entry<'_>> = Vec::new();
    for lane in &timeline.lanes {
        let listed = lane.listed().filter_map(|change| Some((change, lane.values.get(change.value)?)));
        entries.extend(listed.map(|(change, value)| Entry { lane, change, value }));
    }
    // The sort is stable, so changes at the same time are in the order of their lanes.
    entries.sort_by_key(|entry| {
        let is_first = is_at_start(entry);
        (!is_first, if is_first { 0 } else { entry.change.time_us })
    });
    entries
}

/// True if the first value of a lane may be older than the capture. The first value in a report isn't, because the time
/// of the report is known.
fn is_at_start(entry: &Entry<'_>) -> bool {
    entry.change.is_first && entry.lane.kind != LaneKind::Check
}

/// The name of a lane, with its topic and its subject.
fn lane_name(lane: &Lane) -> String {
    let name =
        if lane.name == lane.topic { lane.name.clone() } else { format!("{}.{}", lane.topic, lane.name) };
    match &lane.subject {
        Some(subject) => shown(&format!("{name} ({subject})")),
        None => shown(&name),
    }
}

/// True if the lane shows a flag.
fn is_flag(lane: &Lane) -> bool {
    lane.kind == LaneKind::Flag
}

/// The time of a change, relative to the start. For a session, the time in UTC.
fn time(timeline: &Timeline, time_us: i64) -> String {
    let utc = timeline.utc(time_us).filter(|_| timeline.is_session);
    // `2026-11-23T10:20:30.123Z`
    utc.and_then(|utc| utc.get(11..23).map(str::to_owned)).unwrap_or_else(|| clock(time_us))
}

/// A time as minutes, seconds and milliseconds.
fn clock(time_us: i64) -> String {
    let millis = time_us.unsigned_abs() / 1_000;
    let sign = if time_us < 0 && millis > 0 { "-" } else { "" };
    format!("{sign}{:02}:{:02}.{:03}", millis / 60_000, millis / 1_000 % 60, millis % 1_000)
}

/// A duration as minutes, seconds and milliseconds.
fn duration(micros: u64) -> String {
    clock(i64::try_from(micros).unwrap_or(i64::MAX))
}

/// The plural noun for the lanes that contain flags.
const fn flag_noun(timeline: &Timeline) -> &'static str {
    if timeline.is_session { "error codes" } else { "flags" }
}

/// The flags that were set for some time, or that changed.
fn flags(timeline: &Timeline) -> impl Iterator<Item = &Lane> {
    timeline.lanes.iter().filter(|lane| is_flag(lane) && lane.num_changes() > 0)
}

/// The number of flags that were never set.
fn num_quiet(timeline: &Timeline) -> usize {
    timeline.lanes.iter().filter(|lane| is_flag(lane) && lane.num_changes() == 0).count()
}

/// The definitions and the event metadata that explain the capture.
fn sources(timeline: &Timeline) -> String {
    let definitions = shown(&timeline.definitions);
    match &timeline.event_metadata {
        Some(events) => format!("{definitions} and {}", shown(events)),
        None => definitions,
    }
}

/// The number of changes that are listed, and the number of changes that aren't.
fn totals(timeline: &Timeline) -> (u64, u64) {
    let more: u64 = timeline.lanes.iter().map(|lane| lane.more_changes).sum();
    (timeline.lanes.iter().map(|lane| lane.listed().count() as u64).sum(), more)
}

/// Remarks about parts that are missing in the capture or the timeline.
fn remarks(timeline: &Timeline) -> Vec<String> {
    let mut remarks: Vec<String> =
        timeline.corruption.iter().map(|text| format!("not readable: {}", shown(text))).collect();
    remarks.extend(timeline.releases.iter().filter_map(ReleaseMatch::problem));
    if timeline.unreadable_messages > 0 {
        let count = plural(timeline.unreadable_messages, "message");
        remarks.push(format!("{count} can't be read or violate a rule"));
    }
    if timeline.values_without_lane > 0 {
        let count = plural(timeline.values_without_lane, "value");
        remarks.push(format!("{count} left out: the timeline has too many lanes"));
    }
    remarks
}
