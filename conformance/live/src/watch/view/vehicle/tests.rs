//! Tests of the screen in several sizes.

use std::sync::LazyLock;

use proptest::prelude::*;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::{Buffer, Cell};
use ratatui::crossterm::event::KeyCode;
use ratatui::style::{Color, Modifier};
use uavspec_model::clock::Clock;
use uavspec_rules::definitions::Definitions;
use uavspec_test_support::extent;

use super::*;
use crate::watch::vehicle::playback::Playback;
use crate::watch::vehicle::tests::{after, grounded, library};

/// The state of a vehicle that can't arm.
fn with_vehicle<T>(show: impl FnOnce(&Shown<'_>) -> T) -> T {
    static DEFINITIONS: LazyLock<std::sync::Arc<Definitions>> =
        LazyLock::new(|| std::sync::Arc::clone(library().base()));
    after(&grounded(&DEFINITIONS), show)
}

fn scene<'s>(shown: &'s Shown<'s>, language: &'s str, is_coloured: bool) -> Scene<'s> {
    Scene {
        shown,
        source: "flight.ulg",
        language,
        theme: Theme { is_coloured },
        now: Clock::simulated().now(),
    }
}

/// Draws a frame after these keys were pressed.
fn frame(scene: &Scene<'_>, keys: &str, (width, height): (u16, u16)) -> Buffer {
    let playback = Playback::new(Kind::Replay, Clock::simulated());
    let mut pages = Pages::default();
    let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a terminal");
    terminal.draw(|frame| draw(frame, scene, &mut pages)).expect("it is drawn");
    for key in keys.chars() {
        let key = if key == '\n' { KeyCode::Enter } else { KeyCode::Char(key) };
        playback.press(&mut pages, key.into());
        terminal.draw(|frame| draw(frame, scene, &mut pages)).expect("it is drawn");
    }
    terminal.backend().buffer().clone()
}

fn lines(buffer: &Buffer) -> Vec<String> {
    let rows = buffer.content.chunks(usize::from(buffer.area.width).max(1));
    rows.map(|row| row.iter().map(Cell::symbol).collect::<String>().trim_end().to_owned()).collect()
}

fn drawn(keys: &str, size: (u16, u16)) -> Vec<String> {
    with_vehicle(|shown| lines(&frame(&scene(shown, "en", true), keys, size)))
}

/// The two columns of a line on a screen that is 140 columns wide.
fn halves(line: &str) -> (&str, &str) {
    let middle = line.char_indices().nth(71).map_or(line.len(), |(at, _)| at);
    (line[..middle].trim_end(), &line[middle..])
}

#[test]
fn medium_screens_show_one_column() {
    assert_eq!(
        drawn("", (80, 24)),
        [
            "flight.ulg  PX4 1.16                                                    at 0.9 s",
            "DISARMED  mode POSCTL  checks fail                   0.0 messages/s, last 0s ago",
            "FAILSAFE FLAGS  4 of 26 set",
            "Mode requirements",
            "error     No valid local position  local_position_invalid [3 modes]",
            "warning   Home position not set  home_position_invalid [2 modes]",
            "Control links",
            "warning   Ground station link lost  gcs_connection_lost",
            "Battery",
            "warning   Most severe battery warning: Low voltage  battery_warning",
            "EXTERNAL COMPONENTS  2",
            "late      Sprayer\\u{1b}[31m (registration 5), reply 0s ago, 16 requests",
            "          unanswered",
            "not ready Precision landing (registration 3), reply 0s ago",
            "          event 16777293 (component 1, number 77), log levels 6 and 4, arguments",
            "          00 ab",
            "BATTERY",
            "battery 1 18%  14.3 V  Low voltage",
            "CAN'T ARM IN THESE MODES  23",
            "Position, Manual, Altitude, Mission, Hold, Return, Acro, Offboard, Stabilized,",
            "Takeoff, Land, Follow Me, Precision Land, Orbit, VTOL Takeoff, External 1,",
            "External 2, External 3, External 4, External 5, External 6, External 7, External",
            "8: No valid global position",
            "q quit  p pause  . step  / filter  ? help  ↑↓ scroll",
        ]
    );
}

