//! `unit-unlisted`: a unit that PX4's documentation standard doesn't list.

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::{Subject, annotations};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::msg::statement::Statement;
use crate::unit;

pub(super) const RULE: Rule = Rule {
    id: "unit-unlisted",
    purpose: "PX4's own checker knows a short list of units, and warns of every other, real ones too. What it \
              warns of is told here, for definitions that are to pass it; the preset `strict` asks for units \
              that exist, and leaves this out.",
    levels: Levels { px4: Some(Level::Note), strict: None },
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 load      # [N] Force on the wings\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 load      # [m/s^2] Acceleration along the mast\n",
    },
    measured: Some(Measured {
        findings: 38,
        sample: 30,
        right: 3,
        remark: "`norm`, where `-` is meant; the others are real units that PX4's list lacks",
    }),
    check: Check::Message(check),
};

/// The units that the checker knows (`Tools/msg/generate_msg_docs.py` of PX4).
const LISTED: [&str; 27] = [
    "m", "m/s", "m/s^2", "(m/s)^2", "deg", "deg/s", "rad", "rad/s", "rad^2", "rpm", "V", "A", "mA", "mAh",
    "W", "dBm", "h", "s", "ms", "us", "Ohm", "MB", "Kb/s", "degC", "Pa", "%", "-",
];

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !subject.is_px4_message() {
        return;
    }
    for annotation in subject.part.lines.iter().flat_map(annotations) {
        let Statement::Unit(symbol) = annotation.statement else { continue };
        // Of one that nobody knows `unknown-unit` tells.
        if unit::lookup(symbol).is_some() && !LISTED.contains(&symbol) {
            sink.report(
                annotation.span,
                format!("PX4's documentation standard doesn't list the unit `{symbol}`"),
                "have it added to the list of PX4's checker, or choose one of the list",
            );
        }
    }
}
