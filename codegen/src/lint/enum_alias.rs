//! `enum-alias`: two names of one value.

use std::collections::{BTreeMap, BTreeSet};

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "enum-alias",
    purpose: "Each constant of an enum has a value of its own. Where two share one, only the first can be \
              shown, and one of them may be a slip.",
    levels: Levels::both(Level::Note),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 GEAR_UP = 0      # Retracted\nuint8 GEAR_DOWN = 1    # Extended\n\
               uint8 GEAR_MOVING = 1  # On its way\n\nuint8 gear  # [@enum GEAR] Landing gear\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 GEAR_UP = 0      # Retracted\nuint8 GEAR_DOWN = 1    # Extended\n\
               uint8 GEAR_MOVING = 2  # On its way\n\nuint8 gear  # [@enum GEAR] Landing gear\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0, remark: "" }),
    check: Check::Message(check),
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
            // An enum that two fields hold in two types is two.
            if reported.insert(member.constant) {
                let (constant, known) = (&constants[member.constant], &constants[*known]);
                sink.report(
                    constant.span,
                    format!("`{}` has the value of `{}`", constant.name, known.name),
                    "give it a value of its own, or remove it",
                )
                .relate(known.span, "the first of that value");
            }
        }
    }
}
