//! The last line, and the help page.

use ratatui::text::{Line, Span};

use super::super::screen::{Page, Pages};
use super::theme::Theme;
use super::wrap::labelled;
use super::{Ends, spaced};

/// The most important keys of a page: as many as fit into the width. `main` are the keys of the main page.
pub(super) fn line<'l>(pages: &Pages, main: &[(&str, &str)], theme: Theme, width: u16) -> Ends<'l> {
    let keys: &[(&str, &str)] = match pages.page {
        Page::Filter => return Ends::new(format!("/{}_", pages.filter), "Enter apply  Esc clear"),
        Page::Main => main,
        Page::Details => &[("q", "quit"), ("Esc", "back"), ("↑↓", "scroll"), ("?", "help")],
        Page::Help => &[("q", "quit"), ("Esc", "back"), ("↑↓", "scroll")],
    };
    let mut free = usize::from(width);
    let shown = keys.iter().map(|(key, action)| format!("{key} {action}")).take_while(|text| {
        let needed = Span::raw(text).width() + 2;
        let fits = needed <= free + 2;
        free = free.saturating_sub(needed);
        fits
    });
    let line = spaced(shown.map(|text| Span::styled(text, theme.faint())));
    let filter = if pages.filter.is_empty() { String::new() } else { format!("/{}", pages.filter) };
    Ends::new(line, Line::styled(filter, theme.title()))
}

/// A page that explains these keys.
pub(super) fn help(keys: &'static [(&str, &str)], width: u16) -> Vec<Line<'static>> {
    keys.iter().flat_map(|(key, text)| labelled(*key, *text, 9, usize::from(width))).collect()
}
