//! The picture: a track for each lane, one below the other, with a common axis.
//!
//! Positions are percentages of the width of a track, so making the tracks wider zooms the picture.

use maud::{Markup, html};
use uavspec_check::timeline::{Change, Lane, LaneKind, Severity, Timeline, Value};
use uavspec_model::text::shown;

use super::label;
use crate::timeline::{clock, is_flag, lane_name, time};

/// The height of a track, in pixels.
const HEIGHT: u32 = 22;

/// The number of colours for values without a problem.
const COLOURS: usize = 6;

/// The distances between the ticks of the axis, in seconds.
const STEPS: [u64; 18] =
    [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1_800, 3_600, 7_200, 14_400, 28_800, 86_400, 864_000];

/// The maximum number of intervals between ticks, before the user zooms.
const MAX_INTERVALS: u64 = 5;

/// The picture of a timeline. Lanes without changes are left out.
pub(super) fn picture(timeline: &Timeline) -> Markup {
    let lanes: Vec<&Lane> = timeline.lanes.iter().filter(|lane| lane.num_changes() > 0).collect();
    if lanes.is_empty() {
        return html! {};
    }
    html! {
        div.chart id="chart" tabindex="0" role="group" aria-label="Lanes over time; the table below has the same content"
            data-duration=(timeline.duration_us) data-origin=(origin(timeline)) {
            div.canvas {
                div.lane.axis { div.name {} svg.track id="axis" height=(HEIGHT) aria-hidden="true" { (axis(timeline)) } }
                @for (at, lane) in lanes.iter().enumerate() {
                    @let before = at.checked_sub(1).map(|before| section(lanes[before]));
                    @if before != Some(section(lane)) { (heading(lane, timeline)) }
                    div.lane {
                        div.name {
                            // The heading contains the topic.
                            code { (shown(&lane.name)) }
                            @if let Some(text) = &lane.label { (label(text, timeline)) }
                        }
                        svg.track height=(HEIGHT) role="img" aria-label=(description(lane)) { (track(lane, timeline)) }
                    }
                }
            }
        }
    }
}

/// The heading of a lane. Lanes with the same topic, subject and group share a heading.
fn section(lane: &Lane) -> (&str, Option<&str>, Option<&str>) {
    (&lane.topic, lane.subject.as_deref(), lane.group.as_ref().map(|group| &*group.text))
}

fn heading(lane: &Lane, timeline: &Timeline) -> Markup {
    html! {
        // The lane itself contains the name of its topic.
        @if lane.name != lane.topic || lane.subject.is_some() { div.section { span {
            code { (shown(&lane.topic)) }
            @if let Some(subject) = &lane.subject { " " (shown(subject)) }
            @if let Some(group) = &lane.group { " – " (label(group, timeline)) }
        } } }
    }
}

fn description(lane: &Lane) -> String {
    let count = lane.num_changes();
    format!("{}: {count} change{}", lane_name(lane), if count == 1 { "" } else { "s" })
}

/// The start of the time axis, in µs. For a session, the time of the start since midnight; otherwise, 0.
fn origin(timeline: &Timeline) -> i64 {
    let utc = timeline.utc(0).filter(|_| timeline.is_session);
    let number = |at: std::ops::Range<usize>| utc.as_deref().and_then(|utc| utc.get(at)?.parse::<i64>().ok());
    let millis = number(11..13).zip(number(14..16)).zip(number(17..19)).zip(number(20..23));
    millis.map_or(0, |(((hour, minute), second), milli)| {
        (((hour * 60 + minute) * 60 + second) * 1_000 + milli) * 1_000
    })
}

/// The ticks of the axis for the whole flight. When the user zooms, the script draws other ticks.
fn axis(timeline: &Timeline) -> Markup {
    let seconds = timeline.duration_us.div_ceil(1_000_000).max(1);
    let step = STEPS.into_iter().find(|step| seconds / step <= MAX_INTERVALS).unwrap_or(seconds);
    // The duration of a hostile capture may be any number of 64 bits.
    let (origin, step) = (i128::from(origin(timeline)), i128::from(step) * 1_000_000);
    let first = (origin.div_euclid(step) + i128::from(origin.rem_euclid(step) > 0)) * step;
    let ticks = (0..).map_while(|count: i128| {
        let at = i64::try_from(first + step * count - origin).ok()?;
        u64::try_from(at).is_ok_and(|at| at <= timeline.duration_us).then_some(at)
    });
    html! {
        @for at in ticks {
            g.tick {
                line x1=(percent(at, timeline)) x2=(percent(at, timeline)) y1="0" y2=(HEIGHT) {}
                // A label at the end would be truncated.
                @if i128::from(at) * 10 < i128::from(timeline.duration_us) * 9 {
                    text x=(percent(at, timeline)) dx="4" y="15" { (tick(at, timeline)) }
                }
            }
        }
    }
}

