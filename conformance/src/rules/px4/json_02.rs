//! `PX-JSON-02`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-JSON-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "Each value in JSON has the JSON type of its field and lies in the range of its type; a float that is NaN is null, infinity can't be said.",
        source: "the type of the definition; RFC 8259 for numbers",
        applies_to: "messages as JSON",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Value,
    mutants: &[
        Mutant {
            name: "a bool is a number",
            change: Change::Json(|lines| lines.with_text(":true", ":1")),
            also: &[],
        },
        Mutant {
            name: "an integer is a string",
            change: Change::Flight(|flight| flight.with_last(0, |message| message["timestamp"] = "1".into())),
            also: &[],
        },
        Mutant {
            name: "an integer is out of the range of its type",
            change: Change::Flight(|flight| {
                flight.with_last(0, |message| message["timestamp"] = (-1).into())
            }),
            also: &[],
        },
    ],
};
