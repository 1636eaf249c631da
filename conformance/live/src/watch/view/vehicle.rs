//! Draws the screen of a vehicle, or prints it as text.

mod head;
mod sections;

use std::time::Instant;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::Line;

use super::foot::{help_lines, keys_line};
use super::theme::Theme;
use super::{Ends, wrap};
use crate::watch::vehicle::playback::{Kind, Shown};
use crate::watch::vehicle::screen::{Page, Screen};

/// The minimum width at which the sections are in two columns.
const WIDE: u16 = 120;

/// The gap between the columns.
const GAP: u16 = 2;

/// The width of the text for scripts.
const TEXT_WIDTH: u16 = 100;

/// The keys, and an explanation of the words.
const KEYS: [(&str, &str); 9] = [
    ("p, space", "pause, or continue"),
    (".", "show the next change, and pause"),
    ("+ -", "replay faster or slower"),
    ("/", "show only flags that contain a text; Esc clears the filter"),
    ("↑ ↓ j k", "scroll; also PgUp, PgDn, Home, End"),
    ("?", "show this page"),
    ("q", "quit; also Esc and Ctrl-C"),
    ("", ""),
    (
        "",
        "A set flag is an error if the current mode requires it to be clear, or if the failure detector set it. Other \
         set flags are warnings. The number in brackets is the number of modes that the flag blocks. An external \
         component is late if it didn't reply to three requests in a row. PX4 then ignores it. The events that \
         explain a refusal have numbers: ground stations know their texts.",
    ),
];

/// The data to draw.
pub struct Scene<'s> {
    /// The state of the vehicle and its source.
    pub shown: &'s Shown<'s>,
    /// The address or the path of the source.
    pub source: &'s str,
    /// The language of the labels.
    pub language: &'s str,
    /// True if colours are enabled. Words and bold text convey the same information.
    pub is_coloured: bool,
    /// The time of drawing.
    pub now: Instant,
}

impl Scene<'_> {
    fn theme(&self) -> Theme {
        Theme { is_coloured: self.is_coloured }
    }
}

/// Draws the screen.
pub fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>, screen: &mut Screen) {
    let area = frame.area();
    let head = head::lines(scene, area.width);
    let head_height = u16::try_from(head.len()).unwrap_or(u16::MAX);
    let parts = [Constraint::Length(head_height), Constraint::Min(0), Constraint::Length(1)];
    let [top, middle, bottom] = Layout::vertical(parts).areas(area);
    for (line, row) in head.into_iter().zip(top.rows()) {
        line.draw(frame, row);
    }
    if screen.page == Page::Help {
        draw_columns(frame, vec![help_lines(&KEYS, middle.width)], screen, middle);
    } else {
        draw_columns(frame, columns(scene, &screen.filter, middle.width), screen, middle);
    }
    foot(scene, screen, bottom.width).draw(frame, bottom);
}

/// The sections, in one or two columns.
fn columns(scene: &Scene<'_>, filter: &str, width: u16) -> Vec<Vec<Line<'static>>> {
    if width < WIDE {
        return vec![one_column(scene, filter, width)];
    }
    let width = usize::from((width - GAP) / 2);
    let left = [sections::set_flags(scene, filter, width), sections::modes(scene, width)];
    let right = [
        sections::batteries(scene, width),
        sections::components(scene, width),
        sections::clear_flags(scene, filter, width),
    ];
    vec![left.concat(), right.concat()]
}

fn one_column(scene: &Scene<'_>, filter: &str, width: u16) -> Vec<Line<'static>> {
    let width = usize::from(width);
    let sections = [
        sections::set_flags(scene, filter, width),
        sections::components(scene, width),
        sections::batteries(scene, width),
        sections::modes(scene, width),
        sections::clear_flags(scene, filter, width),
    ];
    sections.concat()
}

/// Draws the visible lines of columns with the same width.
fn draw_columns(frame: &mut Frame<'_>, columns: Vec<Vec<Line<'_>>>, screen: &mut Screen, area: Rect) {
    screen.height = usize::from(area.height);
    let longest = columns.iter().map(Vec::len).max().unwrap_or_default();
    screen.first_line = screen.first_line.min(longest.saturating_sub(screen.height));
    let areas = Layout::horizontal(columns.iter().map(|_| Constraint::Fill(1))).spacing(GAP).split(area);
    for (lines, area) in columns.into_iter().zip(areas.iter()) {
        for (line, row) in lines.into_iter().skip(screen.first_line).zip(area.rows()) {
            frame.render_widget(wrap::clipped(line, usize::from(row.width)), row);
        }
    }
}

/// The last line: the most important keys, and the filter.
fn foot<'l>(scene: &Scene<'_>, screen: &Screen, width: u16) -> Ends<'l> {
    let theme = scene.theme();
    let pause = ("p", if scene.shown.is_paused { "continue" } else { "pause" });
    let mut keys = match screen.page {
        Page::Filter => return Ends::new(format!("/{}_", screen.filter), "Enter apply  Esc clear"),
        Page::Help => vec![("q", "quit"), ("Esc", "back"), ("↑↓", "scroll")],
        Page::Vehicle => {
            vec![("q", "quit"), pause, (".", "step"), ("/", "filter"), ("?", "help"), ("↑↓", "scroll")]
        }
    };
    if screen.page == Page::Vehicle && scene.shown.kind == Kind::Replay {
        keys.push(("+-", "speed"));
    }
    let filter = if screen.filter.is_empty() { String::new() } else { format!("/{}", screen.filter) };
    Ends::new(keys_line(&keys, theme, width), Line::styled(filter, theme.title()))
}

/// The state as text.
pub fn text(scene: &Scene<'_>) -> String {
    let head = head::lines(scene, TEXT_WIDTH).into_iter().map(|line| {
        let joined = format!("{}  {}", line.left, line.right);
        joined.trim_end().to_owned() + "\n"
    });
    let lines = one_column(scene, "", TEXT_WIDTH);
    head.chain(lines.into_iter().map(|line| line.to_string().trim_end().to_owned() + "\n")).collect()
}

#[cfg(test)]
mod tests;
