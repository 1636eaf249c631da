//! `enum-alias`: two constants with the same value.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;

pub(super) const RULE: Rule = Rule {
    id: "enum-alias",
    statement: "Two constants of one enum that have the same value.",
    why: "Tools can show only the first name, and one of the two values may be a mistake.",
    fix: "Give each constant a unique value, or remove one of them.",
    levels: Levels::both(Level::Note),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 GEAR_UP = 0      # Retracted\nuint8 GEAR_DOWN = 1    # Extended\n\
               uint8 GEAR_MOVING = 1  # Moving\n\nuint8 gear  # [@enum GEAR] Landing gear\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 GEAR_UP = 0      # Retracted\nuint8 GEAR_DOWN = 1    # Extended\n\
               uint8 GEAR_MOVING = 2  # Moving\n\nuint8 gear  # [@enum GEAR] Landing gear\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Message(check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let constants = &subject.message.constants;
    let mut reported = BTreeSet::new();
    for found in &subject.message.enums {
        let mut first = BTreeMap::new();
        for member in &found.members {
            let Some(known) = first.get(&member.value) else {
                first.insert(member.value, member.constant);
                continue;
            };
            // Two fields of different types result in two enums.
            if reported.insert(member.constant) {
                let (constant, known) = (&constants[member.constant], &constants[*known]);
                sink.report(
                    constant.span,
                    format!("`{}` has the same value as `{}`", constant.name, known.name),
                    "give it a different value, or remove it",
                )
                .relate(known.span, "first constant with this value");
            }
        }
    }
}
