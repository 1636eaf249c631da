//! `event-added`: an event was added.

use super::comparison::EventChange;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "event-added",
    statement: "An event was added.",
    why: "Readers with older event metadata show only its id.",
    fix: "Give users the event metadata of the new firmware.",
    breaks: &[(Category::Semantic, Level::Note)],
    old: &[boat_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"4772366\": {\"name\": \"leak\", \"message\": \"Leak in tank {1}\", \"arguments\": [{\"name\": \"tank\", \"type\": \"uint8_t\"}]}}}}"
    ]],
    new: &[boat_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"4772366\": {\"name\": \"leak\", \"message\": \"Leak in tank {1}\", \"arguments\": [{\"name\": \"tank\", \"type\": \"uint8_t\"}]},",
        "  \"15145947\": {\"name\": \"flood\", \"message\": \"The hull is full\"}}}}"
    ]],
    check: Check::Event(check),
};

fn check(change: &EventChange<'_>, sink: &mut Sink<'_>) {
    let EventChange::Added(new) = change else { return };
    let message = format!("event `{}` was added", new.name);
    sink.change(new.span, Sides { old: None, new: Some(new.span) }, message)
        .breaks(Category::Semantic, "readers with older event metadata show only its id");
}
