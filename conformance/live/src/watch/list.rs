//! The fleet as a table for scripts: one line per UAV, columns separated by at least two spaces, no colours.

use std::fmt::Write as _;
use std::time::Instant;

use ratatui::text::Span;

use super::codes::{Codes, severity_name};
use super::fleet::{Fleet, Uav};
use super::format::{MISSING_VALUE, age, charge, coordinates, field, metres, part, volts};
use super::order::Order;
use super::words::shown_id;

const TITLES: [&str; 11] =
    ["ID", "SEVERITY", "MODE", "VOLT", "CHARGE", "LATITUDE", "LONGITUDE", "AMSL", "AHL", "AGL", "AGE"];

/// Renders the table.
pub fn table(fleet: &Fleet, codes: &Codes, now: Instant) -> String {
    let mut uavs: Vec<(&str, &Uav)> = fleet.uavs().collect();
    uavs.sort_by(|one, other| Order::Id.compare(*one, *other));
    let rows: Vec<([String; 11], String)> =
        uavs.iter().map(|(id, uav)| (cells(fleet, id, uav, now), errors(uav, codes))).collect();
    let mut widths = TITLES.map(str::len);
    for (cells, _) in &rows {
        for (width, cell) in widths.iter_mut().zip(cells) {
            *width = (*width).max(Span::raw(cell).width());
        }
    }
    let mut table = line(&TITLES, &widths, "ERRORS");
    for (cells, errors) in &rows {
        table.push_str(&line(&cells.each_ref().map(String::as_str), &widths, errors));
    }
    table
}

fn line(cells: &[&str; 11], widths: &[usize; 11], last: &str) -> String {
    let mut line = String::new();
    for (cell, width) in cells.iter().zip(widths) {
        // `format!` pads by characters, not by display width.
        let space = width.saturating_sub(Span::raw(*cell).width()) + 2;
        let _ = write!(line, "{cell}{:space$}", "");
    }
    line.push_str(last);
    line.push('\n');
    line
}

fn cells(fleet: &Fleet, id: &str, uav: &Uav, now: Instant) -> [String; 11] {
    let state = uav.state.as_ref();
    let position = state.map(|state| &state.position);
    let battery = state.map(|state| &state.battery);
    let [latitude, longitude] = coordinates(position, 7);
    let mode = state.map_or_else(|| MISSING_VALUE.to_owned(), |state| field(&state.mode, Clone::clone));
    [
        shown_id(id),
        uav.worst().map_or(MISSING_VALUE, severity_name).to_owned(),
        mode,
        part(battery, |battery| &battery.voltage, volts),
        charge(battery),
        latitude,
        longitude,
        part(position, |position| &position.above_sea, metres),
        part(position, |position| &position.above_home, metres),
        part(position, |position| &position.above_ground, metres),
        age(fleet.age(uav, now)),
    ]
}

fn errors(uav: &Uav, codes: &Codes) -> String {
    if let Some(reason) = &uav.refusal {
        return format!("refused: {reason}");
    }
    let Some(state) = &uav.state else { return MISSING_VALUE.to_owned() };
    field(&state.errors, |errors| {
        let mut names: Vec<String> = errors.codes.iter().map(|code| codes.named(*code)).collect();
        names.extend((errors.invalid > 0).then(|| format!("{} of the wrong type", errors.invalid)));
        names.extend((errors.more > 0).then(|| format!("{} more", errors.more)));
        if names.is_empty() { MISSING_VALUE.to_owned() } else { names.join(", ") }
    })
}

#[cfg(test)]
mod tests {
    use uavspec_model::clock::Clock;
    use uavspec_rules::definitions::Definitions;

    use super::super::message::Message;
    use super::super::session::Event;
    use super::*;

    #[test]
    fn aligns_the_columns() {
        let now = Clock::simulated().now();
        let mut fleet = Fleet::default();
        let text = r#"{"type": "UAV-INF", "status": {
            "glider-10": {"mode": "loiter", "battery": [116, 42, true], "errors": [66, 193, "x"],
                          "position": [504980000, -99520000, 905000, null, 1500]},
            "glider-2": {"mode": 7, "battery": {}},
            "kite\u001b[2J": {}
        }}"#;
        fleet.take(Event::Received(Message::read(text.as_bytes())), now);
        let expected = "\
ID             SEVERITY  MODE    VOLT  CHARGE  LATITUDE    LONGITUDE   AMSL   AHL  AGL  AGE  ERRORS
glider-2       -         ?       ?     ?       -           -           -      -    -    0s   -
glider-10      fatal     loiter  11.6  42%+    50.4980000  -9.9520000  905.0  -    1.5  0s   193 MAG, 66 LOWBAT, 1 of the wrong type
kite\\u{1b}[2J  -         -       -     -       -           -           -      -    -    0s   -
";
        assert_eq!(table(&fleet, &Codes::new(&Definitions::built_in()), now), expected);
    }
}
