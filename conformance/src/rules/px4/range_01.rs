//! `PX-RANGE-01`.

use super::{Check, Level, Mutant, Px4Rule, Rule, Status};
use uavspec_runtime::Rule as Broken;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-RANGE-01",
        level: Level::Should,
        status: Status::Normative,
        statement: "A value lies in its range, unless it is the one that says that there is no data.",
        source: "`@range` and `@invalid` of the definition",
        applies_to: "values of messages",
    },
    check: Check::Value,
    mutants: &[
        Mutant {
            name: "a value out of its range, in a log",
            make: |flight| Some(flight.breaking(Broken::Range)?.log().to_bytes()),
            also: &[],
        },
        Mutant {
            name: "a value out of its range, as JSON",
            make: |flight| Some(flight.breaking(Broken::Range)?.lines().to_bytes()),
            also: &[],
        },
        Mutant {
            name: "a value out of its range, in MCAP",
            make: |flight| Some(flight.breaking(Broken::Range)?.bag().to_bytes()),
            also: &[],
        },
    ],
};
