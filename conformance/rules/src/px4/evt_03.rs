//! `PX-EVT-03`.

use uavspec_types::px4::ArmingCheckReply;

use super::evt::Each;
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EVT-03",
    name: "Bytes after event arguments",
    level: Level::Should,
    status: Status::Normative,
    statement: "The bytes after the arguments of an event are zero.",
    source: "event metadata (`arguments`), and PX4's function `events::send`",
    applies_to: "message values",
    why: "If other bytes follow, the sender has written arguments that differ from the metadata, and \
          ground stations show wrong values. For example, padding shifts all later arguments.",
    example: "arguments in the metadata: uint32_t modes, uint8_t component, uint8_t sensor\n\
              bytes:                     ff ff 00 00 00 00 03 02 00 …   (shifted by two)",
    fix: "Write the arguments in the order and with the types of the metadata, without padding.",
})
.check(Check::State(|| {
    Box::new(Each(|event, events| {
        let (_, known) = events.get(event.id)?;
        let rest = event.used().get(known.size()..).filter(|rest| !rest.is_empty())?;
        let bytes: Vec<String> = rest.iter().map(|byte| format!("{byte:02x}")).collect();
        let text =
            format!("the {} argument bytes of {} are followed by nonzero bytes", known.size(), known.name);
        Some(("arguments", Detail::new(text).expected("only zeros").actual(bytes.join(" "))))
    }))
}))
.bug(Bug::message(Side::Component, "The arguments of the reason are shifted by two bytes.", |out| {
    out.edit(1, |reply: &mut ArmingCheckReply| reply.events[0].arguments.rotate_right(2));
}))
.mutants(&[
    Mutant::flight_in("an event with shifted arguments", &[Encoding::Ulog], |flight| {
        flight.with_event(3, shift)
    }),
    Mutant::flight_in("a reason with shifted arguments", &[Encoding::Ulog], |flight| {
        flight.with_refusal(|reply| shift(&mut reply["events"][0]))
    }),
]);

/// Moves the arguments of an event by two bytes.
fn shift(event: &mut serde_json::Value) {
    if let Some(arguments) = event["arguments"].as_array_mut() {
        arguments.rotate_right(2);
    }
}
