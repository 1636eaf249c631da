//! The lines above the fleet: the server, and the number of UAVs by severity.

use std::time::Instant;

use ratatui::text::{Line, Span};
use uavspec_model::text::{plural, thousands};
use uavspec_runtime::Severity;

use super::super::codes::{severity_letter, severity_name};
use super::super::fleet::Link;
use super::theme::Theme;
use super::{Ends, MIDDLE_WIDTH, Scene, spaced};

/// The lines above a page.
pub(super) struct Head<'h> {
    /// The source of the messages.
    pub(super) source: Span<'h>,
    /// The software that the source runs.
    pub(super) software: Span<'h>,
    /// The state of the connection.
    pub(super) link: Line<'h>,
    /// The state of the fleet or the vehicle.
    pub(super) state: Line<'h>,
    /// The rate of messages, as text.
    pub(super) rate: String,
    /// Problems and remarks.
    pub(super) problems: Vec<String>,
}

impl<'h> Head<'h> {
    pub(super) fn lines(self, theme: Theme, width: u16) -> Vec<Ends<'h>> {
        let mut lines = if width < MIDDLE_WIDTH {
            vec![
                Ends::new(self.source, self.link),
                Ends::new(self.software, self.rate),
                Ends::new(self.state, Line::default()),
            ]
        } else {
            vec![Ends::new(spaced([self.source, self.software]), self.link), Ends::new(self.state, self.rate)]
        };
        let problems = self.problems.into_iter().map(|problem| Line::styled(problem, theme.server_error()));
        lines.extend(problems.map(|problem| Ends::new(problem, Line::default())));
        lines
    }
}

pub(super) fn lines<'s>(scene: &'s Scene<'_>, width: u16) -> Vec<Ends<'s>> {
    let theme = scene.theme;
    let head = Head {
        source: Span::styled(scene.url, theme.title()),
        software: Span::raw(scene.fleet.server.as_deref().unwrap_or_default()),
        link: Line::styled(link_text(&scene.fleet.link, scene.now), theme.link(&scene.fleet.link)),
        state: counts(scene, if width < MIDDLE_WIDTH { severity_letter } else { severity_name }),
        rate: rate_text(scene.fleet.rate(scene.now), width),
        problems: server_errors(scene),
    };
    head.lines(theme, width)
}

/// Formats a rate of messages.
pub(super) fn rate_text(rate: f64, width: u16) -> String {
    let unit = if width < MIDDLE_WIDTH { "msg/s" } else { "messages/s" };
    if rate < 100.0 { format!("{rate:.1} {unit}") } else { format!("{rate:.0} {unit}") }
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
    let theme = scene.theme;
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
