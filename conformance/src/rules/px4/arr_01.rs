//! `PX-ARR-01`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};
use crate::rules::sample::Flight;
use serde_json::Value;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-ARR-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "In JSON an array has its defined length, and a sequence, a string or the text of a `char` array keeps its bound.",
        source: "the type of the definition, `T[N]`, `T[<=N]`, `string<=N`, `char[N]`",
        applies_to: "messages as JSON",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Value,
    mutants: &[
        Mutant {
            name: "an array without its last element",
            change: Change::Flight(|flight| {
                let (topic, name) = array(flight)?;
                flight.with_last(topic, |message| _ = message[&name].as_array_mut().and_then(Vec::pop))
            }),
            also: &[],
        },
        Mutant {
            name: "an array with an element more",
            change: Change::Flight(|flight| {
                let (topic, name) = array(flight)?;
                flight.with_last(topic, |message| {
                    if let Some(elements) = message[&name].as_array_mut() {
                        elements.extend(elements.last().cloned());
                    }
                })
            }),
            also: &[],
        },
    ],
};

/// A topic with an array of numbers, and its name.
fn array(flight: &Flight<'_>) -> Option<(usize, String)> {
    let of_numbers =
        |value: &Value| value.as_array().and_then(|array| array.first()).is_some_and(Value::is_number);
    flight.messages.iter().find_map(|sent| {
        let (name, _) = sent.value.as_object()?.iter().find(|(_, value)| of_numbers(value))?;
        Some((sent.topic, name.clone()))
    })
}
