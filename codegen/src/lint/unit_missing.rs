//! `unit-missing`: a measured quantity without a unit.

use super::{Check, Example, Levels, Rule, Sink, Subject};
use crate::diagnostic::Level;
use crate::schema::Element;

pub(super) const RULE: Rule = Rule {
    id: "unit-missing",
    purpose: "A field of floats states its unit, `[-]` where it has none. Without it, readers guess between \
              degrees and radians, and nobody can check the guess.",
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
    measured: None,
    check: Check::Message(check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    for (field, _) in subject.fields() {
        let is_float = matches!(field.ty.element, Element::Scalar(scalar) if scalar.is_float());
        if is_float && field.unit.is_none() && field.enum_prefixes.is_empty() {
            sink.report(
                field.span,
                format!("`{}` has no unit", field.name),
                "state it at the head of the comment: `# [m/s] …`, or `[-]` for a plain number",
            );
        }
    }
}
