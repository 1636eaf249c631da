//! `invisible-character`: characters that nobody sees.

use super::rule::{Check, Levels, Measured, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "invisible-character",
    purpose: "A text has no characters without width and none that turn its direction. They make a name or a \
              number look other than it is, and a search doesn't find it.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sink  # [m/s] Sink\u{200b} rate\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sink  # [m/s] Sink rate\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0, remark: "" }),
    check: Check::Reader(no_fix),
};
