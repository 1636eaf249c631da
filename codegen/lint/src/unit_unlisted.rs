//! `unit-unlisted`: a unit that PX4's documentation checker doesn't know.

use uavspec_schema::msg::statement::Statement;
use uavspec_schema::unit;

use super::prelude::*;
use super::subject::annotations;

pub(super) const RULE: Rule = Rule {
    id: "unit-unlisted",
    statement: "A unit that is not in the list of PX4's documentation checker.",
    why: "PX4's checker has a short list of units and warns about all others, including valid ones. \
        The `strict` preset does not include this rule.",
    fix: "Choose a unit from the list, or ask PX4 to add the unit to its checker.",
    levels: Levels { px4: Some(Level::Note), strict: None },
    bad: glider!["float32 load      # [N] Force on the wings"],
    good: glider!["float32 load      # [m/s^2] Acceleration along the mast"],
    measured: Some(Measured { findings: 38, sample: 30, right: 3 }),
    check: Check::Message(Scope::Px4Messages, check),
};

/// The units in PX4's checker, `Tools/msg/generate_msg_docs.py`.
const LISTED: [&str; 27] = [
    "m", "m/s", "m/s^2", "(m/s)^2", "deg", "deg/s", "rad", "rad/s", "rad^2", "rpm", "V", "A", "mA", "mAh",
    "W", "dBm", "h", "s", "ms", "us", "Ohm", "MB", "Kb/s", "degC", "Pa", "%", "-",
];

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    for annotation in subject.part.lines.iter().flat_map(annotations) {
        let Statement::Unit(symbol) = annotation.statement else { continue };
        // `unknown-unit` reports unknown units.
        if unit::lookup(symbol).is_some() && !LISTED.contains(&symbol) {
            sink.report(
                annotation.span,
                format!("PX4's documentation checker doesn't list the unit `{symbol}`"),
                "choose a unit from the checker's list, or ask PX4 to add the unit",
            );
        }
    }
}
