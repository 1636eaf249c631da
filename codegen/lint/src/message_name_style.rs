//! `message-name-style`: a message file that isn't named in `PascalCase`.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Measured, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "message-name-style",
    statement: "A message file whose name is not in PascalCase.",
    why: "Tools derive the topic and type names from the file name, and ROS 2 rejects names that are not in \
        PascalCase.",
    fix: "Rename the file.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "glider_state.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n",
    },
    good: Example {
        path: "GliderState.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Reader(no_fix),
};
