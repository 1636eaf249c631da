//! The last line, and the help page.

use ratatui::text::{Line, Span};

use super::super::screen::{Page, Screen};
use super::theme::Theme;
use super::wrap::wrapped;
use super::{Ends, spaced};

/// The keys, and an explanation of the columns.
const KEYS: [(&str, &str); 8] = [
    ("↑ ↓ j k", "move; also PgUp, PgDn, Home, End"),
    ("Enter", "show details of the selected UAV; Enter or Esc returns"),
    ("s", "sort by id, severity or charge"),
    ("/", "filter by id; Esc clears the filter"),
    ("?", "show this page"),
    ("q", "quit; also Esc and Ctrl-C"),
    ("", ""),
    (
        "",
        "A dash means that the UAV doesn't report the value; ? means that the value has the wrong type. A plus after \
          the charge means that the battery is charging. AMSL, AHL and AGL are altitudes in metres above mean sea \
          level, the home position and the ground. AGE is the time since the last state; UAVs with an age of 10 \
          seconds or more are dimmed. F, E, W and i show the severity of the most severe error code: fatal, error, \
          warning or info. The description of this code is shown after the list of codes.",
    ),
];

/// The most important keys of a page.
pub(super) fn line<'l>(screen: &Screen, theme: Theme, width: u16) -> Ends<'l> {
    if screen.page == Page::Filter {
        return Ends::new(format!("/{}_", screen.filter), "Enter apply  Esc clear");
    }
    let order = format!("sort: {}", screen.order.name());
    let keys = match screen.page {
        Page::Fleet | Page::Filter => vec![
            ("q", "quit"),
            ("s", &order[..]),
            ("/", "filter"),
            ("?", "help"),
            ("Enter", "details"),
            ("↑↓", "move"),
        ],
        Page::Details => vec![("q", "quit"), ("Esc", "back"), ("↑↓", "scroll"), ("?", "help")],
        Page::Help => vec![("q", "quit"), ("Esc", "back"), ("↑↓", "scroll")],
    };
    let line = keys_line(&keys, theme, width);
    let filter = if screen.filter.is_empty() { String::new() } else { format!("/{}", screen.filter) };
    Ends::new(line, Line::styled(filter, theme.title()))
}

/// As many keys as fit into a width.
pub(super) fn keys_line<'l>(keys: &[(&str, &str)], theme: Theme, width: u16) -> Line<'l> {
    let mut free = usize::from(width);
    let shown = keys.iter().map(|(key, action)| format!("{key} {action}")).take_while(|text| {
        let needed = Span::raw(text).width() + 2;
        let fits = needed <= free + 2;
        free = free.saturating_sub(needed);
        fits
    });
    spaced(shown.map(|text| Span::styled(text, theme.faint())))
}

/// The help page.
pub(super) fn help(width: u16) -> Vec<Line<'static>> {
    help_lines(&KEYS, width)
}

/// A page that explains these keys.
pub(super) fn help_lines(keys: &'static [(&str, &str)], width: u16) -> Vec<Line<'static>> {
    let indent = 9;
    let width = usize::from(width).saturating_sub(indent);
    let lines = keys.iter().flat_map(|(key, text)| {
        wrapped(text, width).into_iter().enumerate().map(move |(number, part)| {
            let key = if number == 0 { *key } else { "" };
            Line::raw(format!("{key:indent$}{part}"))
        })
    });
    lines.collect()
}
