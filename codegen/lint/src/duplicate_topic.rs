//! `duplicate-topic`: a topic that is listed twice.

use super::prelude::*;
use super::topics;

pub(super) const RULE: Rule = Rule {
    id: "duplicate-topic",
    statement: "A topic that is listed twice.",
    why: "The second entry has no effect. Often a different name was intended.",
    fix: "Remove the second entry, or correct its name.",
    levels: Levels::both(Level::Warning),
    bad: glider!["", "# TOPICS glider tow_plane glider"],
    good: glider!["", "# TOPICS glider tow_plane"],
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Reader(fix),
};

fn fix(diagnostic: &Diagnostic, sources: &SourceMap) -> Vec<Edit> {
    let edit = |span| Edit { span, text: String::new() };
    topics::removal(diagnostic.span, sources).map(edit).into_iter().collect()
}
