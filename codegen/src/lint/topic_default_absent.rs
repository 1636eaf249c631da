//! `topic-default-absent`: a list of topics without the one of the message's name.

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;
use super::topics;
use crate::diagnostic::Level;
use crate::example::Example;
use crate::resolve::default_topic;

pub(super) const RULE: Rule = Rule {
    id: "topic-default-absent",
    purpose: "A message that lists topics no longer has that of its own name unless it lists it too. Most often \
              that is meant, so look whether anything waits for that topic; where one of the list is that name \
              but for a letter or two, it is a slip.",
    levels: Levels::both(Level::Note),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\n\
               # TOPICS glyder tow_plane\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\n\
               # TOPICS glider tow_plane\n",
    },
    measured: Some(Measured {
        findings: 10,
        sample: 10,
        right: 0,
        remark: "all are meant; PX4's own checker notes them too",
    }),
    check: Check::Message(check),
};

/// How many letters a slip may change.
const MAX_DISTANCE: usize = 2;

/// No topic is longer; comparing takes the product of the lengths.
const MAX_LEN: usize = 100;

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !subject.is_px4_message() {
        return;
    }
    let default = default_topic(&subject.message.name);
    let listed = || topics::lines(subject).flat_map(topics::words);
    if default.len() > MAX_LEN || listed().any(|(word, _)| word == default) {
        return;
    }
    let is_slip = |word: &str| {
        // `glider_0` is another topic.
        word.len().abs_diff(default.len()) <= MAX_DISTANCE
            && !word.starts_with(&default)
            && strsim::damerau_levenshtein(word, &default) <= MAX_DISTANCE
    };
    let name = &subject.message.name;
    let Some((_, first)) = listed().next() else { return };
    let slip = listed().find(|(word, _)| is_slip(word));
    let help = match slip {
        Some((word, _)) => format!("`{word}` is nearly that: write `{default}`, or add it if both are meant"),
        None => "add it, if anything is to find the message by its name".to_owned(),
    };
    let place = slip.map_or(first, |(_, place)| place);
    sink.report(place, format!("the topics of `{name}` lack `{default}`, which is that of its name"), help);
}
