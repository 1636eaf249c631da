//! `not-portable`: syntax that only some tools support.

use uavspec_schema::diagnostic::Problem;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "not-portable",
    statement: "Syntax that PX4's generator or rosidl doesn't support.",
    why: "PX4's generator accepts only decimal integers, `True` and `False`, and needs a space between \
        type and name. It misreads other forms without reporting an error. rosidl, which reads definitions for ROS 2, \
        accepts no spaces before a declaration, nothing after `---`, no `#` in a string, no `=` in a default, and \
        `time`, `duration` and `Header` only with their packages.",
    fix: "Write the portable form.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint8 SEATS_MAX = 0x02  # Seats of the largest glider\n\n\
               uint64 timestamp  # [us] Time since system start\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint8 SEATS_MAX = 2  # Seats of the largest glider\n\n\
               uint64 timestamp  # [us] Time since system start\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Reader(fix),
};

fn fix(diagnostic: &Diagnostic, _: &SourceMap) -> Vec<Edit> {
    match &diagnostic.problem {
        Problem::NotPortable { instead: Some(instead), .. } => {
            vec![Edit { span: diagnostic.span, text: instead.clone() }]
        }
        _ => Vec::new(),
    }
}
