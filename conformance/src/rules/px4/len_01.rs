//! `PX-LEN-01`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};
use uavspec_runtime::Rule as Violated;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-LEN-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "A count of entries in use is at most the length of the array that it counts.",
        source: "`@count` of the definition, or the names `num_x` and `x_count`",
        applies_to: "values of messages",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Value,
    mutants: &[Mutant {
        name: "one entry more in use than the array has",
        change: Change::Flight(|flight| flight.violating(Violated::Count)),
        also: &[],
    }],
};
