//! `PX-ARR-01`.

use serde_json::Value;

use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-ARR-01",
    name: "Lengths of arrays and strings in JSON",
    level: Level::Must,
    status: Status::Normative,
    statement: "In JSON, each array has its defined length. Sequences, strings and the text of `char` \
                arrays do not exceed their bounds.",
    source: "field type in the definition: `T[N]`, `T[<=N]`, `string<=N`, `char[N]`",
    applies_to: "JSON messages",
    why: "A reader with fixed-size arrays can't store an array of a different length. It rejects the \
          message, drops elements or adds elements.",
    example: "definition: float32[14] voltage_cell_v\n\
              message:    {…, \"voltage_cell_v\": [4.1, 4.1, 4.0], …}",
    fix: "Write all elements of an array, and fill unused elements with the value for missing data. \
          Shorten sequences and text to their bounds.",
})
.check(Check::Value)
.mutants(&[
    Mutant::flight("an array without its last element", |flight| {
        let (topic, name) = array(flight)?;
        flight.with_last(topic, |message| _ = message[&name].as_array_mut().and_then(Vec::pop))
    }),
    Mutant::flight("an array with an extra element", |flight| {
        let (topic, name) = array(flight)?;
        flight.with_last(topic, |message| {
            if let Some(elements) = message[&name].as_array_mut() {
                elements.extend(elements.last().cloned());
            }
        })
    }),
]);

/// Finds a topic with an array of numbers. Returns the topic's index and the array's name.
fn array(flight: &Flight<'_>) -> Option<(usize, String)> {
    let is_numeric =
        |value: &Value| value.as_array().and_then(|array| array.first()).is_some_and(Value::is_number);
    flight.messages.iter().find_map(|sent| {
        let (name, _) = sent.value.as_object()?.iter().find(|(_, value)| is_numeric(value))?;
        Some((sent.topic, name.clone()))
    })
}
