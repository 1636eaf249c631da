//! `PX-JSON-02`.

use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-JSON-02",
    name: "Value types in JSON",
    level: Level::Must,
    status: Status::Normative,
    statement: "Each JSON value has the JSON type of its field and is in the range of the field's type. \
                NaN is written as `null`; infinity can't be represented.",
    source: "the field types in the definition; RFC 8259 for numbers",
    applies_to: "JSON messages",
    why: "Readers in typed languages reject the whole message. Other readers convert the value and \
          continue with a wrong value.",
    example: "ArmingCheckRequest:\n\
              {\"timestamp\": 1000000, \"request_id\": 300, \"valid_registrations_mask\": \"8\"}",
    fix: "Write integers as numbers in the range of their type, bools as `true` or `false`, and NaN as \
          `null`.",
})
.check(Check::Value)
.mutants(&[
    Mutant::json("a number in place of a bool", |lines| lines.with_text(":true", ":1")),
    Mutant::flight("a string in place of an integer", |flight| {
        flight.with_last(0, |message| message["timestamp"] = "1".into())
    }),
    Mutant::flight("an integer outside the range of its type", |flight| {
        flight.with_last(0, |message| message["timestamp"] = (-1).into())
    }),
]);
