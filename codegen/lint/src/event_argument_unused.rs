//! `event-argument-unused`: an argument that no text of its event shows.

use uavspec_runtime::event::{Piece, Text};
use uavspec_schema::{Event, EventKind, Package};

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "event-argument-unused",
    statement: "An argument of an event that neither the message nor the description shows.",
    why: "The vehicle sends a value that nobody sees.",
    fix: "Refer to the argument in a text, or remove it.",
    levels: Levels::both(Level::Note),
    bad: winch_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"6674671\": {\"name\": \"rope_torn\", \"message\": \"Rope torn\",",
        "   \"arguments\": [{\"name\": \"length\", \"type\": \"float\"}]}}}}"
    ],
    good: winch_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"6674671\": {\"name\": \"rope_torn\", \"message\": \"Rope torn at {1:.1m}\",",
        "   \"arguments\": [{\"name\": \"length\", \"type\": \"float\"}]}}}}"
    ],
    measured: None,
    check: Check::Package(check),
};

fn check(package: &Package, _: &SourceMap, sink: &mut Sink<'_>) {
    for event in package.components.iter().flat_map(|component| &component.events) {
        // Programs use the first arguments of these events, even if the texts don't show them.
        let required = match event.kind {
            EventKind::Summary => continue,
            EventKind::AppendChecks => 1,
            EventKind::Plain if event.is_check() => 2,
            EventKind::Plain => 0,
        };
        let shown = shown(event);
        for (index, argument) in event.arguments.iter().enumerate().skip(required) {
            if !shown.contains(&index) && event.instance_argument != Some(index) {
                let message = format!("no text of `{}` shows the argument `{}`", event.name, argument.name);
                let help =
                    format!("write `{{{}}}` where the value belongs, or remove the argument", index + 1);
                sink.report(argument.span, message, help);
            }
        }
    }
}

/// The indices of the arguments that the texts show.
fn shown(event: &Event) -> Vec<usize> {
    let mut found = Vec::new();
    let mut texts = vec![Text::new(&event.message), Text::new(&event.description)];
    while let Some(text) = texts.pop() {
        for piece in text.pieces() {
            match piece {
                Piece::Placeholder(placeholder) => found.push(placeholder.number - 1),
                Piece::Tag(tag) if tag.name == "profile" => texts.push(Text::new(tag.content)),
                _ => {}
            }
        }
    }
    found
}
