//! `error-code-removed`: an error code was removed.

use uavspec_schema::ErrorCode;

use super::comparison::CodeChange;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "error-code-removed",
    statement: "An error code was removed.",
    why: "Programs that use the code's name no longer compile. If a peer still sends the code, receivers \
        don't recognize it.",
    fix: "Keep the code, and mark it as obsolete in its description.",
    breaks: &[(Category::Source, Level::Error), (Category::Semantic, Level::Error)],
    old: &[boats!["|   64 | LEAK | Water in the hull. |", "|   65 | LIST | The boat heels. |"]],
    new: &[boats!["|   64 | LEAK | Water in the hull. |"]],
    check: Check::ErrorCode(check),
};

fn check(change: &CodeChange<'_>, sink: &mut Sink<'_>) {
    let CodeChange::Removed(old) = change else { return };
    let message = format!("error code {} was removed", name(old));
    sink.change(old.span, Sides { old: Some(old.span), new: None }, message)
        .breaks(Category::Source, "programs that use the code's name no longer compile")
        .breaks(Category::Semantic, "receivers don't recognize the code if a peer still sends it");
}

/// The name of a code, as shown in messages.
pub(super) fn name(code: &ErrorCode) -> String {
    match &code.abbreviation {
        Some(abbreviation) => format!("{} ({abbreviation})", code.code),
        None => code.code.to_string(),
    }
}
