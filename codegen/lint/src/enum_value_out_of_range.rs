//! `enum-value-out-of-range`: a constant that doesn't fit into the field.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Measured, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "enum-value-out-of-range",
    statement: "An enum constant whose value doesn't fit into the field.",
    why: "The value is truncated when it is assigned, and readers see a different value.",
    fix: "Use a wider type for the field, or a smaller value.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint16 GEAR_UP = 0      # Retracted\nuint16 GEAR_DOWN = 256  # Extended\n\n\
               uint8 gear  # [@enum GEAR] Landing gear\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint16 GEAR_UP = 0      # Retracted\nuint16 GEAR_DOWN = 256  # Extended\n\n\
               uint16 gear  # [@enum GEAR] Landing gear\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Reader(no_fix),
};
