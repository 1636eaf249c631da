//! The table of the fleet, with the columns that fit the screen.

use std::time::{Duration, Instant};

use ratatui::Frame;
use ratatui::layout::{Constraint, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Row, Table};
use uavspec_runtime::Severity;

use super::super::codes::{severity_letter, severity_name};
use super::super::fleet::{Fleet, Link, Uav};
use super::super::format::{
    INVALID_VALUE, MISSING_VALUE, age, charge, coordinates, field, first_sentence, metres, part, volts,
};
use super::super::screen::Screen;
use super::super::words::truncated;
use super::wrap::clipped;
use super::{MIDDLE_WIDTH, Scene};

/// The minimum width for the wide layout.
const WIDE_WIDTH: u16 = 130;

/// The minimum age at which a state is stale.
const STALE: Duration = Duration::from_secs(10);

/// The content of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::watch) enum Kind {
    Id,
    Mark,
    Severity,
    Mode,
    Voltage,
    Charge,
    Latitude,
    Longitude,
    AboveSea,
    AboveHome,
    AboveGround,
    Age,
    Errors,
}

impl Kind {
    /// True if the column contains numbers. Numbers are right-aligned.
    fn is_number(self) -> bool {
        !matches!(self, Self::Id | Self::Mark | Self::Severity | Self::Mode | Self::Errors)
    }
}

/// A column: its content, its title and its width.
type Column = (Kind, &'static str, u16);

/// The columns of narrow screens. The first column is as wide as the longest id, up to the given width. The last column
/// uses the remaining space.
const NARROW_COLUMNS: [Column; 6] = [
    (Kind::Id, "ID", 12),
    (Kind::Mark, "", 1),
    (Kind::Mode, "MODE", 7),
    (Kind::Charge, "BAT", 5),
    (Kind::Age, "AGE", 5),
    (Kind::Errors, "ERRORS", 0),
];

/// The columns of screens of medium width.
const MEDIUM_COLUMNS: [Column; 10] = [
    (Kind::Id, "ID", 16),
    (Kind::Mark, "", 1),
    (Kind::Mode, "MODE", 8),
    (Kind::Voltage, "VOLT", 4),
    (Kind::Charge, "BAT", 5),
    (Kind::Latitude, "LAT", 9),
    (Kind::Longitude, "LON", 10),
    (Kind::AboveHome, "AHL", 6),
    (Kind::Age, "AGE", 5),
    (Kind::Errors, "ERRORS", 0),
];

/// The columns of wide screens.
const WIDE_COLUMNS: [Column; 12] = [
    (Kind::Id, "ID", 24),
    (Kind::Severity, "SEVERITY", 8),
    (Kind::Mode, "MODE", 10),
    (Kind::Voltage, "VOLT", 4),
    (Kind::Charge, "BAT", 5),
    (Kind::Latitude, "LATITUDE", 11),
    (Kind::Longitude, "LONGITUDE", 12),
    (Kind::AboveSea, "AMSL", 7),
    (Kind::AboveHome, "AHL", 6),
    (Kind::AboveGround, "AGL", 6),
    (Kind::Age, "AGE", 5),
    (Kind::Errors, "ERRORS", 0),
];

pub(super) fn draw(
    frame: &mut Frame<'_>,
    scene: &Scene<'_>,
    screen: &Screen,
    rows: &[(&str, &Uav)],
    area: Rect,
) {
    let shown: Vec<_> = rows.iter().skip(screen.first_row).take(usize::from(area.height)).collect();
    let columns = columns(area.width, shown.iter().map(|(id, _)| *id));
    let theme = scene.theme;
    let titles = columns.iter().map(|column| aligned(Line::raw(column.1), *column));
    let lines = shown.into_iter().map(|(id, uav)| {
        let cells = columns.iter().map(|column| aligned(cell(scene, id, uav, column.0), *column));
        let style = if is_stale(scene, uav) { theme.faint() } else { Style::new() };
        let is_selected = screen.selected.as_deref() == Some(*id);
        Row::new(cells).style(if is_selected { style.patch(theme.selected()) } else { style })
    });
    let widths = columns.iter().map(|(.., width)| Constraint::Length(*width));
    let table = Table::new(lines, widths).header(Row::new(titles).style(theme.title()));
    frame.render_widget(table, area);
}

/// The columns for a screen, with their widths.
fn columns<'i>(width: u16, ids: impl Iterator<Item = &'i str>) -> Vec<Column> {
    let mut columns = match width {
        ..MIDDLE_WIDTH => NARROW_COLUMNS.to_vec(),
        MIDDLE_WIDTH..WIDE_WIDTH => MEDIUM_COLUMNS.to_vec(),
        WIDE_WIDTH.. => WIDE_COLUMNS.to_vec(),
    };
    let longest = ids.map(|id| Span::raw(truncated(id)).width()).max().unwrap_or_default();
    let longest = u16::try_from(longest).unwrap_or(u16::MAX);
    if let Some((.., first)) = columns.first_mut() {
        *first = longest.clamp(2, *first);
    }
    let gaps = u16::try_from(columns.len()).unwrap_or(u16::MAX).saturating_sub(1);
    let taken: u16 = columns.iter().map(|(.., width)| width).sum::<u16>() + gaps;
    if let Some((.., last)) = columns.last_mut() {
        *last = width.saturating_sub(taken);
    }
    columns
}

