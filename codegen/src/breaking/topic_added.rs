//! `topic-added`: a topic that is new.

use std::collections::BTreeSet;

use super::message::Pair;
use super::message::both;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "topic-added",
    purpose: "A message has one more topic. That breaks nobody; it is said so that the report tells all \
              that changed.",
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
    let known: BTreeSet<&String> = pair.old.topics.iter().collect();
    for topic in pair.new.topics.iter().filter(|topic| !known.contains(topic)) {
        let message = format!("`{}` has the new topic `{topic}`", pair.name());
        sink.change(pair.head(), both(pair.old.span.part(0..0), pair.head()), message)
            .breaks(Category::Source, "nobody: programs may use it from now on");
    }
}
