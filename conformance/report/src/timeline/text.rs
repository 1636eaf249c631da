//! The timeline as text for a terminal.

use uavspec_check::timeline::{Label, Timeline};
use uavspec_model::text::{plural, shown, thousands, wrapped};

use super::{
    Entry, STATUSES, duration, entries, flag_noun, flags, is_flag, lane_name, num_quiet, remarks, time,
    totals,
};

/// The width of the column with times.
const TIMES: usize = 12;

/// The timeline as text. `language` is the tag of the labels' language.
pub fn to_text(timeline: &Timeline, language: &str) -> String {
    let sections = [
        vec![paragraph(&head(timeline))],
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
    let (path, definitions) = (shown(&timeline.capture), shown(&timeline.definitions));
    format!("{path}: {} long{start}, explained by {definitions}", duration(timeline.duration_us))
}

fn paragraph(text: &str) -> String {
    wrapped(text, 0, 2) + "\n"
}

/// A line with a time.
fn line(time: &str, text: &str) -> String {
    format!("{time:>TIMES$}  {}\n", wrapped(text, TIMES + 2, TIMES + 2))
}

fn changes(timeline: &Timeline, language: &str) -> Vec<String> {
    let lines = entries(timeline).into_iter().map(|entry| {
        let at_start = entry.change.is_first.then(|| "at start".to_owned());
        let when = at_start.unwrap_or_else(|| time(timeline, entry.change.time_us));
        line(&when, &change(&entry, language))
    });
    lines.collect()
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
