//! `hint-invalid`: a hint with a syntax error, an unknown key or a wrong type.

use super::prelude::*;
use super::rule::Converted;

pub(super) const RULE: Rule = Rule {
    id: "hint-invalid",
    statement: "A hint with a syntax error, an unknown key or a wrong type.",
    why: "The hint can't be applied, and no conversions are generated.",
    fix: "Correct the hint.",
    levels: Levels::both(Level::Error),
    bad: Example {
        path: "hints.toml",
        text: "[[hint]]\nmessage = \"Glider\"\nnew.is_landed = \"sink < 0.1 and\"\n",
    },
    good: Example {
        path: "hints.toml",
        text: "[[hint]]\nmessage = \"Glider\"\nnew.is_landed = \"sink < 0.1\"\n",
    },
    measured: None,
    check: Check::Conversion(check),
};

fn check(subject: &Converted<'_>, sink: &mut Sink<'_>) {
    for mistake in subject.answer.mistakes() {
        sink.report(mistake.span, mistake.message, mistake.help);
    }
}
