//! `error-code-renumbered`: the number of an error code changed.

use super::comparison::CodeChange;
use super::error_code_removed::name;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "error-code-renumbered",
    statement: "An error code has a new number.",
    why: "Peers misunderstand each other until both are updated. If the severity changes too, they \
        also react differently.",
    fix: "Keep the old number.",
    breaks: &[(Category::Semantic, Level::Error)],
    old: &[boats!["|   64 | LEAK | Water in the hull. |"]],
    new: &[boats!["|   70 | LEAK | Water in the hull. |"]],
    check: Check::ErrorCode(check),
};

fn check(change: &CodeChange<'_>, sink: &mut Sink<'_>) {
    let CodeChange::Renumbered(old, new) = change else { return };
    let message = format!("error code {} is now {}", name(old), new.code);
    let help = if old.severity() == new.severity() {
        "existing programs don't know the new number and still check for the old number".to_owned()
    } else {
        format!("the severity changes from {} to {}", old.severity(), new.severity())
    };
    sink.change(new.span, both(old.span, new.span), message).breaks(Category::Semantic, help);
}
