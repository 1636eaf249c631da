//! `error-code-reused`: the number of an error code has a new meaning.

use super::comparison::CodeChange;
use super::error_code_removed::name;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "error-code-reused",
    statement: "The number of an error code has a new meaning.",
    why: "Existing programs show the code with its old meaning.",
    fix: "Use a new number for the new condition, and don't reuse numbers.",
    breaks: &[(Category::Source, Level::Error), (Category::Semantic, Level::Error)],
    old: &[boats!["|   64 | LEAK | Water in the hull. |"]],
    new: &[boats!["|   64 | MAST | Rigging is torn. |"]],
    check: Check::ErrorCode(check),
};

fn check(change: &CodeChange<'_>, sink: &mut Sink<'_>) {
    let CodeChange::Reused(old, new) = change else { return };
    let message = format!("error code {} is now {}", name(old), name(new));
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Source, "programs that use the old name no longer compile")
        .breaks(Category::Semantic, "existing programs use the old meaning");
}
