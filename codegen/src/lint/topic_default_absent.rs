//! `topic-default-absent`: a list of topics without the one of the message's name.

use super::{Check, Example, Levels, Rule, Sink, Subject, topics};
use crate::diagnostic::Level;
use crate::schema::resolve::default_topic;

pub(super) const RULE: Rule = Rule {
    id: "topic-default-absent",
    purpose: "A message that lists topics no longer has that of its own name unless it lists it too. Most \
              often it should; where not, readers look for a topic that isn't there.",
    levels: Levels::both(Level::Note),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\n\
               # TOPICS tow_plane winch\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\n\
               # TOPICS glider tow_plane winch\n",
    },
    measured: None,
    check: Check::Message(check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !subject.is_px4_message() {
        return;
    }
    let default = default_topic(&subject.message.name);
    let mut listed = topics::lines(subject).flat_map(topics::words);
    let Some((first, place)) = listed.next() else { return };
    if first != default && listed.all(|(word, _)| word != default) {
        sink.report(
            place,
            format!("`{default}` is not among the topics"),
            "add it, if the message is also sent there",
        );
    }
}
