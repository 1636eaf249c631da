//! `unknown-enum`: an enum without constants.

use super::rule::{Check, Levels, Measured, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "unknown-enum",
    purpose: "The prefix of `[@enum]` and `[@flags]` is that of constants of the message. With any other the \
              field stays a plain number, and no value of it has a name.",
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
    measured: Some(Measured { findings: 2, sample: 2, right: 2, remark: "" }),
    check: Check::Reader(no_fix),
};