fn aligned(line: Line<'_>, (kind, _, width): Column) -> Line<'_> {
    let line = clipped(line, usize::from(width));
    if kind.is_number() { line.right_aligned() } else { line }
}

fn is_stale(scene: &Scene<'_>, uav: &Uav) -> bool {
    let age = scene.fleet.age(uav, scene.now);
    scene.fleet.link != Link::Connected || age.is_none_or(|age| age >= STALE)
}

fn cell<'c>(scene: &Scene<'_>, id: &str, uav: &Uav, kind: Kind) -> Line<'c> {
    match kind {
        Kind::Mark | Kind::Severity => severity(scene, uav, kind == Kind::Mark),
        Kind::Errors => errors(scene, uav),
        // One unit in the fifth decimal place is about one metre.
        _ => Line::raw(text(scene.fleet, (id, uav), kind, 5, scene.now)),
    }
}

/// The text of a cell. Cells with several styles are drawn separately. `decimals` applies to coordinates.
pub(in crate::watch) fn text(
    fleet: &Fleet,
    (id, uav): (&str, &Uav),
    kind: Kind,
    decimals: u32,
    now: Instant,
) -> String {
    let state = uav.state.as_ref();
    let (position, battery) = (state.map(|state| &state.position), state.map(|state| &state.battery));
    let [latitude, longitude] = coordinates(position, decimals);
    match kind {
        Kind::Id => truncated(id),
        Kind::Mode => {
            state.map_or_else(|| MISSING_VALUE.to_owned(), |state| field(&state.mode, Clone::clone))
        }
        Kind::Voltage => part(battery, |battery| &battery.voltage, volts),
        Kind::Charge => charge(battery),
        Kind::Latitude => latitude,
        Kind::Longitude => longitude,
        Kind::AboveSea => part(position, |[_, _, sea, ..]| sea, metres),
        Kind::AboveHome => part(position, |[.., home, _]| home, metres),
        Kind::AboveGround => part(position, |[.., ground]| ground, metres),
        Kind::Age => age(fleet.age(uav, now)),
        Kind::Mark | Kind::Severity | Kind::Errors => String::new(),
    }
}

/// The highest severity, as a letter or a word.
fn severity<'c>(scene: &Scene<'_>, uav: &Uav, is_letter: bool) -> Line<'c> {
    let Some(severity) = uav.worst() else { return Line::default() };
    let name = if is_letter { severity_letter(severity) } else { severity_name(severity) };
    Line::styled(name, scene.theme.severity(severity))
}

/// The abbreviated error codes of a UAV, and the meaning of the most severe one.
fn errors<'c>(scene: &Scene<'_>, uav: &Uav) -> Line<'c> {
    if let Some(reason) = &uav.refusal {
        return Line::raw(format!("refused: {reason}"));
    }
    let errors = uav.state.as_ref().map(|state| &state.errors);
    let text = field(errors.unwrap_or(&super::super::state::Field::Absent), |_| String::new());
    let mut spans = vec![Span::raw(text)];
    for (number, code) in uav.codes().iter().enumerate() {
        if number > 0 {
            spans.push(Span::raw(", "));
        }
        spans.push(Span::styled(scene.codes.short(*code), scene.theme.severity(Severity::of(*code))));
    }
    if errors.and_then(|errors| errors.known()).is_some_and(|errors| errors.invalid > 0) {
        spans.push(Span::raw(format!(" {INVALID_VALUE}")));
    }
    if let Some(code) = uav.codes().first() {
        let meaning = format!(" – {}", first_sentence(scene.codes.meaning(*code)));
        spans.push(Span::styled(meaning, scene.theme.faint()));
    }
    Line::from(spans)
}

/// An error code with its severity and meaning, on one line.
pub(super) fn describe_code<'l>(scene: &Scene<'_>, code: u32) -> Line<'l> {
    let severity = Severity::of(code);
    let name = Span::styled(
        format!("{:<7} {}", severity_name(severity), scene.codes.named(code)),
        scene.theme.severity(severity),
    );
    Line::from(vec![name, Span::raw(format!(": {}", first_sentence(scene.codes.meaning(code))))])
}
