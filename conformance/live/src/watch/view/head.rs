//! The lines above the fleet: the server, and the number of UAVs by severity.

use std::time::Instant;

use ratatui::text::{Line, Span};
use uavspec_model::text::{plural, thousands};
use uavspec_runtime::Severity;

use super::super::codes::{severity_letter, severity_name};
use super::super::fleet::Link;
use super::{Ends, MIDDLE_WIDTH, Scene, spaced};

pub(super) fn lines<'s>(scene: &'s Scene<'_>, width: u16) -> Vec<Ends<'s>> {
    let theme = scene.theme();
    let url = Span::styled(scene.url, theme.title());
    let server = Span::raw(scene.fleet.server.as_deref().unwrap_or_default());
    let link = Line::styled(link_text(&scene.fleet.link, scene.now), theme.link(&scene.fleet.link));
    let rate = scene.fleet.rate(scene.now);
    let rate = if rate < 100.0 { format!("{rate:.1}") } else { format!("{rate:.0}") };
    let mut lines = if width < MIDDLE_WIDTH {
        vec![
            Ends::new(url, link),
            Ends::new(server, format!("{rate} msg/s")),
            Ends::new(counts(scene, severity_letter), Line::default()),
        ]
    } else {
        vec![
            Ends::new(spaced([url, server]), link),
            Ends::new(counts(scene, severity_name), format!("{rate} messages/s")),
        ]
    };
    lines.extend(
        server_errors(scene)
            .into_iter()
            .map(|server_error| Ends::new(Line::styled(server_error, theme.server_error()), Line::default())),
    );
    lines
}

/// The state of a connection.
pub(super) fn link_text(link: &Link, now: Instant) -> String {
    match link {
        Link::Connecting => "connecting".to_owned(),
        Link::Connected => "connected".to_owned(),
        Link::Lost { again, .. } => {
            // Rounded up to the next second.
            let left = again.saturating_duration_since(now).as_millis().div_ceil(1000);
            if left == 0 { "lost, reconnecting".to_owned() } else { format!("lost, retry in {left} s") }
        }
    }
}

/// The number of UAVs, in total and by severity.
fn counts<'s>(scene: &Scene<'_>, name: fn(Severity) -> &'static str) -> Line<'s> {
    let count = scene.fleet.len();
    let uavs = plural(count, "UAV");
    let theme = scene.theme();
    let by_severity = Severity::ALL.into_iter().rev().map(|severity| {
        let count = scene.fleet.count(severity);
        let style = if count == 0 { theme.faint() } else { theme.severity(severity) };
        Span::styled(format!("{} {}", thousands(count), name(severity)), style)
    });
    spaced([Span::raw(uavs)].into_iter().chain(by_severity))
}

/// Errors and remarks about the server.
fn server_errors(scene: &Scene<'_>) -> Vec<String> {
    let fleet = scene.fleet;
    let mut server_errors = Vec::new();
    if let Link::Lost { reason, .. } = &fleet.link {
        server_errors.push(uavspec_model::text::shown(reason));
    }
    server_errors.extend(fleet.remark.clone());
    if fleet.unreadable > 0 {
        server_errors.push(plural(fleet.unreadable, "unreadable message"));
    }
    if fleet.is_overfull {
        server_errors.push("the server has more UAVs than can be shown".to_owned());
    }
    server_errors
}
