//! `enum-type`: constants of another type than the field that holds them.

use super::{Check, Example, Levels, Rule, Sink, Subject};
use crate::diagnostic::Level;
use crate::schema::{Element, Enum};

pub(super) const RULE: Rule = Rule {
    id: "enum-type",
    purpose: "The constants of an enum have the type of the field that holds them. Of two types one is a slip, \
              and what is assigned between them is converted or cut.",
    levels: Levels::both(Level::Note),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               int32 GEAR_UP = 0    # Retracted\nint32 GEAR_DOWN = 1  # Extended\n\n\
               uint8 gear  # [@enum GEAR] Landing gear\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 GEAR_UP = 0    # Retracted\nuint8 GEAR_DOWN = 1  # Extended\n\n\
               uint8 gear  # [@enum GEAR] Landing gear\n",
    },
    measured: None,
    check: Check::Message(check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    for field in &subject.message.fields {
        let Some(reference) = field.enumeration else { continue };
        let found = subject.schema.enumeration(reference);
        let owner = subject.schema.message(reference.message);
        let other = found
            .members
            .iter()
            .map(|member| &owner.constants[member.constant])
            .find(|constant| constant.ty != Element::Scalar(found.scalar) && !are_bit_numbers(found));
        let Some(constant) = other else { continue };
        let Element::Scalar(scalar) = constant.ty else { continue };
        sink.report(
            field.span,
            format!("`{}` is a `{}`, its constants are `{}`", field.name, found.scalar.name(), scalar.name()),
            "give both one type",
        )
        .relate(constant.span, "one of its constants");
    }
}

/// Numbers of bits need no type as wide as the mask.
fn are_bit_numbers(found: &Enum) -> bool {
    found.is_flags
}
