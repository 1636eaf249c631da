//! Tests of the screen in several sizes.

use std::sync::LazyLock;
use std::time::Duration;

use proptest::prelude::*;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::{Buffer, Cell};
use ratatui::crossterm::event::KeyCode;
use ratatui::style::{Color, Modifier};
use uavspec_model::clock::Clock;
use uavspec_rules::definitions::Definitions;
use uavspec_test_support::extent;

use super::super::message::Message;
use super::super::session::Event;
use super::*;

static CODES: LazyLock<Codes> = LazyLock::new(|| Codes::new(&Definitions::built_in()));

const FLEET: &str = r#"{"body": {"type": "UAV-INF", "status": {
    "glider-1": {"id": "glider-1", "timestamp": 60000, "mode": "loiter", "errors": [],
        "position": [504980000, 99520000, 905000, 12340, 12340], "battery": [126, 98, true]},
    "glider-2": {"id": "kite", "timestamp": 59000, "mode": 7, "errors": [1, 66, 193, "x"],
        "position": [504980424, "east"], "battery": [0, -1], "light": 63488, "rssi": [80, -1], "wind": [3],
        "gps": [4, 14, 900], "heading": 450, "attitude": [-2, 0, 3599], "velocity": [0, -1500, null]},
    "glider-10": {"id": "glider-10", "timestamp": 10000, "mode": "\u001b[31mred", "errors": [190, 12, 40000],
        "position": [-1, -1799999999, null, null, 1500], "battery": [101, 7]}
}}}"#;

/// A drawn frame: the characters with their style.
struct Picture {
    buffer: Buffer,
}

impl Picture {
    fn lines(&self) -> Vec<String> {
        let width = usize::from(self.buffer.area.width).max(1);
        let rows = self.buffer.content.chunks(width);
        rows.map(|row| row.iter().map(Cell::symbol).collect::<String>().trim_end().to_owned()).collect()
    }

    /// The colour and the modifiers at the start of a text.
    fn style_of(&self, text: &str) -> (Color, Modifier) {
        let lines = self.lines();
        let (row, line) =
            lines.iter().enumerate().find(|(_, line)| line.contains(text)).expect("the text is visible");
        let column = line.find(text).map(|at| line[..at].chars().count()).expect("the text is visible");
        let cell = &self.buffer[(u16::try_from(column).expect("narrow"), u16::try_from(row).expect("low"))];
        (cell.fg, cell.modifier)
    }

    fn has(&self, text: &str) -> bool {
        self.lines().iter().any(|line| line.contains(text))
    }
}

struct Watched {
    fleet: Fleet,
    codes: Codes,
    start: Instant,
    screen: Screen,
}

