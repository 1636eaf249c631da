//! `PX-ENUM-01`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};
use uavspec_runtime::Rule as Violated;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-ENUM-01",
        level: Level::Should,
        status: Status::Normative,
        statement: "A field with an `@enum` holds a documented constant, one with `@flags` a mask of them.",
        source: "`@enum` and `@flags` of the definition",
        applies_to: "values of messages",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Value,
    mutants: &[Mutant {
        name: "a value that is not documented",
        change: Change::Flight(|flight| flight.violating(Violated::Enum)),
        also: &[],
    }],
};
