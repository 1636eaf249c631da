//! `hint-unused`: a hint that is never used.

use super::prelude::*;
use super::rule::Converted;

pub(super) const RULE: Rule = Rule {
    id: "hint-unused",
    statement: "A hint that is never used.",
    why: "A name in the hint is misspelled, or the hint applies to other versions. Hints that are shared between \
        projects may cover more versions than each project uses.",
    fix: "Correct the name, or remove the hint.",
    levels: Levels { px4: Some(Level::Note), strict: Some(Level::Warning) },
    bad: Example {
        path: "hints.toml",
        text: "[[hint]]\nmessage = \"Glidr\"\nnarrow = { sink = \"nearest\" }\n",
    },
    good: Example {
        path: "hints.toml",
        text: "[[hint]]\nmessage = \"Glider\"\nnarrow = { sink = \"nearest\" }\n",
    },
    measured: None,
    check: Check::Conversion(check),
};

fn check(subject: &Converted<'_>, sink: &mut Sink<'_>) {
    for hint in subject.answer.unused(subject.schema) {
        sink.report(hint.span, hint.message, hint.help);
    }
}
