//! `unknown-translation`: an entry of a catalogue that translates nothing.

use super::rule::{Check, Levels, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "unknown-translation",
    purpose: "The `msgctxt` of an entry names something that the definitions say: `px4/Wind` a message, `px4/Wind.speed` \
              a field, `px4/Wind::SPEED_LOW` a constant, `flockwave/error-code/134` an error code. One that names nothing \
              was misspelt, or its thing is gone.",
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
