//! `unit-missing`: a float field without a unit.

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::{Element, Field};

pub(super) const RULE: Rule = Rule {
    id: "unit-missing",
    statement: "A float field without a unit.",
    why: "Readers have to guess the unit, such as degrees or radians, and no tool can detect a wrong guess.",
    fix: "Write the unit at the start of the comment, or `[-]` for a number without a unit. If the unit is not known, \
        write `no unit is defined`.",
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
    measured: Some(Measured { findings: 527, sample: 30, right: 28 }),
    check: Check::Message(check),
};

/// Phrases stating that the unit is undefined, in which case `[-]` would be wrong.
const UNDEFINED: [&str; 4] =
    ["no unit is defined", "unit is not defined", "unit isn't defined", "unit is unknown"];

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !subject.is_px4() {
        return;
    }
    for (field, _) in subject.fields() {
        let is_float = matches!(field.ty.element, Element::Scalar(scalar) if scalar.is_float());
        if is_float && field.unit.is_none() && field.enum_prefixes.is_empty() && !has_undefined_unit(field) {
            sink.report(
                field.span,
                format!("`{}` has no unit", field.name),
                "write it at the start of the comment: `# [m/s] …`, or `[-]` for a plain number",
            );
        }
    }
}

/// True if the comment of a field states that its unit is not defined.
pub(super) fn has_undefined_unit(field: &Field) -> bool {
    UNDEFINED.iter().any(|words| field.description.contains(words))
}
