//! `topic-default-absent`: a list of topics without the default topic.

use uavspec_schema::resolve::default_topic;

use super::prelude::*;
use super::topics;

pub(super) const RULE: Rule = Rule {
    id: "topic-default-absent",
    statement: "A topic list without the topic named after the message.",
    why: "A message with a topic list has only the listed topics. This is usually intended, but a listed \
        name that resembles the default may be a typo.",
    fix: "Add the default topic if a subscriber needs it, or correct the name.",
    levels: Levels::both(Level::Note),
    bad: glider!["", "# TOPICS glyder tow_plane"],
    good: glider!["", "# TOPICS glider tow_plane"],
    measured: Some(Measured { findings: 10, sample: 10, right: 0 }),
    check: Check::Message(Scope::Px4Messages, check),
};

/// The maximum edit distance between a mistyped topic and the default topic.
const MAX_DISTANCE: usize = 2;

/// The maximum length of compared topics. A comparison takes time proportional to the product of the lengths.
const MAX_LEN: usize = 100;

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let default = default_topic(&subject.message.name);
    let listed = || topics::lines(subject).flat_map(topics::words);
    if default.len() > MAX_LEN || listed().any(|(word, _)| word == default) {
        return;
    }
    let is_typo = |word: &str| {
        // A topic such as `glider_0` is a different topic, not a mistyped one.
        word.len().abs_diff(default.len()) <= MAX_DISTANCE
            && !word.starts_with(&default)
            && strsim::damerau_levenshtein(word, &default) <= MAX_DISTANCE
    };
    let name = &subject.message.name;
    let Some((_, first)) = listed().next() else { return };
    let typo = listed().find(|(word, _)| is_typo(word));
    let help = match typo {
        Some((word, _)) => {
            format!("`{word}` is similar: write `{default}` instead, or list both if both are intended")
        }
        None => "add it if subscribers need it".to_owned(),
    };
    let place = typo.map_or(first, |(_, place)| place);
    sink.report(place, format!("the topics of `{name}` do not include its default topic `{default}`"), help);
}
