//! `PX-BOOL-01`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};
use uavspec_codegen::dynamic::{Placed, PlacedElement};
use uavspec_runtime::Scalar;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-BOOL-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "A byte of a bool is 0 or 1.",
        source: "`bool` of the definition; PX4 copies the byte from memory",
        applies_to: "payloads in memory",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Value,
    mutants: &[Mutant {
        name: "the byte of a bool is 153",
        change: Change::Ulog(|flight, log| {
            let is_bool = |field: &Placed<'_>| matches!(field.element, PlacedElement::Scalar(Scalar::Bool));
            let (topic, at) = flight.find_field(is_bool)?;
            log.with_payload(topic, |payload| payload[at] = 153)
        }),
        also: &[],
    }],
};
