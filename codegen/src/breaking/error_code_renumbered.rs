//! `error-code-renumbered`: an error code of another number.

use super::comparison::CodeChange;
use super::error_code_removed::name;
use super::message::both;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "error-code-renumbered",
    purpose: "An abbreviation that was unique to a code has another number. The two sides understand each \
              other wrongly until both change; where the severity changes with it, they also judge it \
              otherwise.",
    breaks: &[(Category::Semantic, Level::Error)],
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
               |   70 | LEAK | Water in the hull. |\n",
    }],
    check: Check::ErrorCode(check),
};

fn check(change: &CodeChange<'_>, sink: &mut Sink<'_>) {
    let CodeChange::Renumbered(old, new) = change else { return };
    let message = format!("error code {} is now {}", name(old), new.code);
    let help = if old.severity() == new.severity() {
        "programs of before don't understand the new number, and wait for the old one".to_owned()
    } else {
        format!("it was of severity {} and is of severity {}", old.severity(), new.severity())
    };
    sink.change(new.span, both(old.span, new.span), message).breaks(Category::Semantic, help);
}
