//! The details of one UAV.

use ratatui::text::{Line, Span};
use uavspec_runtime::Severity;

use super::super::codes::severity_name;
use super::super::format::{
    INVALID_VALUE, MISSING_VALUE, age, coordinates, field, fixed, metres, number, volts,
};
use super::super::state::{Battery, Errors, Field, State};
use super::super::words::truncated;
use super::Scene;
use super::wrap::labelled;

/// The width of the column of field names.
const INDENT: usize = 13;

pub(super) fn lines(scene: &Scene<'_>, id: &str, width: usize) -> Vec<Line<'static>> {
    let Some(uav) = scene.fleet.get(id) else {
        return vec![Line::raw(format!("{} has left the fleet", truncated(id)))];
    };
    let mut lines = vec![Line::styled(truncated(id), scene.theme.title())];
    let received = age(scene.fleet.age(uav, scene.now));
    let mut fields = vec![(
        "reported",
        if received == MISSING_VALUE { "never".to_owned() } else { format!("{received} ago") },
    )];
    fields.extend(uav.refusal.iter().map(|reason| ("refused", reason.clone())));
    if let Some(state) = &uav.state {
        fields.extend(values(state, id));
        let others = state.others.iter().map(|(name, value)| ("", format!("{name}: {value}")));
        fields.extend(others);
    }
    for (name, value) in fields {
        lines.extend(row(name, value, width));
    }
    if let Some(state) = &uav.state {
        match &state.errors {
            Field::Known(errors) => lines.extend(describe_errors(scene, errors, width)),
            other => lines.extend(row("errors", field(other, |_| String::new()), width)),
        }
    }
    lines
}

/// A field, wrapped into lines.
fn row(name: &str, value: String, width: usize) -> Vec<Line<'static>> {
    labelled(name, value, INDENT, width)
}

fn values(state: &State, id: &str) -> Vec<(&'static str, String)> {
    let own_id = field(&state.id, |own| if *own == truncated(id) { "same".to_owned() } else { own.clone() });
    vec![
        ("own id", own_id),
        ("timestamp", number(&state.timestamp, |time| format!("{time} ms"))),
        ("mode", field(&state.mode, Clone::clone)),
        ("position", position(&state.position)),
        ("altitudes", altitudes(&state.position)),
        ("position XYZ", vector(&state.position_xyz, ["x", "y", "z"], |value| metres(value) + " m")),
        ("GPS", field(&state.gps, gps)),
        ("heading", number(&state.heading, tenths)),
        ("attitude", vector(&state.attitude, ["roll", "pitch", "yaw"], tenths)),
        ("velocity", vector(&state.velocity, ["north", "east", "down"], speed)),
        ("velocity XYZ", vector(&state.velocity_xyz, ["x", "y", "z"], speed)),
        ("battery", field(&state.battery, battery)),
        ("light", number(&state.light, light)),
        ("signal", field(&state.rssi, |values| signals(values))),
        ("debug", field(&state.debug, Clone::clone)),
    ]
}

fn position(position: &Field<[Field<i64>; 5]>) -> String {
    field(position, |_| {
        let [latitude, longitude] = coordinates(Some(position), 7);
        format!("latitude {latitude}°, longitude {longitude}°")
    })
}

fn altitudes(position: &Field<[Field<i64>; 5]>) -> String {
    field(position, |[_, _, sea, home, ground]| {
        let heights = [(sea, "mean sea level"), (home, "home"), (ground, "ground")];
        let heights =
            heights.map(|(height, reference)| format!("{} m above {reference}", number(height, metres)));
        heights.join(", ")
    })
}

fn vector(vector: &Field<[Field<i64>; 3]>, names: [&str; 3], format: fn(i64) -> String) -> String {
    field(vector, |values| {
        let parts: Vec<String> = names
            .iter()
            .zip(values)
            .map(|(name, value)| format!("{name} {}", number(value, format)))
            .collect();
        parts.join(", ")
    })
}

fn integer(value: i64) -> String {
    value.to_string()
}

fn tenths(value: i64) -> String {
    format!("{}°", fixed(value, 1, 1))
}

fn speed(value: i64) -> String {
    format!("{} m/s", metres(value))
}

fn gps([fix, satellites, horizontal, vertical]: &[Field<i64>; 4]) -> String {
    format!(
        "fix {}, {} satellites, accuracy {} m horizontal and {} m vertical",
        number(fix, integer),
        number(satellites, integer),
        number(horizontal, metres),
        number(vertical, metres),
    )
}

fn battery(battery: &Battery) -> String {
    let charge = format!("{} V, {} %", number(&battery.voltage, volts), number(&battery.percent, integer));
    match battery.is_charging {
        Field::Absent => charge,
        Field::Invalid => format!("{charge}, charging: {INVALID_VALUE}"),
        Field::Known(true) => format!("{charge}, charging"),
        Field::Known(false) => format!("{charge}, not charging"),
    }
}

/// A colour in hexadecimal notation.
fn light(colour: i64) -> String {
    let Ok(colour) = u16::try_from(colour) else { return format!("{colour} (not a colour)") };
    let widen = |value: u16, bits: u32| u32::from(value) * 255 / ((1 << bits) - 1);
    let [red, green, blue] = [widen(colour >> 11, 5), widen(colour >> 5 & 0x3F, 6), widen(colour & 0x1F, 5)];
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn signals(values: &[Field<i64>]) -> String {
    let signal = |value: i64| if value < 0 { "none".to_owned() } else { format!("{value} %") };
    let parts: Vec<String> = values.iter().map(|value| number(value, signal)).collect();
    if parts.is_empty() { MISSING_VALUE.to_owned() } else { parts.join(", ") }
}

/// Each error code with its meaning.
fn describe_errors(scene: &Scene<'_>, errors: &Errors, width: usize) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    if errors.codes.is_empty() && errors.invalid == 0 {
        lines.extend(row("errors", "none".to_owned(), width));
    }
    for code in &errors.codes {
        let severity = Severity::of(*code);
        let name = format!("{:<8}{}", severity_name(severity), scene.codes.named(*code));
        lines.push(Line::default());
        lines.push(Line::from(Span::styled(name, scene.theme.severity(severity))));
        lines.extend(labelled("", scene.codes.meaning(*code), 8, width));
    }
    if errors.invalid > 0 || errors.more > 0 {
        let text =
            format!("{INVALID_VALUE}: {} of the wrong type, {} not shown", errors.invalid, errors.more);
        lines.extend(row("errors", text, width));
    }
    lines
}
