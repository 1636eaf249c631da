//! `topic-removed`: a topic was removed.

use std::collections::BTreeSet;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "topic-removed",
    statement: "A topic was removed from a message.",
    why: "Programs that use the topic no longer compile, or find no publisher or subscriber.",
    fix: "Keep the topic until no program uses it.",
    breaks: &[(Category::Source, Level::Error)],
    old: &[glider!["", "# TOPICS glider glider_backup"]],
    new: &[glider!["", "# TOPICS glider"]],
    check: Check::Message(check),
};

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    let known: BTreeSet<&str> = pair.new.topics.iter().map(String::as_str).collect();
    for topic in pair.old.topics.iter().filter(|topic| !known.contains(topic.as_str())) {
        let message = format!("`{}` no longer has the topic `{topic}`", pair.name());
        sink.change(pair.head(), both(pair.old.span.part(0..0), pair.head()), message).breaks(
            Category::Source,
            "programs that use the topic no longer compile, or find no publisher or subscriber",
        );
    }
}
