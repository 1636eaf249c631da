//! `translation-stale`: a translation of a text that has changed.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "translation-stale",
    statement: "A translation whose English text has changed.",
    why: "The translation is not used, and the page shows the English text.",
    fix: "Run `translate`, which updates the text and keeps the old text for comparison. \
        Then update the translation.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "uk.po",
        text: "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n\n\
               msgctxt \"demo/Glider\"\nmsgid \"State of a glider\"\nmsgstr \"Стан планера\"\n\n\
               msgctxt \"demo/Glider.timestamp\"\nmsgid \"Time since start\"\nmsgstr \"Час від запуску\"\n\n\
               msgctxt \"demo/Glider.sink\"\nmsgid \"Sink rate\"\nmsgstr \"Швидкість зниження\"\n",
    },
    good: Example {
        path: "uk.po",
        text: "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n\n\
               msgctxt \"demo/Glider\"\nmsgid \"State of a glider\"\nmsgstr \"Стан планера\"\n\n\
               msgctxt \"demo/Glider.timestamp\"\nmsgid \"Time since system start\"\nmsgstr \"Час від запуску системи\"\n\n\
               msgctxt \"demo/Glider.sink\"\nmsgid \"Sink rate\"\nmsgstr \"Швидкість зниження\"\n",
    },
    measured: None,
    check: Check::Reader(no_fix),
};
