//! `translation-missing`: a partly translated page.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "translation-missing",
    statement: "A missing translation in a partly translated message, service, action or list of error codes.",
    why: "The page mixes two languages. Items with no translations at all are shown in English and not reported.",
    fix: "Translate the remaining texts.",
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
