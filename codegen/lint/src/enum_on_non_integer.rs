//! `enum-on-non-integer`: an enum on a field that isn't an integer.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Measured, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "enum-on-non-integer",
    statement: "An enum annotation on a field or constant that isn't an integer.",
    why: "The annotation has no effect, so values are not checked and have no names.",
    fix: "Use an integer type for the field and the constants.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 GEAR_UP = 0    # Retracted\nuint8 GEAR_DOWN = 1  # Extended\n\n\
               float32 gear  # [@enum GEAR] Landing gear\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 GEAR_UP = 0    # Retracted\nuint8 GEAR_DOWN = 1  # Extended\n\n\
               uint8 gear  # [@enum GEAR] Landing gear\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Reader(no_fix),
};
