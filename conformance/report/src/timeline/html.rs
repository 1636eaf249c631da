//! The timeline as an HTML page with a picture: lanes over time.
//!
//! The page requires no network. Its only script zooms the picture and switches the language. The content security
//! policy permits only this script, by its hash. Without the script, the page shows the whole flight.

mod picture;
#[cfg(test)]
mod tests;

use maud::{DOCTYPE, Markup, PreEscaped, html};
use uavspec_check::timeline::{Label, Lane, Timeline, Value};
use uavspec_model::text::{plural, shown, thousands};
use uavspec_schema::terminal::guarded;

use super::overview::sentences;
use super::{
    STATUSES, duration, entries, flag_noun, flags, is_at_start, is_flag, lane_name, num_quiet, remarks,
    sources, time, totals,
};
use crate::html::{page_foot, page_head};
use crate::outcome::capitalized;

/// The style sheet of the picture. It is added after the style sheet of all reports.
const STYLE: &str = include_str!("html/timeline.css");

/// The script, which is embedded in the page.
const SCRIPT: &str = include_str!("html/timeline.js");

/// The SHA-256 hash of the script.
const SCRIPT_HASH: &str = "sha256-NJQLFLfSyIAzWC+NOyvU/9UnsV5YO+uz7VblwJiprmY=";

/// The language of the definitions.
const ENGLISH: (&str, &str) = ("en", "English");

