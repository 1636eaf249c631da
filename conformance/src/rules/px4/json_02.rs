//! `PX-JSON-02`.

use super::{Check, Level, Mutant, Px4Rule, Rule, Status};

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-JSON-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "Each value in JSON has the JSON type of its field and lies in the range of its type; a float that is NaN is null, infinity can't be said.",
        source: "the type of the definition; RFC 8259 for numbers",
        applies_to: "messages as JSON",
    },
    check: Check::Value,
    mutants: &[
        Mutant {
            name: "a bool is a number",
            make: |flight| Some(flight.lines().with_text(":true", ":1")?.to_bytes()),
            also: &[],
        },
        Mutant {
            name: "an integer is a string",
            make: |flight| {
                Some(flight.with_last(0, |message| message["timestamp"] = "1".into())?.rosbridge().to_bytes())
            },
            also: &[],
        },
        Mutant {
            name: "an integer is out of the range of its type",
            make: |flight| {
                Some(flight.with_last(0, |message| message["timestamp"] = (-1).into())?.lines().to_bytes())
            },
            also: &[],
        },
    ],
};
