//! `missing-answer`: a request that nothing answers.

use super::rule::{Check, Levels, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "missing-answer",
    purpose: "Whoever sends a request has to know what comes back: a response of the same type, or one of the types that \
              the line `Answer:` below the heading `Request` names.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "winch.md",
        text: "# Winch\n\n## ROPE-CUT\n\n### Request\n\nNo fields beside `type`.\n",
    },
    good: Example {
        path: "winch.md",
        text: "# Winch\n\n## ROPE-CUT\n\n### Request\n\nNo fields beside `type`.\n\nAnswer: ROPE-INF\n\n\
               ## ROPE-INF\n\n### Response\n\nNo fields beside `type`.\n",
    },
    measured: None,
    check: Check::Reader(no_fix),
};
