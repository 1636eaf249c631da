//! `PX-FMT-01`.

use super::prelude::*;

/// The rule.
pub static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-FMT-01",
    name: "Format matches the definition",
    level: Level::Info,
    status: Status::Advisory,
    statement: "A format in a capture has the same fields as the definition, with the same order, types, \
                array lengths and padding. Formats differ between firmware versions, so uavspec reports \
                differences as violations only if `--strict-formats` is set.",
    source: "the definition",
    applies_to: "logs and MCAP schemas",
    why: "If the format differs, software built from the definition reads wrong values or no values, \
          unless it uses the format in the capture.",
    example: "definition: float32 remaining\n\
              format:     …uint8_t remaining;…",
    fix: "Use the definitions of the firmware that wrote the capture, or update the firmware. A capture \
          from a different firmware version needs no change.",
})
.check(Check::Source)
.mutants(&[
    Mutant::ulog("a renamed field", |flight, mut log| {
        let (topic, name) = second_field(flight)?;
        let fields = log.format_mut(&flight.topics[topic].name)?;
        *fields = fields.replace(&format!(" {name};"), &format!(" {name}_before;"));
        Some(log)
    }),
    Mutant::mcap("a renamed field in a schema", |flight, mut bag| {
        let (topic, name) = second_field(flight)?;
        let text = &mut bag.channels[topic].text;
        let line = text.lines().find(|line| line.split_whitespace().nth(1) == Some(name))?.to_owned();
        *text = text.replacen(&line, &line.replacen(&format!(" {name}"), &format!(" {name}_before"), 1), 1);
        Some(bag)
    }),
]);

/// Finds a topic and the name of its second field.
fn second_field<'d>(flight: &Flight<'d>) -> Option<(usize, &'d str)> {
    let topic = flight.regular(|message| message.fields.get(1).is_some())?;
    Some((topic, &*flight.type_of(topic).fields().get(1)?.name))
}