/// The timeline as a page. `language` is the tag of the language in which labels are initially shown.
pub fn to_html(timeline: &Timeline, language: &str, command: &str) -> String {
    let policy = format!(
        "default-src 'none'; style-src 'unsafe-inline'; script-src '{SCRIPT_HASH}'; base-uri 'none'; \
         form-action 'none'"
    );
    let title = format!("Timeline of {}", timeline.capture);
    let page = html! {
        (DOCTYPE)
        html lang="en" data-language=(language) {
            (page_head(&title, &timeline.uavspec, &policy, &styles(timeline)))
            body.timeline {
                main {
                    (head(timeline))
                    (controls(timeline, language))
                    (picture::picture(timeline))
                    (changes(timeline))
                    (flag_table(timeline))
                    (topics(timeline))
                }
                (page_foot(command, &timeline.uavspec))
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    guarded(&page.into_string()).into_owned() + "\n"
}

/// The style sheet. For each language, it contains a rule that hides the labels in other languages.
fn styles(timeline: &Timeline) -> String {
    let hide = |tag: &str| {
        format!("[data-language=\"{tag}\"] [data-label]:not([data-label=\"{tag}\"]) {{ display: none; }}\n")
    };
    let hidden: String = languages(timeline).map(|(tag, _)| hide(tag)).collect();
    STYLE.to_owned() + &hidden
}

/// The tag and the name of each language, starting with English.
fn languages(timeline: &Timeline) -> impl Iterator<Item = (&str, &str)> {
    let others = timeline.languages.iter().map(|(tag, name)| (tag.as_str(), name.as_str()));
    std::iter::once(ENGLISH).chain(others)
}

fn head(timeline: &Timeline) -> Markup {
    let (listed, more) = totals(timeline);
    html! {
        header.head {
            p.kicker { "Timeline of a flight" }
            h1 { (shown(&timeline.capture)) }
            p.lede {
                (duration(timeline.duration_us)) " long"
                @if let Some(start) = &timeline.start_utc { ", starts " (shown(start)) }
                ", explained by " span.path { (sources(timeline)) }
            }
            (overview(timeline))
            @let remarks = remarks(timeline);
            @if !remarks.is_empty() { ul.remarks { @for remark in &remarks { li { (remark) } } } }
            dl.figures {
                div { dt { "changes" @if more > 0 { ", and " (thousands(more)) " that aren't listed" } } dd { (thousands(listed)) } }
                div { dt { (flag_noun(timeline)) " set for some time" } dd { (flags(timeline).count()) } }
                // An error code that was never set has no lane.
                @if !timeline.is_session { div { dt { "flags never set" } dd { (num_quiet(timeline)) } } }
            }
        }
    }
}

/// The summary for a pilot, in all languages.
fn overview(timeline: &Timeline) -> Markup {
    html! {
        @if let Some(overview) = &timeline.overview {
            ul.overview {
                @for (tag, _) in languages(timeline) {
                    @for sentence in sentences(overview, tag) { li data-label=(tag) { (sentence) } }
                }
            }
        }
    }
}

fn controls(timeline: &Timeline, language: &str) -> Markup {
    html! {
        div.controls id="controls" hidden {
            div.zoom role="group" aria-label="Zoom" {
                button type="button" id="in" { "+" span.name { " Zoom in" } }
                button type="button" id="out" { "−" span.name { " Zoom out" } }
                button type="button" id="whole" { "0" span.name { " Whole flight" } }
            }
            @if !timeline.languages.is_empty() {
                label { "Labels " select id="language" {
                    @for (tag, name) in languages(timeline) {
                        option value=(tag) lang=(tag) selected[tag == language] { (shown(name)) }
                    }
                } }
            }
            p.aside { "Keys: + and − zoom, arrows pan, 0 shows the whole flight. Mouse: drag to pan, Ctrl and wheel to zoom." }
        }
    }
}

/// A label in all languages. If there are no translations, only in English.
fn label(label: &Label, timeline: &Timeline) -> Markup {
    html! {
        @if label.translations.is_empty() {
            span { (shown(&label.text)) }
        } @else {
            @for (tag, _) in languages(timeline) {
                @let is_translated = label.translations.contains_key(tag);
                span data-label=(tag) lang=(if is_translated { tag } else { ENGLISH.0 }) {
                    (shown(label.in_language(tag)))
                }
            }
        }
    }
}

/// A value with the labels of its parts.
fn value(lane: &Lane, value: &Value, timeline: &Timeline) -> Markup {
    html! {
        @if value.parts.is_empty() { "none" }
        @for (at, part) in value.parts.iter().enumerate() {
            @if at > 0 { "; " }
            @if is_flag(lane) { (shown(&part.name)) } @else { code { (shown(&part.name)) } }
            @if let Some(text) = &part.label { " – " (label(text, timeline)) }
        }
    }
}

fn changes(timeline: &Timeline) -> Markup {
    let all = entries(timeline);
    html! {
        section aria-labelledby="changes" {
            h2 id="changes" { "Changes" }
            @if all.is_empty() {
                p { "There are no changes." }
            } @else {
                table.changes {
                    thead { tr { th scope="col" { "Time" } th scope="col" { "Lane" } th scope="col" { "Change" } } }
                    tbody {
                        @for entry in &all {
                            tr {
                                td.when { @if is_at_start(entry) { "at start" } @else { (time(timeline, entry.change.time_us)) } }
                                td {
                                    code { (lane_name(entry.lane)) }
                                    @if let Some(text) = &entry.lane.label { span.aside { (label(text, timeline)) } }
                                }
                                td { (value(entry.lane, entry.value, timeline)) }
                            }
                        }
                    }
                }
            }
            @for lane in timeline.lanes.iter().filter(|lane| lane.more_changes > 0) {
                p.more { code { (lane_name(lane)) } ": " (plural(lane.more_changes, "more change")) " aren't listed." }
            }
        }
    }
}

fn flag_table(timeline: &Timeline) -> Markup {
    html! {
        @if flags(timeline).next().is_some() {
            section aria-labelledby="flags" {
                h2 id="flags" { (capitalized(flag_noun(timeline))) }
                table.counts {
                    thead { tr {
                        th scope="col" { "Name" } th.number scope="col" { "Time set" } th.number scope="col" { "Changes" }
                    } }
                    tbody { @for lane in flags(timeline) { tr {
                        th scope="row" {
                            code { (lane_name(lane)) }
                            @if let Some(text) = &lane.label { span.aside { (label(text, timeline)) } }
                        }
                        td.number { (duration(lane.set_us())) }
                        td.number { (thousands(lane.num_changes())) }
                    } } }
                }
            }
        }
    }
}

fn topics(timeline: &Timeline) -> Markup {
    html! {
        section aria-labelledby="topics" {
            h2 id="topics" { (if timeline.is_session { "Message types" } else { "Topics" }) }
            dl.evidence {
                @for (status, heading) in STATUSES {
                    @let names: Vec<String> = timeline.topics(status).map(shown).collect();
                    @if !names.is_empty() {
                        dt { (heading) }
                        dd { @for (at, name) in names.iter().enumerate() { @if at > 0 { ", " } code { (name) } } }
                    }
                }
            }
        }
    }
}
