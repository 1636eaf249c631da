//! `unknown-enum`: an enum prefix without constants.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Measured, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "unknown-enum",
    statement: "An enum prefix that matches no constant of the message.",
    why: "The field stays a plain number, and its values have no names.",
    fix: "Correct the prefix, or define the constants.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 GEAR_UP = 0    # Retracted\nuint8 GEAR_DOWN = 1  # Extended\n\n\
               uint8 gear  # [@enum GEARS] Landing gear\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 GEAR_UP = 0    # Retracted\nuint8 GEAR_DOWN = 1  # Extended\n\n\
               uint8 gear  # [@enum GEAR] Landing gear\n",
    },
    measured: Some(Measured { findings: 2, sample: 2, right: 2 }),
    check: Check::Reader(no_fix),
};
