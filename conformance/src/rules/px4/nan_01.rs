//! `PX-NAN-01`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};
use uavspec_runtime::Rule as Violated;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-NAN-01",
        level: Level::Should,
        status: Status::Advisory,
        statement: "NaN stands only where the definition gives it a meaning; so in fields that it restricts.",
        source: "`@invalid NaN` of the definition, or its text",
        applies_to: "values of messages",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Value,
    mutants: &[Mutant {
        name: "NaN without a meaning",
        change: Change::Flight(|flight| flight.violating(Violated::Nan)),
        also: &[],
    }],
};
