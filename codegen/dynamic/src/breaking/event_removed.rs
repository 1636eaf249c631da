//! `event-removed`: an event was removed, or renamed.

use super::comparison::EventChange;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "event-removed",
    statement: "An event was removed, or its name changed.",
    why: "Programs that use the event no longer compile. Readers of logs that contain the event can't show it with \
        the new metadata. A new name results in a new id, because the id is a hash of the name.",
    fix: "Keep the event, or read old logs with their own metadata.",
    breaks: &[(Category::Source, Level::Error), (Category::Semantic, Level::Warning)],
    old: &[boat_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"4772366\": {\"name\": \"leak\", \"message\": \"Leak in tank {1}\", \"arguments\": [{\"name\": \"tank\", \"type\": \"uint8_t\"}]},",
        "  \"15145947\": {\"name\": \"flood\", \"message\": \"The hull is full\"}}}}"
    ]],
    new: &[boat_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"4772366\": {\"name\": \"leak\", \"message\": \"Leak in tank {1}\", \"arguments\": [{\"name\": \"tank\", \"type\": \"uint8_t\"}]}}}}"
    ]],
    check: Check::Event(check),
};

fn check(change: &EventChange<'_>, sink: &mut Sink<'_>) {
    let EventChange::Removed(old) = change else { return };
    let message = format!("event `{}` was removed", old.name);
    sink.change(old.span, Sides { old: Some(old.span), new: None }, message)
        .breaks(Category::Source, "programs that use the event no longer compile")
        .breaks(Category::Semantic, "readers with the new metadata can't show the event of older firmware");
}
