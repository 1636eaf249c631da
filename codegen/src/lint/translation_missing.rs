//! `translation-missing`: a page that is translated in part.

use super::rule::{Check, Levels, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "translation-missing",
    purpose: "Where a language has begun to translate a message, a service, an action or the error codes of a package, \
              all their texts are to be translated: until then the page is in two languages. What a catalogue has no \
              entry of is left to English, and nothing of it is missing.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "uk.po",
        text: "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n\n\
               msgctxt \"demo/Glider\"\nmsgid \"State of a glider\"\nmsgstr \"Стан планера\"\n\n\
               msgctxt \"demo/Glider.timestamp\"\nmsgid \"Time since system start\"\nmsgstr \"\"\n",
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
