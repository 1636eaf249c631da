//! The picture: a track for each lane, above each other, with a common axis.
//!
//! Positions are percentages of the track's width, so the picture is zoomed by making the tracks wider.

use maud::{Markup, html};
use uavspec_check::story::{Change, Lane, LaneKind, Severity, Story, Value};
use uavspec_model::text::shown;

use super::label;
use crate::story::{clock, is_flag, lane_name, time};

/// The height of a track, in pixels.
const HEIGHT: u32 = 22;

/// The number of colours for values without a problem.
const COLOURS: usize = 6;

/// The distances between the ticks of the axis, in seconds.
const STEPS: [u64; 18] =
    [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1_800, 3_600, 7_200, 14_400, 28_800, 86_400, 864_000];

/// The maximum number of intervals between ticks at the start.
const MAX_INTERVALS: u64 = 5;

/// The picture of a story. Lanes without changes are left out.
pub(super) fn picture(story: &Story) -> Markup {
    let lanes: Vec<&Lane> = story.lanes.iter().filter(|lane| lane.num_changes() > 0).collect();
    if lanes.is_empty() {
        return html! {};
    }
    html! {
        div.chart id="chart" tabindex="0" role="group" aria-label="Lanes over time; the table below has the same content"
            data-duration=(story.duration_us) data-origin=(origin(story)) {
            div.canvas {
                div.lane.axis { div.name {} svg.track id="axis" height=(HEIGHT) aria-hidden="true" { (axis(story)) } }
                @for (at, lane) in lanes.iter().enumerate() {
                    @let before = at.checked_sub(1).map(|before| section(lanes[before]));
                    @if before != Some(section(lane)) { (heading(lane, story)) }
                    div.lane {
                        div.name {
                            code { (name(lane)) }
                            @if let Some(text) = &lane.label { (label(text, story)) }
                        }
                        svg.track height=(HEIGHT) role="img" aria-label=(description(lane)) { (track(lane, story)) }
                    }
                }
            }
        }
    }
}

/// Lanes with the same topic, subject and group have a common heading.
fn section(lane: &Lane) -> (&str, Option<&str>, Option<&str>) {
    (&lane.topic, lane.subject.as_deref(), lane.group.as_ref().map(|group| &*group.text))
}

fn heading(lane: &Lane, story: &Story) -> Markup {
    html! {
        // The lane itself names its topic.
        @if lane.name != lane.topic || lane.subject.is_some() { div.section { span {
            code { (shown(&lane.topic)) }
            @if let Some(subject) = &lane.subject { " " (shown(subject)) }
            @if let Some(group) = &lane.group { " – " (label(group, story)) }
        } } }
    }
}

/// The name of a lane below the heading with its topic.
fn name(lane: &Lane) -> String {
    shown(&lane.name)
}

fn description(lane: &Lane) -> String {
    let count = lane.num_changes();
    format!("{}: {count} change{}", lane_name(lane), if count == 1 { "" } else { "s" })
}

/// The start of a session as µs since midnight; 0 for times since the start.
fn origin(story: &Story) -> i64 {
    let utc = story.utc(0).filter(|_| story.is_session);
    let number = |at: std::ops::Range<usize>| utc.as_deref().and_then(|utc| utc.get(at)?.parse::<i64>().ok());
    let millis = number(11..13).zip(number(14..16)).zip(number(17..19)).zip(number(20..23));
    millis.map_or(0, |(((hour, minute), second), milli)| {
        (((hour * 60 + minute) * 60 + second) * 1_000 + milli) * 1_000
    })
}

/// The ticks of the axis for the whole flight. The script draws those of other zooms.
fn axis(story: &Story) -> Markup {
    let seconds = story.duration_us.div_ceil(1_000_000).max(1);
    let step = STEPS.into_iter().find(|step| seconds / step <= MAX_INTERVALS).unwrap_or(seconds);
    // A hostile capture may last as long as 64 bits can count.
    let (origin, step) = (i128::from(origin(story)), i128::from(step) * 1_000_000);
    let first = (origin.div_euclid(step) + i128::from(origin.rem_euclid(step) > 0)) * step;
    let ticks = (0..).map_while(|count: i128| {
        let at = i64::try_from(first + step * count - origin).ok()?;
        u64::try_from(at).is_ok_and(|at| at <= story.duration_us).then_some(at)
    });
    html! {
        @for at in ticks {
            g.tick {
                line x1=(percent(at, story)) x2=(percent(at, story)) y1="0" y2=(HEIGHT) {}
                // A label at the end would be cut off.
                @if i128::from(at) * 10 < i128::from(story.duration_us) * 9 {
                    text x=(percent(at, story)) dx="4" y="15" { (tick(at, story)) }
                }
            }
        }
    }
}

