//! `error-code-abbreviation-changed`: the abbreviation of an error code changed.

use uavspec_schema::ErrorCode;

use super::comparison::CodeChange;
use super::error_code_removed::name;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "error-code-abbreviation-changed",
    statement: "The abbreviation of an error code changed; its meaning is the same.",
    why: "Programs that use the old name no longer compile, and user interfaces show a different word.",
    fix: "Keep the abbreviation, and change only the description.",
    breaks: &[(Category::Source, Level::Error), (Category::Semantic, Level::Warning)],
    old: &[boats!["|   64 | LEAK | Water in the hull. |"]],
    new: &[boats!["|   64 | LEAKING | Water in the hull. |"]],
    check: Check::ErrorCode(check),
};

fn check(change: &CodeChange<'_>, sink: &mut Sink<'_>) {
    let CodeChange::Same(old, new) = change else { return };
    if old.abbreviation == new.abbreviation {
        return;
    }
    let message = format!("error code {} now has the abbreviation {}", name(old), text(new));
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Source, "programs that use the old name no longer compile")
        .breaks(Category::Semantic, "existing displays and logs show a different name");
}

fn text(code: &ErrorCode) -> &str {
    code.abbreviation.as_deref().unwrap_or("(none)")
}
