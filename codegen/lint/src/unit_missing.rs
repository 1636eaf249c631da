//! `unit-missing`: a float field without a unit.

use uavspec_schema::Field;

use super::prelude::*;
use super::quantity::{self, Groups};

pub(super) const RULE: Rule = Rule {
    id: "unit-missing",
    statement: "A float field without a unit.",
    why: "Readers have to guess the unit, such as degrees or radians, and no tool can detect a wrong guess. A field \
        is not reported if it has a range from 0 or -1 to 1, if its comment or name says that it is a plain number, \
        such as a ratio, a factor, a quaternion or a normalised value, or if it can hold any quantity, such as \
        `value`.",
    fix: "Write the unit at the start of the comment, or `[-]` for a number without a unit. If the unit is not known, \
        write `no unit is defined`. If the comment states a unit in another form, such as `(m/s)`, the finding \
        suggests the annotation.",
    levels: Levels::both(Level::Warning),
    bad: glider!["float32 bank      # Bank angle"],
    good: glider!["float32 bank      # [rad] Bank angle"],
    measured: Some(Measured { findings: 435, sample: 30, right: 27 }),
    check: Check::Message(Scope::Px4, check),
};

/// Phrases stating that the unit is undefined, in which case `[-]` would be wrong.
const UNDEFINED: [&str; 4] =
    ["no unit is defined", "unit is not defined", "unit isn't defined", "unit is unknown"];

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let groups = Groups::new(subject.message);
    for (field, _) in subject.fields() {
        let is_float = field.ty.element.is_float();
        if is_float && field.enum_prefixes.is_empty() && lacks_unit(field, &groups) {
            let help = quantity::advice(field, "m/s");
            sink.report(field.span, format!("`{}` has no unit", field.name), help);
        }
    }
}

/// True if a field needs a unit, but has no unit in an annotation.
pub(super) fn lacks_unit(field: &Field, groups: &Groups) -> bool {
    let is_undefined = || UNDEFINED.iter().any(|words| field.description.contains(words));
    field.unit.is_none()
        && !is_undefined()
        && !quantity::is_dimensionless(field, groups)
        && !quantity::is_container(field)
}
