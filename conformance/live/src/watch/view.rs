//! Draws the screen. Drawing modifies only the scroll positions.

mod details;
mod foot;
mod head;
pub(super) mod table;
mod theme;
pub mod vehicle;
mod wrap;

use std::time::Instant;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::{Line, Span};

pub use self::theme::Theme;
use super::codes::Codes;
use super::fleet::{Fleet, Uav};
use super::screen::{Page, Pages, Screen};
use super::words::truncated;

/// The data to draw.
#[derive(Debug)]
pub struct Scene<'s> {
    /// The fleet.
    pub fleet: &'s Fleet,
    /// The meanings of error codes.
    pub codes: &'s Codes,
    /// The URL of the server.
    pub url: &'s str,
    /// The styles.
    pub theme: Theme,
    /// The time of drawing.
    pub now: Instant,
}

/// The minimum width for the medium layout.
const MIDDLE_WIDTH: u16 = 80;

/// The minimum height at which the error codes of the selected UAV are shown below the table.
const NOTED_HEIGHT: u16 = 16;

/// The gap between columns of lines.
const GAP: u16 = 2;

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

/// Draws the screen.
pub fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>, screen: &mut Screen) {
    let area = frame.area();
    let order = format!("sort: {}", screen.order.name());
    let keys =
        [("q", "quit"), ("s", &*order), ("/", "filter"), ("?", "help"), ("Enter", "details"), ("↑↓", "move")];
    let foot = foot::line(&screen.pages, &keys, scene.theme, area.width);
    let middle = draw_frame(frame, head::lines(scene, area.width), foot);
    match screen.pages.page {
        Page::Main | Page::Filter => draw_fleet(frame, scene, screen, middle, area.height),
        Page::Details => {
            let id = screen.selected.as_deref().unwrap_or_default();
            let lines = details::lines(scene, id, usize::from(middle.width));
            draw_columns(frame, vec![lines], &mut screen.pages, middle);
        }
        Page::Help => {
            draw_columns(frame, vec![foot::help(&KEYS, middle.width)], &mut screen.pages, middle);
        }
    }
}

/// Draws the first lines and the last line of a screen, and returns the area between them.
fn draw_frame(frame: &mut Frame<'_>, head: Vec<Ends<'_>>, foot: Ends<'_>) -> Rect {
    let head_height = u16::try_from(head.len()).unwrap_or(u16::MAX);
    let parts = [Constraint::Length(head_height), Constraint::Min(0), Constraint::Length(1)];
    let [top, middle, bottom] = Layout::vertical(parts).areas(frame.area());
    for (line, row) in head.into_iter().zip(top.rows()) {
        line.draw(frame, row);
    }
    foot.draw(frame, bottom);
    middle
}

/// Draws the visible lines of columns that have the same width.
fn draw_columns(frame: &mut Frame<'_>, columns: Vec<Vec<Line<'_>>>, pages: &mut Pages, area: Rect) {
    pages.height = usize::from(area.height);
    let longest = columns.iter().map(Vec::len).max().unwrap_or_default();
    pages.first_line = pages.first_line.min(longest.saturating_sub(pages.height));
    let areas = Layout::horizontal(columns.iter().map(|_| Constraint::Fill(1))).spacing(GAP).split(area);
    for (lines, area) in columns.into_iter().zip(areas.iter()) {
        for (line, row) in lines.into_iter().skip(pages.first_line).zip(area.rows()) {
            frame.render_widget(wrap::clipped(line, usize::from(row.width)), row);
        }
    }
}

fn draw_fleet(frame: &mut Frame<'_>, scene: &Scene<'_>, screen: &mut Screen, area: Rect, height: u16) {
    let note_height = if height < NOTED_HEIGHT { 0 } else { 4 };
    let [rest, below] = Layout::vertical([Constraint::Min(0), Constraint::Length(note_height)]).areas(area);
    let rows = screen.rows(scene.fleet);
    // One line is reserved for the column titles.
    let selected = screen.select_row(&rows, usize::from(rest.height.saturating_sub(1)));
    if rows.is_empty() {
        let is_filtered = !scene.fleet.is_empty();
        let text = if is_filtered { "no id contains this text" } else { "no UAVs yet" };
        frame.render_widget(Line::styled(text, scene.theme.faint()), rest);
        return;
    }
    table::draw(frame, scene, screen, &rows, rest);
    if let Some((id, uav)) = selected.and_then(|row| rows.get(row)) {
        draw_note(frame, scene, id, uav, below);
    }
}

/// Draws the most severe error codes of a UAV, with their meanings.
fn draw_note(frame: &mut Frame<'_>, scene: &Scene<'_>, id: &str, uav: &Uav, area: Rect) {
    let mut lines = vec![Line::styled(truncated(id), scene.theme.title())];
    lines.extend(uav.refusal.iter().map(|reason| Line::raw(format!("no state: {reason}"))));
    lines.extend(uav.codes().iter().map(|code| table::describe_code(scene, *code)));
    for (line, row) in lines.into_iter().zip(area.rows()) {
        frame.render_widget(wrap::clipped(line, usize::from(row.width)), row);
    }
}

/// A line with text at both ends. If there isn't enough space, the right end takes precedence.
struct Ends<'l> {
    left: Line<'l>,
    right: Line<'l>,
}

impl<'l> Ends<'l> {
    fn new(left: impl Into<Line<'l>>, right: impl Into<Line<'l>>) -> Self {
        Self { left: left.into(), right: right.into() }
    }

    fn draw(self, frame: &mut Frame<'_>, area: Rect) {
        let right = wrap::clipped(self.right, usize::from(area.width));
        let width = u16::try_from(right.width()).unwrap_or(area.width).min(area.width);
        let gap = u16::from(width > 0);
        let left = area.width.saturating_sub(width + gap);
        frame.render_widget(wrap::clipped(self.left, usize::from(left)), Rect { width: left, ..area });
        frame.render_widget(right, Rect { x: area.x + area.width - width, width, ..area });
    }
}

/// Joins spans with two spaces.
fn spaced<'s>(spans: impl IntoIterator<Item = Span<'s>>) -> Line<'s> {
    let mut all = Vec::new();
    for span in spans {
        if !all.is_empty() {
            all.push(Span::raw("  "));
        }
        all.push(span);
    }
    Line::from(all)
}

#[cfg(test)]
mod tests;
