//! `error-code-added`: an error code was added.

use super::comparison::CodeChange;
use super::error_code_removed::name;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "error-code-added",
    statement: "An error code was added.",
    why: "Existing programs don't know the code, but can still derive its severity from the number.",
    fix: "Choose a number with the correct severity bits. Otherwise, no change is necessary.",
    breaks: &[(Category::Semantic, Level::Note)],
    old: &[boats!["|   64 | LEAK | Water in the hull. |"]],
    new: &[boats!["|   64 | LEAK | Water in the hull. |", "|   65 | LIST | The boat heels. |"]],
    check: Check::ErrorCode(check),
};

fn check(change: &CodeChange<'_>, sink: &mut Sink<'_>) {
    let CodeChange::Added(new) = change else { return };
    let message = format!("error code {} was added", name(new));
    sink.change(new.span, Sides { old: None, new: Some(new.span) }, message)
        .breaks(Category::Semantic, "existing programs show only its number and severity");
}
