//! `enum-type`: constants of a wider type than the field that holds them.

use uavspec_runtime::Scalar;

use super::{Check, Example, Levels, Rule, Sink, Subject, enum_of_bits};
use crate::diagnostic::Level;
use crate::schema::Element;

pub(super) const RULE: Rule = Rule {
    id: "enum-type",
    purpose: "The field that holds the constants of an enum has a type that holds all of theirs. What is \
              assigned from a wider one is cut without a word; one of the two types is a slip.",
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
        // Numbers of bits need no type as wide as the mask, and no mask is as wide as all its bits.
        if enum_of_bits::is_meant(found, owner, field) {
            continue;
        }
        let constants = found.members.iter().map(|member| &owner.constants[member.constant]);
        let wider = constants.filter_map(|constant| match constant.ty {
            Element::Scalar(scalar) if !is_within(scalar, found.scalar) => Some((constant, scalar)),
            _ => None,
        });
        let Some((constant, scalar)) = wider.into_iter().next() else { continue };
        sink.report(
            field.span,
            format!("`{}` is a `{}`, its constants are `{}`", field.name, found.scalar.name(), scalar.name()),
            "give both one type",
        )
        .relate(constant.span, "one of its constants");
    }
}

/// Whether a type holds all values of another.
fn is_within(scalar: Scalar, other: Scalar) -> bool {
    match (scalar.integer_bounds(), other.integer_bounds()) {
        (Some((least, greatest)), Some((low, high))) => low <= least && greatest <= high,
        _ => true,
    }
}
