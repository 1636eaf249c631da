//! `enum-type`: constants with a wider type than their field.

use std::collections::BTreeMap;

use uavspec_runtime::Scalar;
use uavspec_schema::{Constant, Element, EnumRef, Schema};

use super::enum_of_bits;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "enum-type",
    statement: "An enum whose constants have a wider type than the field.",
    why: "Code that assigns a constant to the field truncates the value without a warning, so one of \
        the two types must be wrong.",
    fix: "Use the same type for the field and its constants.",
    levels: Levels::both(Level::Note),
    bad: glider![
        "int32 GEAR_UP = 0    # Retracted",
        "int32 GEAR_DOWN = 1  # Extended",
        "",
        "uint8 gear  # [@enum GEAR] Landing gear"
    ],
    good: glider![
        "uint8 GEAR_UP = 0    # Retracted",
        "uint8 GEAR_DOWN = 1  # Extended",
        "",
        "uint8 gear  # [@enum GEAR] Landing gear"
    ],
    measured: Some(Measured { findings: 1, sample: 1, right: 1 }),
    check: Check::Message(Scope::All, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let mut bits = enum_of_bits::Bits::default();
    let mut known: BTreeMap<EnumRef, Option<(&Constant, Scalar)>> = BTreeMap::new();
    for field in &subject.message.fields {
        let Some(reference) = field.enumeration else { continue };
        let wider = *known.entry(reference).or_insert_with(|| wider(reference, subject.schema));
        let Some((constant, scalar)) = wider else { continue };
        // Skip a bit-mask field, whose type may differ from the type of its constants, because these may be bit
        // numbers.
        if bits.are_bits(field, reference, subject.schema) {
            continue;
        }
        let held = subject.schema.enumeration(reference).scalar.name();
        sink.report(
            field.span,
            format!("`{}` is a `{held}`, but its constants are `{}`", field.name, scalar.name()),
            "use the same type for both",
        )
        .relate(constant.span, "a constant of the enum");
    }
}

/// Finds the first constant whose type is wider than the field's type, and returns the constant with its type.
fn wider(reference: EnumRef, schema: &Schema) -> Option<(&Constant, Scalar)> {
    let found = schema.enumeration(reference);
    let constants = &schema.message(reference.message).constants;
    found.members.iter().map(|member| &constants[member.constant]).find_map(|constant| match constant.ty {
        Element::Scalar(scalar) if !is_within(scalar, found.scalar) => Some((constant, scalar)),
        _ => None,
    })
}

/// True if all values of `scalar` are also values of `other`.
fn is_within(scalar: Scalar, other: Scalar) -> bool {
    match (scalar.integer_bounds(), other.integer_bounds()) {
        (Some((min, max)), Some((low, high))) => low <= min && max <= high,
        _ => true,
    }
}
