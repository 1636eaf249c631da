//! `message-name-style`: messages are named in `PascalCase`.

use super::rule::{Check, Levels, Measured, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "message-name-style",
    purpose: "The file of a message is named in PascalCase. Tools derive the name of its topic and of its \
              types from it, and ROS 2 refuses any other.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "glider_state.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n",
    },
    good: Example {
        path: "GliderState.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0, remark: "" }),
    check: Check::Reader(no_fix),
};