impl Watched {
    fn new() -> Self {
        let mut watched = Self::empty();
        watched.receive(r#"{"type": "SYS-VER", "software": "sky", "version": "2.10"}"#);
        watched.receive(r#"{"type": "SYS-TIME", "timestamp": 60000}"#);
        watched.receive(FLEET);
        watched
    }

    fn empty() -> Self {
        let codes = CODES.clone();
        Self { fleet: Fleet::default(), codes, start: Clock::simulated().now(), screen: Screen::default() }
    }

    fn receive(&mut self, text: &str) {
        self.fleet.take(Event::Received(Message::read(text.as_bytes())), self.start);
    }

    fn press(&mut self, keys: &[KeyCode]) {
        for key in keys {
            self.screen.press((*key).into(), &self.fleet);
        }
    }

    fn draw(&mut self, width: u16, height: u16, is_coloured: bool, seconds: u64) -> Picture {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a terminal");
        let now = self.start + Duration::from_secs(seconds);
        let scene = Scene {
            fleet: &self.fleet,
            codes: &self.codes,
            url: "tcp://hill:5001",
            theme: Theme { is_coloured },
            now,
        };
        terminal.draw(|frame| draw(frame, &scene, &mut self.screen)).expect("it is drawn");
        Picture { buffer: terminal.backend().buffer().clone() }
    }

    fn lines(&mut self, width: u16, height: u16) -> Vec<String> {
        self.draw(width, height, true, 2).lines()
    }
}

#[test]
fn narrow_screens_show_the_most_important_columns() {
    let lines = Watched::new().lines(40, 16);
    assert_eq!(
        lines,
        [
            "tcp://hill:5001                connected",
            "sky 2.10                       1.5 msg/s",
            "3 UAVs  1 F  1 E  0 W  0 i",
            "ID          MODE      BAT   AGE ERRORS",
            "glider-1    loiter   98%+    2s",
            "glider-2  F ?           -    3s MAG, LO…",
            "glider-10 E \\u{1b}…    7%   52s SENSOR,…",
            "",
            "",
            "",
            "",
            "glider-1",
            "",
            "",
            "",
            "q quit  s sort: id  / filter  ? help",
        ]
    );
}

#[test]
fn medium_screens_show_positions() {
    let mut watched = Watched::new();
    watched.draw(80, 16, true, 2);
    watched.press(&[KeyCode::Down]);
    assert_eq!(
        watched.lines(80, 16),
        [
            "tcp://hill:5001  sky 2.10                                              connected",
            "3 UAVs  1 fatal  1 error  0 warning  0 info                       1.5 messages/s",
            "ID          MODE     VOLT   BAT       LAT        LON    AHL   AGE ERRORS",
            "glider-1    loiter   12.6  98%+  50.49800    9.95200   12.3    2s",
            "glider-2  F ?           -     -  50.49804          ?      -    3s MAG, LOWBAT, …",
            "glider-10 E \\u{1b}[… 10.1    7%   0.00000 -180.00000      -   52s SENSOR, 40000…",
            "",
            "",
            "",
            "",
            "",
            "glider-2",
            "fatal   193 MAG: Magnetometer fault",
            "warning 66 LOWBAT: Battery charge is low",
            "info    1 GROUND: The UAV is on the ground",
            "q quit  s sort: id  / filter  ? help  Enter details  ↑↓ move",
        ]
    );
}

#[test]
fn wide_screens_show_all_columns_and_the_meaning_of_errors() {
    let lines = Watched::new().lines(140, 8);
    assert_eq!(
        lines,
        [
            format!("{:<131}{}", "tcp://hill:5001  sky 2.10", "connected"),
            format!("{:<126}{}", "3 UAVs  1 fatal  1 error  0 warning  0 info", "1.5 messages/s"),
            "ID        SEVERITY MODE       VOLT   BAT    LATITUDE    LONGITUDE    AMSL    AHL    AGL   AGE ERRORS"
                .to_owned(),
            "glider-1           loiter     12.6  98%+    50.49800      9.95200   905.0   12.3   12.3    2s".to_owned(),
            "glider-2  fatal    ?             -     -    50.49804            ?       -      -      -    3s MAG, LOWBAT, \
             GROUND ? – Magnetometer fault"
                .to_owned(),
            "glider-10 error    \\u{1b}[31… 10.1    7%     0.00000   -180.00000       -      -    1.5   52s SENSOR, 40000, \
             12 – Any sensor failure withou…"
                .to_owned(),
            String::new(),
            "q quit  s sort: id  / filter  ? help  Enter details  ↑↓ move".to_owned(),
        ]
    );
}

#[test]
fn shows_all_details_of_a_uav() {
    let mut watched = Watched::new();
    watched.draw(80, 40, true, 2);
    watched.press(&[KeyCode::Down, KeyCode::Enter]);
    let lines = watched.lines(80, 40);
    for line in [
        "glider-2",
        "reported     3s ago",
        "own id       kite",
        "timestamp    59000 ms",
        "mode         ?",
        "position     latitude 50.4980424°, longitude ?°",
        "altitudes    - m above mean sea level, - m above home, - m above ground",
        "position XYZ -",
        "GPS          fix 4, 14 satellites, accuracy 0.9 m horizontal and - m vertical",
        "heading      45.0°",
        "attitude     roll -0.2°, pitch 0.0°, yaw 359.9°",
        "velocity     north 0.0 m/s, east -1.5 m/s, down -",
        "battery      - V, - %",
        "light        #ff0000",
        "signal       80 %, none",
        "             wind: an array of 1",
        "fatal   193 MAG",
        "        Magnetometer fault.",
        "info    1 GROUND",
        "errors       ?: 1 of the wrong type, 0 not shown",
        "q quit  Esc back  ↑↓ scroll  ? help",
    ] {
        assert!(lines.iter().any(|shown| shown == line), "{line}\n{}", lines.join("\n"));
    }
    watched.press(&[KeyCode::PageDown, KeyCode::PageDown, KeyCode::PageDown]);
    let end = watched.lines(40, 12);
    assert_eq!(end[10], "             not shown", "{}", end.join("\n"));
    watched.receive(r#"{"type": "OBJ-DEL", "ids": ["glider-2"]}"#);
    assert!(watched.draw(80, 40, true, 2).has("glider-2 has left the fleet"));
}

#[test]
fn colours_show_the_severity_but_are_not_required() {
    let mut watched = Watched::new();
    let picture = watched.draw(80, 10, true, 2);
    assert_eq!(picture.style_of("MAG"), (Color::LightRed, Modifier::BOLD | Modifier::UNDERLINED));
    assert_eq!(picture.style_of("LOWBAT").0, Color::Yellow);
    assert_eq!(picture.style_of("connected").0, Color::Green);
    assert!(picture.style_of("glider-1 ").1.contains(Modifier::REVERSED));
    assert!(picture.style_of("glider-10").1.contains(Modifier::DIM), "its state is stale");
    let plain = watched.draw(80, 10, false, 2);
    assert_eq!(plain.lines(), picture.lines());
    assert!(plain.buffer.content.iter().all(|cell| cell.fg == Color::Reset && cell.bg == Color::Reset));
}

#[test]
fn shows_server_errors_and_keeps_known_states() {
    let mut watched = Watched::empty();
    let picture = watched.draw(80, 10, true, 0);
    assert!(picture.has("connecting") && picture.has("no UAVs yet"));
    watched.receive(FLEET);
    watched.receive("glider");
    watched.receive(r#"{"type": "ACK-NAK", "reason": "log in\u0007 first"}"#);
    let reason = "reset\u{1b}[0m by peer".to_owned();
    watched.fleet.take(Event::Lost { reason, pause: Duration::from_secs(4) }, watched.start);
    let picture = watched.draw(80, 12, true, 1);
    for text in [
        "lost, retry in 3 s",
        "reset\\u{1b}[0m by peer",
        "the server refused a request: log in\\u{7} first",
        "1 unreadable message",
        "glider-1",
    ] {
        assert!(picture.has(text), "{text}\n{}", picture.lines().join("\n"));
    }
    assert!(picture.style_of("glider-1").1.contains(Modifier::DIM | Modifier::REVERSED));
    assert!(picture.style_of("glider-2").1.contains(Modifier::DIM));
    assert!(watched.draw(80, 12, true, 4).has("lost, reconnecting"));
    watched.press(&[KeyCode::Char('/'), KeyCode::Char('x')]);
    let picture = watched.draw(80, 12, true, 1);
    assert!(picture.has("no id contains this text") && picture.has("/x_"));
}

#[test]
fn shows_a_page_of_all_keys() {
    let mut watched = Watched::new();
    watched.press(&[KeyCode::Char('?')]);
    let lines = watched.lines(40, 40);
    assert!(lines.iter().any(|line| line.starts_with("q        quit; also Esc and Ctrl-C")), "{lines:?}");
    watched.press(&[KeyCode::End]);
    let end = watched.lines(40, 12);
    assert!(end[10].ends_with("codes."), "{end:?}");
    assert!(lines.iter().any(|line| line == "q quit  Esc back  ↑↓ scroll"), "{lines:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(extent(64, 20)))]

    #[test]
    fn draws_any_state_at_any_size(
        width in 1..200_u16,
        height in 1..50_u16,
        keys in "[jks/?\n]{0,4}",
        id in ".{0,80}",
        mode in ".{0,80}",
    ) {
        let mut watched = Watched::new();
        let state = serde_json::json!({ "mode": mode, "errors": [1, 255, 70_000, -1] });
        watched.receive(&serde_json::json!({ "type": "UAV-INF", "status": { id: state } }).to_string());
        watched.draw(width, height, true, 0);
        for key in keys.chars() {
            watched.press(&[if key == '\n' { KeyCode::Enter } else { KeyCode::Char(key) }]);
            let picture = watched.draw(width, height, true, 0);
            let is_harmless = |line: &String| !line.chars().any(char::is_control);
            prop_assert!(picture.lines().iter().all(is_harmless));
        }
    }
}
