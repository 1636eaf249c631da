//! `event-meaning-changed`: the message of an event changed.

use super::comparison::{EventChange, common_words};
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "event-meaning-changed",
    statement: "The message of an event changed.",
    why: "Readers with the metadata of another build show the text of that build.",
    fix: "Check that the event still means the same. For a different condition, use a new event.",
    breaks: &[(Category::Semantic, Level::Note)],
    old: &[boat_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"15145947\": {\"name\": \"flood\", \"message\": \"The hull is full\"}}}}"
    ]],
    new: &[boat_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"15145947\": {\"name\": \"flood\", \"message\": \"Open the drain\"}}}}"
    ]],
    check: Check::Event(check),
};

/// The minimum fraction of words in common. Two messages with fewer common words have different meanings.
const SAME: f64 = 0.5;

fn check(change: &EventChange<'_>, sink: &mut Sink<'_>) {
    let EventChange::Same(old, new) = change else { return };
    if common_words(&old.event.message, &new.event.message) < SAME {
        let message = format!("the message of event `{}` changed", new.event.name);
        sink.change(new.event.span, both(old.event.span, new.event.span), message)
            .breaks(Category::Semantic, "check that the event still has the same meaning");
    }
}
