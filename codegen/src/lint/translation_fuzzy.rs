//! `translation-fuzzy`: a translation that somebody has to look at.

use super::rule::{Check, Levels, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "translation-fuzzy",
    purpose: "A translation that is marked as fuzzy was made of another text, or by guesswork. It isn't used until \
              somebody has looked at it and taken the flag away.",
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
