//! The fleet as a table for scripts: one line per UAV, columns separated by at least two spaces, no colours.

use std::fmt::Write as _;
use std::time::Instant;

use ratatui::text::Span;

use super::codes::{Codes, severity_name};
use super::fleet::{Fleet, Uav};
use super::format::{MISSING_VALUE, field};
use super::order::Order;
use super::view::table::{Kind, text};

/// The columns with their titles.
const COLUMNS: [(Kind, &str); 11] = [
    (Kind::Id, "ID"),
    (Kind::Severity, "SEVERITY"),
    (Kind::Mode, "MODE"),
    (Kind::Voltage, "VOLT"),
    (Kind::Charge, "CHARGE"),
    (Kind::Latitude, "LATITUDE"),
    (Kind::Longitude, "LONGITUDE"),
    (Kind::AboveSea, "AMSL"),
    (Kind::AboveHome, "AHL"),
    (Kind::AboveGround, "AGL"),
    (Kind::Age, "AGE"),
];

/// Renders the table.
pub fn table(fleet: &Fleet, codes: &Codes, now: Instant) -> String {
    let mut uavs: Vec<(&str, &Uav)> = fleet.uavs().collect();
    uavs.sort_by(|one, other| Order::Id.compare(*one, *other));
    let mut rows = vec![(COLUMNS.map(|(_, title)| title.to_owned()), "ERRORS".to_owned())];
    rows.extend(uavs.into_iter().map(|(id, uav)| {
        let cells = COLUMNS.map(|(kind, _)| match kind {
            Kind::Severity => uav.worst().map_or(MISSING_VALUE, severity_name).to_owned(),
            _ => text(fleet, (id, uav), kind, 7, now),
        });
        (cells, errors(uav, codes))
    }));
    let widths: [usize; 11] =
        std::array::from_fn(|at| rows.iter().map(|(cells, _)| width(&cells[at])).max().unwrap_or_default());
    let mut table = String::new();
    for (cells, errors) in &rows {
        for (cell, column) in cells.iter().zip(widths) {
            // `format!` pads to a number of characters, not to a display width.
            let space = column - width(cell) + 2;
            let _ = write!(table, "{cell}{:space$}", "");
        }
        let _ = writeln!(table, "{errors}");
    }
    table
}

fn width(text: &str) -> usize {
    Span::raw(text).width()
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
