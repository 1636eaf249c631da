//! `enum-of-bits`: a field with `@enum` whose constants are bits.

use std::collections::BTreeMap;

use uavspec_schema::{EnumRef, Field, Schema, bits};

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "enum-of-bits",
    statement: "A field that has `@enum` although its constants are bit flags.",
    why: "With `@enum`, every combination of bits counts as an unknown value. PX4's own tools do not \
        support `@flags` yet.",
    fix: "Write `[@flags PREFIX]`.",
    levels: Levels::strict(Level::Warning),
    bad: glider![
        "uint8 LIGHT_NOSE = 1   # In the nose",
        "uint8 LIGHT_LEFT = 2   # On the left wing",
        "uint8 LIGHT_RIGHT = 4  # On the right wing",
        "uint8 LIGHT_TAIL = 8   # In the tail",
        "",
        "uint8 lights  # [@enum LIGHT] Lights that are on"
    ],
    good: glider![
        "uint8 LIGHT_NOSE = 1   # In the nose",
        "uint8 LIGHT_LEFT = 2   # On the left wing",
        "uint8 LIGHT_RIGHT = 4  # On the right wing",
        "uint8 LIGHT_TAIL = 8   # In the tail",
        "",
        "uint8 lights  # [@flags LIGHT] Lights that are on"
    ],
    measured: Some(Measured { findings: 4, sample: 4, right: 4 }),
    check: Check::Message(Scope::All, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let mut known = Bits::default();
    for field in &subject.message.fields {
        let Some(reference) = field.enumeration else { continue };
        if !subject.schema.enumeration(reference).is_flags && known.are_bits(field, reference, subject.schema)
        {
            sink.report(
                field.span,
                format!("the constants of `{}` are bit flags", field.name),
                format!("write `[@flags {}]`", field.enum_prefixes.join(" ")),
            );
        }
    }
}

/// A cache that records which enums consist of bits, because many fields may use the same enum.
#[derive(Default)]
pub(super) struct Bits {
    known: BTreeMap<EnumRef, bool>,
}

impl Bits {
    /// True if the constants of a field are bits, regardless of the field's annotation.
    pub(super) fn are_bits(&mut self, field: &Field, reference: EnumRef, schema: &Schema) -> bool {
        let check = || bits::are_bits(schema.enumeration(reference), schema.message(reference.message));
        *self.known.entry(reference).or_insert_with(check) || bits::mentions_bits(field)
    }
}