/// The text of a tick, without milliseconds.
fn tick(at: i64, timeline: &Timeline) -> String {
    let text = time(timeline, at);
    text.split('.').next().unwrap_or_default().to_owned()
}

/// A position on the axis.
fn percent(time_us: i64, timeline: &Timeline) -> String {
    let share = i128::from(time_us.max(0)) * 1_000_000 / i128::from(timeline.duration_us.max(1));
    let share = share.clamp(0, 1_000_000);
    format!("{}.{:04}%", share / 10_000, share % 10_000)
}

fn width(from: i64, to: i64, timeline: &Timeline) -> String {
    percent(
        to.min(i64::try_from(timeline.duration_us).unwrap_or(i64::MAX)).saturating_sub(from.max(0)),
        timeline,
    )
}

fn track(lane: &Lane, timeline: &Timeline) -> Markup {
    let end = i64::try_from(timeline.duration_us).unwrap_or(i64::MAX);
    html! {
        line.base x1="0" x2="100%" y1=(HEIGHT / 2) y2=(HEIGHT / 2) {}
        @for (at, change) in lane.changes.iter().enumerate() {
            @let next = lane.changes.get(at + 1);
            @if let Some(value) = lane.values.get(change.value) {
                @match lane.kind {
                    LaneKind::Event => (event(change, value, timeline)),
                    // If further changes follow that aren't listed, the value after the last listed change isn't known.
                    _ if next.is_none() && lane.more_changes > 0 => (rest(lane, change, end, timeline)),
                    _ => (span(lane, change, value, next.map_or(end, |next| next.time_us), timeline)),
                }
            }
        }
    }
}

fn event(change: &Change, value: &Value, timeline: &Timeline) -> Markup {
    html! {
        circle.(severity(value)) cx=(percent(change.time_us, timeline)) cy=(HEIGHT / 2) r="4" {
            title { (tooltip(change, value, timeline)) }
        }
    }
}

fn span(lane: &Lane, change: &Change, value: &Value, end: i64, timeline: &Timeline) -> Markup {
    let class = match value.severity {
        Severity::Normal => format!("v{}", change.value % COLOURS),
        _ => severity(value).to_owned(),
    };
    html! {
        // If a flag is cleared or a list is empty, the track is empty.
        @if !(is_flag(lane) && change.value == 0 || value.parts.is_empty()) {
            // A nested image clips texts that don't fit.
            svg.span x=(percent(change.time_us, timeline)) width=(width(change.time_us, end, timeline)) height=(HEIGHT) {
                rect.(class) y="2" width="100%" height=(HEIGHT - 4) {}
                @if !is_flag(lane) {
                    text x="5" y="15" { (text(value)) }
                }
                title { (tooltip(change, value, timeline)) }
            }
            line.edge.(class) x1=(percent(change.time_us, timeline)) x2=(percent(change.time_us, timeline)) y1="2" y2=(HEIGHT - 2) {}
        }
    }
}

/// The part of a lane after its last listed change, in which the changes aren't listed.
fn rest(lane: &Lane, change: &Change, end: i64, timeline: &Timeline) -> Markup {
    html! {
        rect.rest x=(percent(change.time_us, timeline)) width=(width(change.time_us, end, timeline)) y="2" height=(HEIGHT - 4) {
            title { (lane.more_changes) " more changes aren't shown" }
        }
    }
}

fn text(value: &Value) -> String {
    let names: Vec<String> = value.parts.iter().map(|part| shown(&part.name)).collect();
    if names.is_empty() { "none".to_owned() } else { names.join("; ") }
}

fn tooltip(change: &Change, value: &Value, timeline: &Timeline) -> String {
    let when = if timeline.is_session { time(timeline, change.time_us) } else { clock(change.time_us) };
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
