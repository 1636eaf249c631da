//! `PX-JSON-01`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};
use crate::rules::sample::{PERIOD, ROUNDS, START};

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-JSON-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "A message in JSON has exactly the fields of its definition: none is missing, unknown or there twice.",
        source: "the fields of the definition; the published JSON Schema",
        applies_to: "messages as JSON",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Value,
    mutants: &[
        Mutant {
            name: "a field is missing",
            change: Change::Flight(|flight| {
                flight.with_last(0, |message| {
                    if let Some(fields) = message.as_object_mut() {
                        let last = fields.keys().next_back().cloned();
                        last.and_then(|last| fields.remove(&last));
                    }
                })
            }),
            also: &[],
        },
        Mutant {
            name: "a field that the definition doesn't have",
            change: Change::Flight(|flight| flight.with_last(0, |message| message["tow"] = 1.into())),
            also: &[],
        },
        Mutant {
            name: "a field stands twice",
            change: Change::Json(|lines| {
                let time = format!("\"timestamp\":{}", START + (ROUNDS - 1) * PERIOD);
                lines.with_text(&time, &format!("{time},{time}"))
            }),
            also: &[],
        },
    ],
};
