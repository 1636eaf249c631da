//! Draws the screen of a vehicle, or prints it as text.

mod head;
mod sections;

use std::time::Instant;

use ratatui::Frame;
use ratatui::text::Line;
use uavspec_check::timeline::Refused;
use uavspec_model::text::shown;

use super::theme::Theme;
use super::{GAP, draw_columns, draw_frame, foot};
use crate::watch::screen::{Page, Pages};
use crate::watch::vehicle::playback::{Kind, Shown};

/// The minimum width for arranging the sections in two columns.
const WIDE: u16 = 120;

/// The width of the text for scripts.
const TEXT_WIDTH: u16 = 100;

/// The keys, and explanations of words on the screen.
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
         explain a refusal are shown as numbers: ground stations know their texts.",
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
    /// The styles.
    pub theme: Theme,
    /// The time of drawing.
    pub now: Instant,
}

/// Draws the screen.
pub fn draw(frame: &mut Frame<'_>, scene: &Scene<'_>, pages: &mut Pages) {
    let width = frame.area().width;
    let pause = ("p", if scene.shown.state.is_paused { "continue" } else { "pause" });
    let keys = [
        ("q", "quit"),
        pause,
        (".", "step"),
        ("/", "filter"),
        ("?", "help"),
        ("↑↓", "scroll"),
        ("+-", "speed"),
    ];
    let keys = if scene.shown.kind == Kind::Replay { &keys[..] } else { &keys[..6] };
    let foot = foot::line(pages, keys, scene.theme, width);
    let middle = draw_frame(frame, head::lines(scene, width), foot);
    let columns = if pages.page == Page::Help {
        vec![foot::help(&KEYS, width)]
    } else {
        columns(scene, &pages.filter, width)
    };
    draw_columns(frame, columns, pages, middle);
}

/// The sections, arranged in one or two columns.
fn columns(scene: &Scene<'_>, filter: &str, width: u16) -> Vec<Vec<Line<'static>>> {
    let is_wide = width >= WIDE;
    let width = usize::from(if is_wide { (width - GAP) / 2 } else { width });
    let (set, clear) =
        (sections::set_flags(scene, filter, width), sections::clear_flags(scene, filter, width));
    let (modes, batteries) = (sections::modes(scene, width), sections::batteries(scene, width));
    let (refusals, components) = (sections::refusals(scene, width), sections::components(scene, width));
    if is_wide {
        vec![[set, refusals, modes].concat(), [batteries, components, clear].concat()]
    } else {
        vec![[set, components, batteries, refusals, modes, clear].concat()]
    }
}

/// The state as text.
pub fn text(scene: &Scene<'_>) -> String {
    let head = head::lines(scene, TEXT_WIDTH).into_iter().map(|line| {
        let joined = format!("{}  {}", line.left, line.right);
        joined.trim_end().to_owned() + "\n"
    });
    let lines = columns(scene, "", TEXT_WIDTH).concat();
    head.chain(lines.into_iter().map(|line| line.to_string().trim_end().to_owned() + "\n")).collect()
}

/// The reasons why the vehicle can't arm in a mode, or in any mode if `mode` is `None`. Returns `None` before the first
/// report.
pub fn why_not_arm(scene: &Scene<'_>, mode: Option<&str>) -> Option<String> {
    let refused = scene.shown.vehicle.refused.as_deref()?;
    let is_asked = |refused: &&Refused| mode.is_none_or(|mode| refused.mode.is_named(mode));
    let texts = sections::refused_texts(scene, refused.iter().filter(is_asked));
    let answer = match (&texts[..], mode) {
        ([], None) => "The vehicle can arm in all modes.".to_owned(),
        ([], Some(mode)) => format!("The vehicle can arm in {}.", shown(mode)),
        _ => texts.join("\n"),
    };
    let origin = scene.shown.vehicle.metadata.origin.to_string();
    Some(format!("{answer}\nEvents explained by {}.\n", shown(&origin)))
}

#[cfg(test)]
mod tests;
