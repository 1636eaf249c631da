//! `unit-missing`: a measured quantity without a unit.

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::{Element, Field};

pub(super) const RULE: Rule = Rule {
    id: "unit-missing",
    purpose: "A field of floats states its unit, `[-]` where it has none. Without it, readers guess between \
              degrees and radians, and nobody can check the guess. Where the unit isn't known, the comment \
              says so: `no unit is defined`.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 bank      # Bank angle\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 bank      # [rad] Bank angle\n",
    },
    measured: Some(Measured {
        findings: 527,
        sample: 30,
        right: 28,
        remark: "the others are in whatever unit another field says",
    }),
    check: Check::Message(check),
};

/// How a comment says that nobody has defined the unit. `[-]` would be false there, and a guess worse.
const UNDEFINED: [&str; 4] =
    ["no unit is defined", "unit is not defined", "unit isn't defined", "unit is unknown"];

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !subject.is_px4() {
        return;
    }
    for (field, _) in subject.fields() {
        let is_float = matches!(field.ty.element, Element::Scalar(scalar) if scalar.is_float());
        if is_float
            && field.unit.is_none()
            && field.enum_prefixes.is_empty()
            && !says_that_there_is_none(field)
        {
            sink.report(
                field.span,
                format!("`{}` has no unit", field.name),
                "state it at the head of the comment: `# [m/s] …`, or `[-]` for a plain number",
            );
        }
    }
}

/// Whether the comment of a field says that its unit is not defined.
pub(super) fn says_that_there_is_none(field: &Field) -> bool {
    UNDEFINED.iter().any(|words| field.description.contains(words))
}
