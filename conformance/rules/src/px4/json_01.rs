//! `PX-JSON-01`.

use super::prelude::*;
use crate::sample::{PERIOD, ROUNDS, START};

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-JSON-01",
    name: "Fields in JSON",
    level: Level::Must,
    status: Status::Normative,
    statement: "A JSON message has exactly the fields of its definition: no field is missing, unknown or \
                duplicated.",
    source: "the fields in the definition; the published JSON Schema",
    applies_to: "JSON messages",
    why: "Readers reject the message if a field is missing. Readers may ignore a field with a misspelt \
          name, so the field's value is lost.",
    example: "ArmingCheckRequest:\n\
              {\"timestamp\": 1000000, \"requestId\": 42, \"valid_registrations_mask\": 8}",
    fix: "Write each field of the definition exactly once, under its defined name. Validate the messages \
          against the JSON Schema.",
})
.check(Check::Value)
.mutants(&[
    Mutant::flight("a missing field", |flight| {
        flight.with_last(0, |message| {
            if let Some(fields) = message.as_object_mut() {
                let last = fields.keys().next_back().cloned();
                last.and_then(|last| fields.remove(&last));
            }
        })
    }),
    Mutant::flight("an unknown field", |flight| flight.with_last(0, |message| message["tow"] = 1.into())),
    Mutant::json("a duplicate field", |lines| {
        let time = format!("\"timestamp\":{}", START + (ROUNDS - 1) * PERIOD);
        lines.with_text(&time, &format!("{time},{time}"))
    }),
]);