#[test]
fn wide_screens_show_two_columns() {
    let lines = drawn("", (140, 13));
    assert_eq!(lines[0], format!("{:<132}at 0.9 s", "flight.ulg  PX4 1.16"));
    let columns: Vec<(&str, &str)> = lines[2..12].iter().map(|line| halves(line)).collect();
    assert_eq!(
        columns,
        [
            ("FAILSAFE FLAGS  4 of 26 set", "BATTERY"),
            ("Mode requirements", "battery 1 18%  14.3 V  Low voltage"),
            ("error     No valid local position  local_position_invalid [3 modes]", "EXTERNAL COMPONENTS  2"),
            (
                "warning   Home position not set  home_position_invalid [2 modes]",
                "late      Sprayer\\u{1b}[31m (registration 5), reply 0s ago, 16",
            ),
            ("Control links", "          requests unanswered"),
            (
                "warning   Ground station link lost  gcs_connection_lost",
                "not ready Precision landing (registration 3), reply 0s ago",
            ),
            ("Battery", "          event 16777293 (component 1, number 77), log levels 6 and"),
            (
                "warning   Most severe battery warning: Low voltage  battery_warning",
                "          4, arguments 00 ab",
            ),
            ("CAN'T ARM IN THESE MODES  23", "FLAGS THAT AREN'T SET"),
            (
                "Position, Manual, Altitude, Mission, Hold, Return, Acro, Offboard,",
                "Mode requirements: No valid angular velocity; No valid attitude; No",
            ),
        ]
    );
}

#[test]
fn narrow_screens_show_the_errors() {
    assert_eq!(
        drawn("", (40, 8)),
        [
            "flight.ulg                      at 0.9 s",
            "PX4 1.16          0.0 msg/s, last 0s ago",
            "DISARMED  mode POSCTL  checks fail",
            "FAILSAFE FLAGS  4 of 26 set",
            "Mode requirements",
            "error     No valid local position",
            "          local_position_invalid [3",
            "q quit  p pause  . step  / filter",
        ]
    );
}

#[test]
fn filters_select_flags() {
    let shown = drawn("/home\n", (80, 40));
    let flags: Vec<&String> = shown.iter().filter(|line| line.starts_with("warning")).collect();
    assert_eq!(flags.len(), 1, "{shown:#?}");
    assert!(flags[0].contains("home_position_invalid"), "{shown:#?}");
    assert!(shown[39].ends_with("/home"), "{shown:#?}");
}

#[test]
fn labels_have_translations() {
    let text = with_vehicle(|shown| text(&scene(shown, "uk", false)));
    assert!(!text.contains("No valid local position"), "{text}");
    assert!(text.contains("local_position_invalid") && text.contains("Precision landing"), "{text}");
}

#[test]
fn colours_are_not_required() {
    with_vehicle(|shown| {
        let coloured = frame(&scene(shown, "en", true), "", (80, 24));
        let plain = frame(&scene(shown, "en", false), "", (80, 24));
        assert_eq!(lines(&plain), lines(&coloured));
        assert!(plain.content.iter().all(|cell| cell.fg == Color::Reset && cell.bg == Color::Reset));
        let is_error = |cell: &Cell| cell.fg == Color::LightRed && cell.modifier.contains(Modifier::BOLD);
        assert!(coloured.content.iter().any(is_error));
    });
}

#[test]
fn the_help_page_lists_all_keys() {
    let shown = drawn("?", (60, 40));
    assert!(shown.iter().any(|line| line.starts_with(".        show the next change")), "{shown:#?}");
}

#[test]
fn draws_at_any_size() {
    with_vehicle(|shown| {
        let scene = scene(shown, "en", true);
        let config = ProptestConfig::with_cases(extent(24, 6));
        proptest!(config, |(width in 1..200_u16, height in 1..50_u16, keys in "[jkG/? .p+a\n]{0,6}")| {
            for line in lines(&frame(&scene, &keys, (width, height))) {
                prop_assert!(!line.chars().any(char::is_control), "{line:?}");
            }
        });
    });
}
