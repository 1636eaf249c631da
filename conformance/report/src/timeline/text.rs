//! The timeline as text for a terminal.

use std::collections::HashMap;

use uavspec_check::timeline::{Label, LaneKind, Part, Timeline};
use uavspec_model::text::{plural, shown, thousands, wrapped};

use super::overview::sentences;
use super::{
    Entry, STATUSES, duration, entries, flag_noun, flags, is_at_start, is_flag, lane_name, num_quiet,
    remarks, sources, time, totals,
};

/// The width of the column with times.
const TIMES: usize = 12;

/// The timeline as text. `language` is the tag of the language of the labels.
pub fn to_text(timeline: &Timeline, language: &str) -> String {
    let sections = [
        vec![paragraph(&head(timeline))],
        overview(timeline, language),
        changes(timeline, language),
        durations(timeline),
        summary(timeline),
    ];
    let sections = sections.iter().filter(|lines| !lines.is_empty()).map(|lines| lines.concat());
    sections.collect::<Vec<_>>().join("\n")
}

/// The capture, its start and its duration.
fn head(timeline: &Timeline) -> String {
    let start =
        timeline.start_utc.as_ref().map(|start| format!(", starts {}", shown(start))).unwrap_or_default();
    let path = shown(&timeline.capture);
    format!("{path}: {} long{start}, explained by {}", duration(timeline.duration_us), sources(timeline))
}

/// The summary for a pilot.
fn overview(timeline: &Timeline, language: &str) -> Vec<String> {
    let sentences = timeline.overview.iter().flat_map(|overview| sentences(overview, language));
    sentences.map(|sentence| paragraph(&sentence)).collect()
}

fn paragraph(text: &str) -> String {
    wrapped(text, 0, 2) + "\n"
}

/// A line with a time.
fn line(time: &str, text: &str) -> String {
    format!("{time:>TIMES$}  {}\n", wrapped(text, TIMES + 2, TIMES + 2))
}

fn changes(timeline: &Timeline, language: &str) -> Vec<String> {
    let entries = entries(timeline);
    let mut alike: HashMap<_, Vec<&Entry<'_>>> = HashMap::new();
    for (key, entry) in entries.iter().filter_map(|entry| Some((key(entry)?, entry))) {
        alike.entry(key).or_default().push(entry);
    }
    let lines = entries.iter().filter_map(|entry| {
        let at_start = is_at_start(entry).then(|| "at start".to_owned());
        let when = at_start.unwrap_or_else(|| time(timeline, entry.change.time_us));
        let text = match key(entry) {
            Some(key) => checks(&alike.remove(&key)?, language),
            None => change(entry, language),
        };
        Some(line(&when, &text))
    });
    lines.collect()
}

/// A key that is equal for modes or components in a report that change to the same state at the same time. They share a
/// line.
fn key<'e>(entry: &Entry<'e>) -> Option<(i64, Option<&'e Label>, &'e [Part])> {
    let Entry { lane, change, value } = *entry;
    let is_check = lane.kind == LaneKind::Check;
    is_check.then_some((change.time_us, lane.group.as_ref(), value.parts.as_slice()))
}

/// The line for modes or components that have the same state.
fn checks(entries: &[&Entry<'_>], language: &str) -> String {
    let name = |entry: &&Entry<'_>| {
        let label = entry.lane.label.as_ref();
        shown(label.map_or(&entry.lane.name, |label| label.in_language(language)))
    };
    let names: Vec<String> = entries.iter().map(name).collect();
    let state = entries.first().and_then(|entry| entry.value.parts.first()).map(|part| shown(&part.name));
    let topic = entries.first().map(|entry| shown(&entry.lane.topic)).unwrap_or_default();
    format!("{topic}: {}: {}", state.unwrap_or_default(), names.join(", "))
}

fn change(entry: &Entry<'_>, language: &str) -> String {
    let Entry { lane, value, .. } = entry;
    let label = |label: Option<&Label>| {
        label.map(|label| format!(" – {}", shown(label.in_language(language)))).unwrap_or_default()
    };
    let parts = value.parts.iter().map(|part| format!("{}{}", shown(&part.name), label(part.label.as_ref())));
    let parts: Vec<String> = parts.collect();
    let value = if parts.is_empty() { "none".to_owned() } else { parts.join("; ") };
    if is_flag(lane) {
        return format!("{} {value}{}", lane_name(lane), label(lane.label.as_ref()));
    }
    format!("{}: {value}", lane_name(lane))
}

/// The time for which each flag was set.
fn durations(timeline: &Timeline) -> Vec<String> {
    let heading = format!("Time for which {} were set:\n", flag_noun(timeline));
    let lines = flags(timeline).map(|lane| {
        let changes = plural(lane.num_changes(), "change");
        line(&duration(lane.set_us()), &format!("{}, {changes}", lane_name(lane)))
    });
    let lines: Vec<String> = lines.collect();
    if lines.is_empty() { lines } else { [vec![heading], lines].concat() }
}

fn summary(timeline: &Timeline) -> Vec<String> {
    let (listed, more) = totals(timeline);
    let more = if more > 0 { format!("; {} more aren't listed", thousands(more)) } else { String::new() };
    let quiet = match num_quiet(timeline) {
        0 => String::new(),
        1 => " 1 flag was never set.".to_owned(),
        count => format!(" {count} flags were never set."),
    };
    let mut lines = vec![format!("{}{more}.{quiet}\n", plural(listed, "change"))];
    for (status, heading) in STATUSES {
        let names: Vec<String> = timeline.topics(status).map(shown).collect();
        if !names.is_empty() {
            lines.push(paragraph(&format!("{heading}: {}", names.join(", "))));
        }
    }
    lines.extend(remarks(timeline).iter().map(|remark| paragraph(remark)));
    lines
}
