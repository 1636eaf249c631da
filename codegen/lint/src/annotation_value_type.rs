//! `annotation-value-type`: an annotation with a value that the field can't represent.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Measured, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "annotation-value-type",
    statement: "An annotation with a value that the type of the field can't represent.",
    why: "The value can't occur; for example, an integer is never NaN. Checks that rely on the annotation have no \
        effect.",
    fix: "Use a value of the field's type, or change the type.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 crew  # [-] [@invalid NaN] People on board\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 crew  # [-] [@invalid 255] People on board\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Reader(no_fix),
};
