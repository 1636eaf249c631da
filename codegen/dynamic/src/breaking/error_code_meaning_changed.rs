//! `error-code-meaning-changed`: the meaning of an error code changed.

use super::comparison::{CodeChange, common_words};
use super::error_code_removed::name;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "error-code-meaning-changed",
    statement: "The meaning of an error code changed: its description or its alternatives are different.",
    why: "Existing programs still act on the old meaning.",
    fix: "Check that the meaning is the same. For a different condition, use a new code.",
    breaks: &[(Category::Semantic, Level::Warning)],
    old: &[boats!["|   64 | LEAK | Water in the hull. |"]],
    new: &[boats!["|   64 | LEAK | Fuel drips from the tank. |"]],
    check: Check::ErrorCode(check),
};

/// The minimum fraction of words in common. Two descriptions with fewer common words have different meanings.
const SAME: f64 = 0.5;

fn check(change: &CodeChange<'_>, sink: &mut Sink<'_>) {
    let CodeChange::Same(old, new) = change else { return };
    if common_words(&old.description, &new.description) < SAME {
        let message = format!("the description of error code {} changed", name(new));
        sink.change(new.span, both(old.span, new.span), message)
            .breaks(Category::Semantic, "check that the code still has the same meaning");
    } else if old.alternatives != new.alternatives {
        let message = format!("the alternatives of error code {} changed", name(new));
        sink.change(new.span, both(old.span, new.span), message).breaks(
            Category::Semantic,
            "a list of codes that used to be valid may now contain two codes for the same condition",
        );
    }
}
