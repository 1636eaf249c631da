//! The target for datagrams and other messages from a server that `watch` reads.

use std::sync::LazyLock;
use std::time::Duration;

use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::KeyCode;
use serde_json::{Value, json};
use uavspec_live::watch::codes::Codes;
use uavspec_live::watch::fleet::Fleet;
use uavspec_live::watch::message::Message;
use uavspec_live::watch::screen::Screen;
use uavspec_live::watch::session::Event;
use uavspec_live::watch::view::{Scene, Theme, draw};
use uavspec_model::clock::Clock;
use uavspec_rules::flockwave::sample::Session;

use super::DEFINITIONS;

/// The byte that separates messages. It never occurs in UTF-8.
const SEPARATOR: u8 = 0xff;

/// The meanings of error codes.
static CODES: LazyLock<Codes> = LazyLock::new(|| Codes::new(&DEFINITIONS));

/// Applies messages to a fleet, and draws each page. No cell may contain a control character.
pub(super) fn datagrams(data: &[u8]) {
    let now = Clock::simulated().now();
    let mut fleet = Fleet::default();
    for message in data.split(|byte| *byte == SEPARATOR) {
        fleet.take(Event::Received(Message::read(message)), now);
    }
    let mut screen = Screen::default();
    for key in [KeyCode::Down, KeyCode::Enter, KeyCode::Esc] {
        screen.press(key.into(), &fleet);
        let Ok(mut terminal) = Terminal::new(TestBackend::new(80, 24));
        let now = now + Duration::from_secs(1);
        let theme = Theme { is_coloured: true };
        let scene = Scene { fleet: &fleet, codes: &CODES, url: "udp://hill:5001", theme, now };
        let Ok(_) = terminal.draw(|frame| draw(frame, &scene, &mut screen));
        for cell in &terminal.backend().buffer().content {
            assert!(!cell.symbol().contains(char::is_control), "{:?}", cell.symbol());
        }
    }
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let session = Session::new();
    let from_server = session.lines.iter().filter(|line| line["dir"] == "in").map(|line| &line["msg"]);
    let mut seeds: Vec<Vec<u8>> = from_server
        .filter(|message| !message.is_null())
        .map(|message| message.to_string().into_bytes())
        .collect();
    let closing = |body: Value| json!({ "$fw.version": "1.0", "id": "1", "body": body }).to_string();
    let parts = [
        closing(json!({ "type": "UAV-LIST", "ids": ["glider-1", "glider-2"] })),
        closing(json!({ "type": "OBJ-DEL", "ids": ["glider-1"] })),
        closing(json!({ "type": "SYS-CLOSE", "reason": "wind" })),
    ];
    seeds.push(parts.map(String::into_bytes).join(&SEPARATOR));
    seeds
}
