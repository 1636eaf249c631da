//! `event-arguments-changed`: the arguments of an event changed.

use super::comparison::{EventChange, EventIn};
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "event-arguments-changed",
    statement: "The arguments of an event changed.",
    why: "The id of the event stays the same, so readers with the metadata of another build decode the arguments \
        incorrectly, and show wrong numbers.",
    fix: "Add new arguments at the end, or give the event a new name.",
    breaks: &[
        (Category::Source, Level::Error),
        (Category::Json, Level::Error),
        (Category::Semantic, Level::Error),
    ],
    old: &[boat_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"4772366\": {\"name\": \"leak\", \"message\": \"Leak in tank {1}\", \"arguments\": [{\"name\": \"tank\", \"type\": \"uint8_t\"}]}}}}"
    ]],
    new: &[boat_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"4772366\": {\"name\": \"leak\", \"message\": \"Leak in tank {1}\", \"arguments\": [{\"name\": \"tank\", \"type\": \"uint16_t\"}]}}}}"
    ]],
    check: Check::Event(check),
};

fn check(change: &EventChange<'_>, sink: &mut Sink<'_>) {
    let EventChange::Same(old, new) = change else { return };
    let [before, after] = [old, new].map(EventIn::arguments);
    if before == after {
        return;
    }
    let message = format!("the arguments of event `{}` are ({after}) instead of ({before})", new.event.name);
    let mut change = sink.change(new.event.span, both(old.event.span, new.event.span), message);
    change
        .breaks(Category::Source, "programs that use the arguments no longer compile")
        .breaks(Category::Json, "readers of decoded events expect different arguments");
    // Arguments added at the end are compatible, because readers ignore bytes after the known arguments.
    if !new.layout().starts_with(&old.layout()) {
        change.breaks(Category::Semantic, "readers with other metadata decode wrong values");
    }
}
