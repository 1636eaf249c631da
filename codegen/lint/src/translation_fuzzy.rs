//! `translation-fuzzy`: a translation that must be reviewed.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "translation-fuzzy",
    statement: "A translation that is marked as fuzzy.",
    why: "The translation was guessed or made from a different text, so it is not used until a translator reviews it.",
    fix: "Review the translation, and remove the flag.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "uk.po",
        text: "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n\n\
               #, fuzzy\n#| msgid \"Speed of sinking\"\nmsgctxt \"demo/Glider.sink\"\nmsgid \"Sink rate\"\n\
               msgstr \"Швидкість опускання\"\n\n\
               msgctxt \"demo/Glider.timestamp\"\nmsgid \"Time since system start\"\nmsgstr \"Час від запуску системи\"\n\n\
               msgctxt \"demo/Glider\"\nmsgid \"State of a glider\"\nmsgstr \"Стан планера\"\n",
    },
    good: Example {
        path: "uk.po",
        text: "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n\n\
               msgctxt \"demo/Glider.sink\"\nmsgid \"Sink rate\"\nmsgstr \"Швидкість зниження\"\n\n\
               msgctxt \"demo/Glider.timestamp\"\nmsgid \"Time since system start\"\nmsgstr \"Час від запуску системи\"\n\n\
               msgctxt \"demo/Glider\"\nmsgid \"State of a glider\"\nmsgstr \"Стан планера\"\n",
    },
    measured: None,
    check: Check::Reader(no_fix),
};
