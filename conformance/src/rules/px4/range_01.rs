//! `PX-RANGE-01`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};
use uavspec_runtime::Rule as Violated;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-RANGE-01",
        level: Level::Should,
        status: Status::Normative,
        statement: "A value lies in its range, unless it is the one that says that there is no data.",
        source: "`@range` and `@invalid` of the definition",
        applies_to: "values of messages",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Value,
    mutants: &[Mutant {
        name: "a value out of its range",
        change: Change::Flight(|flight| flight.violating(Violated::Range)),
        also: &[],
    }],
};
