//! `unknown-translation`: a translation of an unknown item.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "unknown-translation",
    statement: "A translation of an unknown item.",
    why: "The translation is not used. The `msgctxt` is misspelt, or the item was removed.",
    fix: "Correct the `msgctxt`, or remove the entry. Valid forms are `px4/Wind`, `px4/Wind.speed`, \
        `px4/Wind::SPEED_LOW` and `flockwave/error-code/134`.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "uk.po",
        text: "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n\n\
               msgctxt \"demo/Glider.sinking\"\nmsgid \"Sink rate\"\nmsgstr \"Швидкість зниження\"\n",
    },
    good: Example {
        path: "uk.po",
        text: "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n\n\
               msgctxt \"demo/Glider.sink\"\nmsgid \"Sink rate\"\nmsgstr \"Швидкість зниження\"\n",
    },
    measured: None,
    check: Check::Reader(no_fix),
};
