//! The story as text for a terminal.

use uavspec_codegen::emit::docs::markdown::plural;

use super::{
    Entry, STATUSES, duration, entries, flags, is_flag, lane_name, num_quiet, remarks, time, totals,
};
use crate::story::{Label, Story};
use crate::text::{shown, wrapped};

/// The width of the column with times.
const TIMES: usize = 12;

/// The story as text. `language` is the tag of the labels' language.
pub(crate) fn to_text(story: &Story, language: &str) -> String {
    let mut text = format!("{}\n", wrapped(&head(story), 0, 2));
    let all = entries(story);
    if !all.is_empty() {
        text.push('\n');
    }
    for entry in &all {
        let when =
            if entry.change.is_first { "at start".to_owned() } else { time(story, entry.change.time_us) };
        line(&mut text, &when, &change(entry, language));
    }
    text += &summary(story);
    text
}

/// The capture, its start and its duration.
fn head(story: &Story) -> String {
    let start = story.start_utc.as_ref().map(|start| format!(", starts {start}")).unwrap_or_default();
    let (path, definitions) = (shown(&story.capture), shown(&story.definitions));
    format!("{path}: {} long{start}, explained by {definitions}", duration(story.duration_us))
}

fn line(text: &mut String, left: &str, right: &str) {
    *text += &format!("{left:>width$}  {}\n", wrapped(right, TIMES + 2, TIMES + 2), width = TIMES);
}

fn change(entry: &Entry<'_>, language: &str) -> String {
    let Entry { lane, value, .. } = entry;
    let parts = value
        .parts
        .iter()
        .map(|part| format!("{}{}", shown(&part.name), label(part.label.as_ref(), language)));
    let parts: Vec<String> = parts.collect();
    let value = if parts.is_empty() { "none".to_owned() } else { parts.join("; ") };
    if is_flag(lane) {
        return format!("{} {value}{}", lane_name(lane), label(lane.label.as_ref(), language));
    }
    format!("{}: {value}", lane_name(lane))
}

fn label(label: Option<&Label>, language: &str) -> String {
    label.map(|label| format!(" – {}", shown(label.in_language(language)))).unwrap_or_default()
}

fn summary(story: &Story) -> String {
    let mut text = String::new();
    let (listed, more) = totals(story);
    let mut sections = flags(story).peekable();
    if sections.peek().is_some() {
        text += if story.is_session {
            "\nTime for which each error code was set:\n"
        } else {
            "\nTime for which each flag was set:\n"
        };
    }
    for lane in sections {
        let changes = plural(lane.num_changes(), "change");
        line(&mut text, &duration(lane.set_us()), &format!("{}, {changes}", lane_name(lane)));
    }
    let quiet = num_quiet(story);
    if quiet > 0 {
        text += &format!(
            "\n{} never set.\n",
            if quiet == 1 { "1 flag was".to_owned() } else { format!("{quiet} flags were") }
        );
    }
    let more = if more > 0 { format!("; {more} more aren't listed") } else { String::new() };
    text += &format!("\n{}{more}.\n", plural(listed, "change"));
    for (status, heading) in STATUSES {
        let names: Vec<&str> = story.topics(status).collect();
        if !names.is_empty() {
            text += &format!("{}\n", wrapped(&format!("{heading}: {}", names.join(", ")), 0, 2));
        }
    }
    for remark in remarks(story) {
        text += &format!("{}\n", wrapped(&remark, 0, 2));
    }
    text
}
