//! `PX-EVT-04`.

use uavspec_dynamic::event::EventValue;

use super::evt::Each;
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EVT-04",
    name: "Enums in events",
    level: Level::Should,
    status: Status::Normative,
    statement: "An argument whose type is an enum has one of its values. Bit fields aren't checked, \
                because PX4 sets bits of unnamed modes.",
    source: "event metadata (`enums`)",
    applies_to: "message values",
    why: "Ground stations show `(unknown: 99)`, so the operator doesn't see what the value means.",
    example: "commander_disarmed_by, reason: 99     (arm_disarm_reason_t ends with 14)",
    fix: "Send a value of the enum, or add the value to the enum in the metadata.",
})
.check(Check::State(|| {
    Box::new(Each(|event, events| {
        let event = event.decode(events).ok()?;
        event.event.arguments.iter().zip(&event.values).find_map(|(argument, value)| {
            let (known, EventValue::Integer(value)) = (events.enumeration(argument)?, value) else {
                return None;
            };
            let is_known =
                known.separator.is_some() || known.entries.iter().any(|entry| entry.value == *value);
            let text =
                || format!("{} of {} is not a value of {}", argument.name, event.event.name, known.name);
            (!is_known).then(|| ("arguments", Detail::new(text()).actual(value.to_string())))
        })
    }))
}))
.mutants(&[Mutant::flight_in("a reason for arming that doesn't exist", &[Encoding::Ulog], |flight| {
    flight.with_event(3, |event| event["arguments"][0] = 99.into())
})]);
