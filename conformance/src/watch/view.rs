//! The screen: what is known, drawn into a frame. Nothing is changed here but where the screen is scrolled to.

mod details;
mod foot;
mod head;
mod table;
mod theme;
mod wrap;

use std::time::Instant;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::{Line, Span};

use self::theme::Theme;
use super::codes::Codes;
use super::fleet::{Fleet, Uav};
use super::screen::{Page, Screen};

/// What is drawn.
#[derive(Debug)]
pub(crate) struct Scene<'s> {
    /// The fleet.
    pub fleet: &'s Fleet,
    /// What its error codes mean.
    pub codes: &'s Codes,
    /// Where the server is.
    pub url: &'s str,
    /// Whether there may be colours. Without them, what they say is in words and in bold.
    pub is_coloured: bool,
    /// When it is drawn.
    pub now: Instant,
}

impl Scene<'_> {
    fn theme(&self) -> Theme {
        Theme { is_coloured: self.is_coloured }
    }
}

/// From how many columns on there is room for more than the most needed.
const MIDDLE_WIDTH: u16 = 80;

/// How high the screen has to be for the error codes of the UAV that is looked at to be told below the others.
const NOTED_HEIGHT: u16 = 16;

/// Draws the screen.
pub(crate) fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>, screen: &mut Screen) {
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

/// Draws as many lines as there is room for, from the one on that the screen is scrolled to.
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
    // One line is for the titles.
    let selected = screen.settle(&rows, usize::from(rest.height.saturating_sub(1)));
    if rows.is_empty() {
        let is_filtered = !scene.fleet.is_empty();
        let text = if is_filtered { "no id has this in it" } else { "no UAV is known yet" };
        frame.render_widget(Line::styled(text, scene.theme().faint()), rest);
        return;
    }
    table::draw(frame, scene, screen, &rows, rest);
    if let Some((id, uav)) = selected.and_then(|row| rows.get(row)) {
        draw_note(frame, scene, id, uav, below);
    }
}

/// The gravest error codes of a UAV, with what they mean.
fn draw_note(frame: &mut Frame<'_>, scene: &Scene<'_>, id: &str, uav: &Uav, area: Rect) {
    let mut lines = vec![Line::styled(super::words::shown_id(id), scene.theme().title())];
    lines.extend(uav.refusal.iter().map(|reason| Line::raw(format!("the server doesn't tell: {reason}"))));
    lines.extend(uav.codes().iter().map(|code| table::describe_code(scene, *code)));
    for (line, row) in lines.into_iter().zip(area.rows()) {
        frame.render_widget(wrap::clipped(line, usize::from(row.width)), row);
    }
}

/// A line of the screen: something at its left end, and something that is more needed at its right end.
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

/// Spans, two spaces between them.
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
