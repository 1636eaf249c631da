//! `not-portable`: what only some of the tools read.

use super::rule::{Check, Levels, Measured, Rule};
use crate::diagnostic::{Diagnostic, Level, Problem};
use crate::example::Example;
use crate::finding::Edit;
use crate::source::SourceMap;

pub(super) const RULE: Rule = Rule {
    id: "not-portable",
    purpose: "PX4's generator reads decimal integers, `True` and `False`, and wants a blank between type and \
              name. It takes another spelling for something else, or cuts it, without a word.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint8 SEATS_MAX = 0x02  # Seats of the largest one\n\n\
               uint64 timestamp  # [us] Time since system start\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint8 SEATS_MAX = 2  # Seats of the largest one\n\n\
               uint64 timestamp  # [us] Time since system start\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0, remark: "" }),
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