/// The text of a tick, without milliseconds.
fn tick(at: i64, story: &Story) -> String {
    let text = time(story, at);
    text.split('.').next().unwrap_or_default().to_owned()
}

/// A position on the axis.
fn percent(time_us: i64, story: &Story) -> String {
    let share = i128::from(time_us.max(0)) * 1_000_000 / i128::from(story.duration_us.max(1));
    let share = share.clamp(0, 1_000_000);
    format!("{}.{:04}%", share / 10_000, share % 10_000)
}

fn width(from: i64, to: i64, story: &Story) -> String {
    percent(to.min(i64::try_from(story.duration_us).unwrap_or(i64::MAX)).saturating_sub(from.max(0)), story)
}

fn track(lane: &Lane, story: &Story) -> Markup {
    let end = i64::try_from(story.duration_us).unwrap_or(i64::MAX);
    html! {
        line.base x1="0" x2="100%" y1=(HEIGHT / 2) y2=(HEIGHT / 2) {}
        @for (at, change) in lane.changes.iter().enumerate() {
            @let next = lane.changes.get(at + 1);
            @if let Some(value) = lane.values.get(change.value) {
                @match lane.kind {
                    LaneKind::Event => (event(change, value, story)),
                    // The value after the last listed change isn't known if more changes follow.
                    _ if next.is_none() && lane.more_changes > 0 => (rest(lane, change, end, story)),
                    _ => (span(lane, change, value, next.map_or(end, |next| next.time_us), story)),
                }
            }
        }
    }
}

fn event(change: &Change, value: &Value, story: &Story) -> Markup {
    html! {
        circle.(severity(value)) cx=(percent(change.time_us, story)) cy=(HEIGHT / 2) r="4" {
            title { (tooltip(change, value, story)) }
        }
    }
}

fn span(lane: &Lane, change: &Change, value: &Value, end: i64, story: &Story) -> Markup {
    let class = match value.severity {
        Severity::Normal => format!("v{}", change.value % COLOURS),
        _ => severity(value).to_owned(),
    };
    html! {
        // A cleared flag and an empty list leave the track empty.
        @if !(is_flag(lane) && change.value == 0 || value.parts.is_empty()) {
            // An inner image cuts off texts that don't fit.
            svg.span x=(percent(change.time_us, story)) width=(width(change.time_us, end, story)) height=(HEIGHT) {
                rect.(class) y="2" width="100%" height=(HEIGHT - 4) {}
                @if !is_flag(lane) {
                    text x="5" y="15" { (text(value)) }
                }
                title { (tooltip(change, value, story)) }
            }
            line.edge.(class) x1=(percent(change.time_us, story)) x2=(percent(change.time_us, story)) y1="2" y2=(HEIGHT - 2) {}
        }
    }
}

/// The part of a lane in which more changes aren't listed.
fn rest(lane: &Lane, change: &Change, end: i64, story: &Story) -> Markup {
    html! {
        rect.rest x=(percent(change.time_us, story)) width=(width(change.time_us, end, story)) y="2" height=(HEIGHT - 4) {
            title { (lane.more_changes) " more changes aren't shown" }
        }
    }
}

fn text(value: &Value) -> String {
    let names: Vec<String> = value.parts.iter().map(|part| shown(&part.name)).collect();
    if names.is_empty() { "none".to_owned() } else { names.join("; ") }
}

fn tooltip(change: &Change, value: &Value, story: &Story) -> String {
    let when = if story.is_session { time(story, change.time_us) } else { clock(change.time_us) };
    format!("{when} {}", text(value))
}

const fn severity(value: &Value) -> &'static str {
    match value.severity {
        Severity::Normal => "v0",
        Severity::Info => "info",
        Severity::Warning => "warn",
        Severity::Error => "fail",
    }
}
