//! Draws the screen. Drawing modifies only the scroll positions.

mod details;
mod foot;
mod head;
mod table;
mod theme;
pub mod vehicle;
mod wrap;

use std::time::Instant;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::{Line, Span};

use self::theme::Theme;
use super::codes::Codes;
use super::fleet::{Fleet, Uav};
use super::screen::{Page, Screen};

/// The data to draw.
#[derive(Debug)]
pub struct Scene<'s> {
    /// The fleet.
    pub fleet: &'s Fleet,
    /// The meanings of error codes.
    pub codes: &'s Codes,
    /// The URL of the server.
    pub url: &'s str,
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

/// The minimum width for the medium layout.
const MIDDLE_WIDTH: u16 = 80;

/// The minimum height at which the table is followed by the error codes of the selected UAV.
const NOTED_HEIGHT: u16 = 16;

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
    match screen.page {
        Page::Fleet | Page::Filter => draw_fleet(frame, scene, screen, middle, area.height),
        Page::Details => {
            let id = screen.selected.as_deref().unwrap_or_default();
            draw_lines(frame, details::lines(scene, id, usize::from(middle.width)), screen, middle);
        }
        Page::Help => draw_lines(frame, foot::help(middle.width), screen, middle),
    }
    foot::line(screen, scene.theme(), bottom.width).draw(frame, bottom);
}

/// Draws the visible lines of a page.
fn draw_lines(frame: &mut Frame<'_>, lines: Vec<Line<'_>>, screen: &mut Screen, area: Rect) {
    screen.height = usize::from(area.height);
    screen.first_line = screen.first_line.min(lines.len().saturating_sub(screen.height));
    for (line, row) in lines.into_iter().skip(screen.first_line).zip(area.rows()) {
        frame.render_widget(line, row);
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
        frame.render_widget(Line::styled(text, scene.theme().faint()), rest);
        return;
    }
    table::draw(frame, scene, screen, &rows, rest);
    if let Some((id, uav)) = selected.and_then(|row| rows.get(row)) {
        draw_note(frame, scene, id, uav, below);
    }
}

/// Draws the most severe error codes of a UAV, with their meanings.
fn draw_note(frame: &mut Frame<'_>, scene: &Scene<'_>, id: &str, uav: &Uav, area: Rect) {
    let mut lines = vec![Line::styled(super::words::shown_id(id), scene.theme().title())];
    lines.extend(uav.refusal.iter().map(|reason| Line::raw(format!("no state: {reason}"))));
    lines.extend(uav.codes().iter().map(|code| table::describe_code(scene, *code)));
    for (line, row) in lines.into_iter().zip(area.rows()) {
        frame.render_widget(wrap::clipped(line, usize::from(row.width)), row);
    }
}

/// A line with text at both ends. The right end has precedence if there is not enough space.
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
