//! `PX-ENUM-01`.

use super::{Check, Level, Mutant, Px4Rule, Rule, Status};
use uavspec_runtime::Rule as Broken;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-ENUM-01",
        level: Level::Should,
        status: Status::Normative,
        statement: "A field with an `@enum` holds a documented constant, one with `@flags` a mask of them.",
        source: "`@enum` and `@flags` of the definition",
        applies_to: "values of messages",
    },
    check: Check::Value,
    mutants: &[
        Mutant {
            name: "a value that is not documented, in a log",
            make: |flight| Some(flight.breaking(Broken::Enum)?.log().to_bytes()),
            also: &[],
        },
        Mutant {
            name: "a value that is not documented, as JSON",
            make: |flight| Some(flight.breaking(Broken::Enum)?.lines().to_bytes()),
            also: &[],
        },
        Mutant {
            name: "a value that is not documented, in MCAP",
            make: |flight| Some(flight.breaking(Broken::Enum)?.bag().to_bytes()),
            also: &[],
        },
    ],
};
