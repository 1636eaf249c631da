//! `topic-list-empty`: an empty list of topics.

use super::prelude::*;
use super::topics;

pub(super) const RULE: Rule = Rule {
    id: "topic-list-empty",
    statement: "A `# TOPICS` line without a topic.",
    why: "The line has no effect, and the documentation shows it as text.",
    fix: "List the topics, or remove the line.",
    levels: Levels::both(Level::Warning),
    bad: glider!["", "# TOPICS"],
    good: glider!["", "# TOPICS glider tow_plane"],
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Message(Scope::Px4Messages, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    for line in topics::lines(subject).filter(|line| topics::words(line).next().is_none()) {
        sink.report(line.span, "empty list of topics", "list the topics, or remove the line");
    }
}
