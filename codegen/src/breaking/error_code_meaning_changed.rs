//! `error-code-meaning-changed`: an error code that is described otherwise.

use super::comparison::CodeChange;
use super::comparison::common_words;
use super::error_code_removed::name;
use super::message::both;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "error-code-meaning-changed",
    purpose: "The description of an error code has become another one, by more than a change of words; or \
              the codes that stand for the same condition at other severities have changed.",
    breaks: &[(Category::Semantic, Level::Warning)],
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
               |   64 | LEAK | Fuel drips from the tank. |\n",
    }],
    check: Check::ErrorCode(check),
};

/// Where fewer of the words are common, the description is another one.
const SAME: f64 = 0.5;

fn check(change: &CodeChange<'_>, sink: &mut Sink<'_>) {
    let CodeChange::Same(old, new) = change else { return };
    if common_words(&old.description, &new.description) < SAME {
        let message = format!("error code {} is described otherwise", name(new));
        sink.change(new.span, both(old.span, new.span), message)
            .breaks(Category::Semantic, "read whether it still means the same");
    } else if old.alternatives != new.alternatives {
        let message = format!("error code {} has other alternatives", name(new));
        sink.change(new.span, both(old.span, new.span), message).breaks(
            Category::Semantic,
            "a list that kept to the rule before may hold two of one condition now",
        );
    }
}
