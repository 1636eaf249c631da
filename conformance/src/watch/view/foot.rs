//! The last line, and the page that tells all keys.

use ratatui::text::{Line, Span};

use super::super::screen::{Page, Screen};
use super::theme::Theme;
use super::wrap::wrapped;
use super::{Ends, spaced};

/// All keys.
const KEYS: [(&str, &str); 8] = [
    ("↑ ↓ j k", "move by one; PgUp, PgDn, Home, End by more"),
    ("Enter", "all of the UAV that is looked at; Enter or Esc leads back"),
    ("s", "what comes first: ids in their order, what is gravest, the least charge"),
    ("/", "show only UAVs whose id has a text in it; Esc shows all again"),
    ("?", "this page"),
    ("q", "quit; Esc and Ctrl-C, too"),
    ("", ""),
    (
        "",
        "A dash stands for what a UAV doesn't tell, ? for a value of a wrong type. A plus behind the charge says \
          that the battery is charging. AMSL, AHL and AGL are altitudes in metres: above mean sea level, the home \
          position and the ground. AGE is how long ago the UAV was heard of; from 10 seconds on it is shown faintly. \
          The letters F, E, W and i say that the gravest error code is fatal, an error, a warning or mere \
          information; behind the codes stands what the gravest means.",
    ),
];

/// The keys of a page, those first that matter most.
pub(super) fn line<'l>(screen: &Screen, theme: Theme, width: u16) -> Ends<'l> {
    if screen.page == Page::Filter {
        return Ends::new(format!("/{}_", screen.filter), "Enter keep  Esc clear");
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
    let mut left = usize::from(width);
    let shown = keys.into_iter().map(|(key, what)| format!("{key} {what}")).take_while(|text| {
        let wide = Span::raw(text).width() + 2;
        let fits = wide <= left + 2;
        left = left.saturating_sub(wide);
        fits
    });
    let shown: Vec<Span<'_>> = shown.map(|text| Span::styled(text, theme.faint())).collect();
    let filter = if screen.filter.is_empty() { String::new() } else { format!("/{}", screen.filter) };
    Ends::new(spaced(shown), Line::styled(filter, theme.title()))
}

/// The page that tells all keys.
pub(super) fn help(width: u16) -> Vec<Line<'static>> {
    let indent = 9;
    let width = usize::from(width).saturating_sub(indent);
    let lines = KEYS.iter().flat_map(|(key, what)| {
        wrapped(what, width).into_iter().enumerate().map(move |(number, part)| {
            let key = if number == 0 { *key } else { "" };
            Line::raw(format!("{key:indent$}{part}"))
        })
    });
    lines.collect()
}
