//! `event-enum-changed`: an entry of an enum of events was removed, or has another value.

use uavspec_schema::EventEnum;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "event-enum-changed",
    statement: "An entry of an event enum was removed, or its value has a different meaning.",
    why: "Readers with the metadata of another build show a wrong label.",
    fix: "Keep the values of all entries, and add new entries with new values.",
    breaks: &[(Category::Source, Level::Error), (Category::Semantic, Level::Error)],
    old: &[boat_events![
        " \"enums\": {\"side_t\": {\"type\": \"uint8_t\", \"entries\": {",
        "  \"0\": {\"name\": \"port\", \"description\": \"Port\"},",
        "  \"1\": {\"name\": \"starboard\", \"description\": \"Starboard\"}}}}"
    ]],
    new: &[boat_events![
        " \"enums\": {\"side_t\": {\"type\": \"uint8_t\", \"entries\": {",
        "  \"0\": {\"name\": \"starboard\", \"description\": \"Starboard\"},",
        "  \"1\": {\"name\": \"port\", \"description\": \"Port\"}}}}"
    ]],
    check: Check::EventEnum(check),
};

fn check(old: &EventEnum, new: &EventEnum, sink: &mut Sink<'_>) {
    for before in &old.entries {
        let (name, value) = (&before.name, before.value);
        let problem = match new.entry(value) {
            Some(after) if after.name == *name => continue,
            Some(after) => format!("is `{}`", after.name),
            None => "was removed".to_owned(),
        };
        let message = format!("`{name}` ({value}) of `{}` {problem}", new.name);
        sink.change(new.span, both(before.span, new.span), message)
            .breaks(Category::Source, "programs that use the entry don't compile, or use a different value")
            .breaks(Category::Semantic, "readers with other metadata show a wrong label");
    }
}
