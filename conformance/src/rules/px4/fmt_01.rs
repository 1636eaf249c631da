//! `PX-FMT-01`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};
use crate::rules::sample::Flight;

pub(crate) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-FMT-01",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A format that a log brings equals the definition: fields, order, types, lengths of arrays, padding. Logs of other firmware differ without being wrong, so this is shown and judged only with `--strict-formats`.",
        source: "the definition",
        applies_to: "logs",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Source,
    mutants: &[
        Mutant {
            name: "a field has another name",
            change: Change::Ulog(|flight, mut log| {
                let (topic, name) = second_field(flight)?;
                let fields = log.format_mut(&flight.topics[topic].name)?;
                *fields = fields.replace(&format!(" {name};"), &format!(" {name}_before;"));
                Some(log)
            }),
            also: &[],
        },
        Mutant {
            name: "a schema with another name of a field",
            change: Change::Mcap(|flight, mut bag| {
                let (topic, name) = second_field(flight)?;
                let text = &mut bag.channels[topic].text;
                *text = text.replacen(&format!(" {name}\n"), &format!(" {name}_before\n"), 1);
                Some(bag)
            }),
            also: &[],
        },
    ],
};

/// A topic, and the name of a field that isn't its time.
fn second_field<'d>(flight: &Flight<'d>) -> Option<(usize, &'d str)> {
    let topic = flight.regular(|message| message.fields.get(1).is_some())?;
    Some((topic, flight.type_of(topic).field_names().nth(1)?))
}
