//! `topic-redundant`: a list that contains only the default topic.

use uavspec_schema::resolve::default_topic;

use super::prelude::*;
use super::topics;

pub(super) const RULE: Rule = Rule {
    id: "topic-redundant",
    statement: "A topic list that contains only the default topic.",
    why: "The list has no effect, and it becomes wrong if the message is renamed.",
    fix: "Remove the line.",
    levels: Levels::both(Level::Note),
    bad: glider!["", "# TOPICS glider"],
    good: glider![],
    measured: Some(Measured { findings: 4, sample: 4, right: 4 }),
    check: Check::Message(Scope::Px4Messages, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let listed = || topics::lines(subject).flat_map(topics::words);
    let default = default_topic(&subject.message.name);
    // If the topic is listed twice, another rule reports it.
    let Some((_, place)) =
        listed().next().filter(|_| listed().nth(1).is_none()).filter(|(word, _)| *word == default)
    else {
        return;
    };
    let finding = sink.report(place, format!("`{default}` is the default topic"), "remove the line");
    if let Some(removal) = topics::removal(place, subject.sources) {
        finding.edit(removal, "");
    }
}
