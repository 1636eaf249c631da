//! The lines above the sections: the source, and the state of the vehicle.

use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use uavspec_check::timeline::Part;
use uavspec_model::text::{plural, shown, thousands};

use super::Scene;
use crate::watch::fleet::Link;
use crate::watch::format;
use crate::watch::vehicle::age;
use crate::watch::vehicle::playback::{Kind, Shown};
use crate::watch::view::head::{Head, link_text, rate_text};
use crate::watch::view::{Ends, spaced};
use crate::watch::words::truncated;

pub(super) fn lines(scene: &Scene<'_>, width: u16) -> Vec<Ends<'static>> {
    let (theme, vehicle, now) = (scene.theme, scene.shown.vehicle, scene.shown.now);
    let (link, link_style) = link(scene);
    let age = format::age(vehicle.latest.map(|latest| age(latest, now)));
    let head = Head {
        source: Span::styled(shown(scene.source), theme.title()),
        software: Span::raw(vehicle.release.as_deref().map(shown).unwrap_or_default()),
        link: Line::styled(link, link_style),
        state: spaced(state(scene)),
        rate: format!("{}, last {age} ago", rate_text(vehicle.rate(now), width)),
        problems: notes(scene),
    };
    head.lines(theme, width)
}

/// The state of the connection or the replay.
fn link(scene: &Scene<'_>) -> (String, Style) {
    let (theme, Shown { state, vehicle, kind, now }) = (scene.theme, scene.shown);
    let paused = theme.colour(Color::Yellow);
    let at = format!("{:.1} s", vehicle.elapsed(*now).as_secs_f64());
    match kind {
        Kind::Live if state.is_paused => {
            let changes = plural(state.waiting.len(), "change");
            (format!("paused, {changes} waiting"), paused)
        }
        Kind::Live => (link_text(&state.link, scene.now), theme.link(&state.link)),
        Kind::Replay if state.end.is_some() => (format!("end at {at}"), theme.title()),
        Kind::Replay if state.is_paused => (format!("paused at {at}"), paused),
        Kind::Replay => (format!("{}× at {at}", state.speed()), theme.colour(Color::Green)),
        Kind::State(_) => (format!("at {at}"), theme.title()),
    }
}

/// The arming state, the mode and the result of the checks.
fn state(scene: &Scene<'_>) -> Vec<Span<'static>> {
    let theme = scene.theme;
    let status = &scene.shown.vehicle.status;
    let name = |part: &Option<Part>| part.as_ref().map(|part| truncated(&part.name));
    let failed = |text: &str| Span::styled(text.to_owned(), theme.server_error());
    let mut spans: Vec<Span<'_>> = Vec::new();
    spans.extend(name(&status.arming_state).map(|state| Span::styled(state, theme.title())));
    spans.extend(name(&status.nav_state).map(|mode| Span::raw(format!("mode {mode}"))));
    match status.has_passed_checks {
        Some(true) => spans.push(Span::raw("checks pass")),
        Some(false) => spans.push(failed("checks fail")),
        None => {}
    }
    if status.is_failsafe == Some(true) {
        spans.push(failed("failsafe"));
    }
    if spans.is_empty() {
        let is_unknown = scene.shown.vehicle.undecided.contains("vehicle_status");
        let text = if is_unknown { "vehicle_status of an unknown release" } else { "no vehicle_status yet" };
        spans.push(Span::styled(text, theme.faint()));
    }
    spans
}

/// Problems and remarks.
fn notes(scene: &Scene<'_>) -> Vec<String> {
    let (state, vehicle) = (scene.shown.state, scene.shown.vehicle);
    let mut notes = Vec::new();
    if let Link::Lost { reason, .. } = &state.link {
        notes.push(shown(reason));
    }
    notes.extend(state.notes.iter().map(|note| shown(note)));
    if state.lost > 0 {
        let messages = if state.lost == 1 { "message was" } else { "messages were" };
        notes.push(format!("{} {messages} lost", thousands(state.lost)));
    }
    if vehicle.unreadable > 0 {
        let count = plural(vehicle.unreadable, "message");
        notes.push(format!("{count} can't be read: `uavspec probe` or `uavspec check` reports the reasons"));
    }
    if let Some(topic) = vehicle.ambiguous {
        notes.push(format!("several channels carry {topic}: the display mixes their vehicles"));
    }
    notes
}
