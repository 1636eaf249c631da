//! `topic-added`: a topic was added.

use std::collections::BTreeSet;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "topic-added",
    statement: "A topic was added to a message.",
    why: "No existing program is affected. The report lists the change for completeness.",
    fix: "No change is necessary.",
    breaks: &[(Category::Source, Level::Note)],
    old: &[glider!["", "# TOPICS glider"]],
    new: &[glider!["", "# TOPICS glider glider_backup"]],
    check: Check::Message(check),
};

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    let known: BTreeSet<&str> = pair.old.topics.iter().map(String::as_str).collect();
    for topic in pair.new.topics.iter().filter(|topic| !known.contains(topic.as_str())) {
        let message = format!("`{}` has the new topic `{topic}`", pair.name());
        sink.change(pair.head(), both(pair.old.span.part(0..0), pair.head()), message)
            .breaks(Category::Source, "no existing program is affected");
    }
}
