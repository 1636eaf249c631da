//! `duplicate-topic`: a topic that is listed twice.

use uavspec_schema::diagnostic::{Diagnostic, Level};
use uavspec_schema::example::Example;
use uavspec_schema::finding::Edit;
use uavspec_schema::source::SourceMap;

use super::rule::{Check, Levels, Measured, Rule};
use super::topics;

pub(super) const RULE: Rule = Rule {
    id: "duplicate-topic",
    statement: "A topic that is listed twice.",
    why: "The second entry has no effect. Often a different name was intended.",
    fix: "Remove the second entry, or correct its name.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\n\
               # TOPICS glider tow_plane glider\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\n\
               # TOPICS glider tow_plane\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Reader(fix),
};

fn fix(diagnostic: &Diagnostic, sources: &SourceMap) -> Vec<Edit> {
    let edit = |span| Edit { span, text: String::new() };
    topics::removal(diagnostic.span, sources).map(edit).into_iter().collect()
}
