//! `enum-alias`: two constants with the same value.

use std::collections::{BTreeMap, BTreeSet};

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "enum-alias",
    statement: "Two constants of one enum that have the same value.",
    why: "Tools can show only the first name, and one of the two values may be a mistake.",
    fix: "Give each constant a unique value, or remove one of them.",
    levels: Levels::both(Level::Note),
    bad: glider![
        "uint8 GEAR_UP = 0      # Retracted",
        "uint8 GEAR_DOWN = 1    # Extended",
        "uint8 GEAR_MOVING = 1  # Moving",
        "",
        "uint8 gear  # [@enum GEAR] Landing gear"
    ],
    good: glider![
        "uint8 GEAR_UP = 0      # Retracted",
        "uint8 GEAR_DOWN = 1    # Extended",
        "uint8 GEAR_MOVING = 2  # Moving",
        "",
        "uint8 gear  # [@enum GEAR] Landing gear"
    ],
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Message(Scope::All, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let constants = &subject.message.constants;
    let mut reported = BTreeSet::new();
    for found in &subject.message.enums {
        let mut first = BTreeMap::new();
        for member in &found.members {
            let Some(known) = first.get(&member.value) else {
                first.insert(member.value, member.constant);
                continue;
            };
            // Report each alias once, although two fields of different types result in two enums.
            if reported.insert(member.constant) {
                let (constant, known) = (&constants[member.constant], &constants[*known]);
                sink.report(
                    constant.span,
                    format!("`{}` has the same value as `{}`", constant.name, known.name),
                    "give it a different value, or remove it",
                )
                .relate(known.span, "first constant with this value");
            }
        }
    }
}
