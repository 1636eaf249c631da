//! `missing-answer`: a request without a response.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "missing-answer",
    statement: "A request type without a response.",
    why: "Clients don't know what to expect. A response has the type of the request, or one of the types in the \
        `Answer:` line under the `Request` heading.",
    fix: "Add a `Response` section, or an `Answer:` line with the types of the answers.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "winch.md",
        text: "# Winch\n\n## ROPE-CUT\n\n### Request\n\nNo fields besides `type`.\n",
    },
    good: Example {
        path: "winch.md",
        text: "# Winch\n\n## ROPE-CUT\n\n### Request\n\nNo fields besides `type`.\n\nAnswer: ROPE-INF\n\n\
               ## ROPE-INF\n\n### Response\n\nNo fields besides `type`.\n",
    },
    measured: None,
    check: Check::Reader(no_fix),
};
