//! `PX-NAN-01`.

use super::{Check, Level, Mutant, Px4Rule, Rule, Status};
use uavspec_runtime::Rule as Broken;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-NAN-01",
        level: Level::Should,
        status: Status::Advisory,
        statement: "NaN stands only where the definition gives it a meaning; so in fields that it restricts.",
        source: "`@invalid NaN` of the definition, or its text",
        applies_to: "values of messages",
    },
    check: Check::Value,
    mutants: &[
        Mutant {
            name: "NaN without a meaning, in a log",
            make: |flight| Some(flight.breaking(Broken::Nan)?.log().to_bytes()),
            also: &[],
        },
        Mutant {
            name: "NaN without a meaning, as JSON",
            make: |flight| Some(flight.breaking(Broken::Nan)?.lines().to_bytes()),
            also: &[],
        },
        Mutant {
            name: "NaN without a meaning, in MCAP",
            make: |flight| Some(flight.breaking(Broken::Nan)?.bag().to_bytes()),
            also: &[],
        },
    ],
};
