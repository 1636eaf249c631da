//! `topic-added`: a topic was added.

use std::collections::BTreeSet;

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::message::{Pair, both};
use super::rule::{Category, Check, Rule, Sink};

pub(super) const RULE: Rule = Rule {
    id: "topic-added",
    statement: "A topic was added to a message.",
    why: "No existing program is affected. The report lists the change for completeness.",
    fix: "No change is necessary.",
    breaks: &[(Category::Source, Level::Note)],
    old: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               \n\
               # TOPICS glider\n",
    }],
    new: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               \n\
               # TOPICS glider glider_backup\n",
    }],
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
