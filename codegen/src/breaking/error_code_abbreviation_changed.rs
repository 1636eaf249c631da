//! `error-code-abbreviation-changed`: an error code of another abbreviation.

use super::comparison::CodeChange;
use super::error_code_removed::name;
use super::message::both;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::ErrorCode;

pub(super) const RULE: Rule = Rule {
    id: "error-code-abbreviation-changed",
    purpose: "An error code has another abbreviation for the same condition. Programs that use the old \
              name don't compile, and displays show another word.",
    breaks: &[(Category::Source, Level::Error), (Category::Semantic, Level::Warning)],
    old: &[Example {
        path: "boats.md",
        text: "# Boats\n\
               \n\
               ## Warnings (codes 64-127)\n\
               \n\
               | Code | Abbr | Description |\n\
               |-----:|------|-------------|\n\
               |   64 | LEAK | Water in the hull. |\n",
    }],
    new: &[Example {
        path: "boats.md",
        text: "# Boats\n\
               \n\
               ## Warnings (codes 64-127)\n\
               \n\
               | Code | Abbr | Description |\n\
               |-----:|------|-------------|\n\
               |   64 | LEAKING | Water in the hull. |\n",
    }],
    check: Check::ErrorCode(check),
};

fn check(change: &CodeChange<'_>, sink: &mut Sink<'_>) {
    let CodeChange::Same(old, new) = change else { return };
    if old.abbreviation == new.abbreviation {
        return;
    }
    let message = format!("error code {} is now abbreviated {}", name(old), text(new));
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Source, "programs that use it by its old name don't compile")
        .breaks(Category::Semantic, "displays and logs of before and now name it differently");
}

fn text(code: &ErrorCode) -> &str {
    code.abbreviation.as_deref().unwrap_or("by its number alone")
}
