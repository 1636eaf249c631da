//! `enum-value-out-of-range`: a constant that the field can't hold.

use super::rule::{Check, Levels, Measured, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "enum-value-out-of-range",
    purpose: "The type of a field holds each constant of its enum. One that it can't hold is cut when it is \
              assigned, and read as another.",
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
    measured: Some(Measured { findings: 0, sample: 0, right: 0, remark: "" }),
    check: Check::Reader(no_fix),
};
