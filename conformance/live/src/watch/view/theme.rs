//! Styles. Colour is never the only indication: a word or bold text always conveys the same information.

use ratatui::style::{Color, Modifier, Style};
use uavspec_runtime::Severity;

use super::super::fleet::Link;

/// The styles of the screen.
#[derive(Clone, Copy, Debug)]
pub struct Theme {
    /// True if colours are enabled. Words and bold text convey the same information.
    pub is_coloured: bool,
}

impl Theme {
    pub(super) fn severity(self, severity: Severity) -> Style {
        let (colour, modifier) = match severity {
            Severity::Fatal => (Color::LightRed, Modifier::BOLD | Modifier::UNDERLINED),
            Severity::Error => (Color::LightRed, Modifier::BOLD),
            Severity::Warning => (Color::Yellow, Modifier::empty()),
            Severity::Informational => (Color::Cyan, Modifier::empty()),
        };
        self.colour(colour).add_modifier(modifier)
    }

    pub(super) fn link(self, link: &Link) -> Style {
        match link {
            Link::Connecting => self.colour(Color::Yellow),
            Link::Connected => self.colour(Color::Green),
            Link::Lost { .. } => self.server_error(),
        }
    }

    /// The style of server errors.
    pub(super) fn server_error(self) -> Style {
        self.colour(Color::LightRed).add_modifier(Modifier::BOLD)
    }

    pub(super) fn title(self) -> Style {
        self.colour(Color::Reset).add_modifier(Modifier::BOLD)
    }

    /// The style of less important or stale text.
    pub(super) fn faint(self) -> Style {
        self.colour(Color::Reset).add_modifier(Modifier::DIM)
    }

    /// The style of the selected row.
    pub(super) fn selected(self) -> Style {
        self.colour(Color::Reset).add_modifier(Modifier::REVERSED)
    }

    pub(super) fn colour(self, colour: Color) -> Style {
        if self.is_coloured { Style::new().fg(colour) } else { Style::new() }
    }
}
