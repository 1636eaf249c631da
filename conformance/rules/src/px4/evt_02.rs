//! `PX-EVT-02`.

use uavspec_types::px4::ArmingCheckReply;

use super::evt::Each;
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EVT-02",
    name: "Known events",
    level: Level::Info,
    status: Status::Advisory,
    statement: "The event metadata defines every event, including the events in an ArmingCheckReply.",
    source: "event metadata (`event_groups`)",
    applies_to: "message values",
    why: "A ground station shows nothing for an event without metadata. If it is the reason why the \
          vehicle can't arm, the operator sees no reason.",
    example: "{…, \"id\": 16909060, …}        (component 1 has no event 131844)",
    fix: "Add the event to the metadata: PX4's build collects it from the call to `events::send` or from \
          the comment above it. Add the events of external components to the same file; `--events` \
          applies only to captures without metadata.",
})
.check(Check::State(|| {
    Box::new(Each(|event, events| {
        let unknown = events.get(event.id).is_none();
        let detail =
            || Detail::new("the event metadata has no event with this id").actual(event.id.to_string());
        unknown.then(|| ("id", detail()))
    }))
}))
.bug(Bug::message(Side::Component, "The reason for a refusal is an event with an unknown id.", |out| {
    out.edit(1, |reply: &mut ArmingCheckReply| reply.events[0].id = UNKNOWN);
}))
.mutants(&[
    Mutant::flight_in("an event that is missing from the metadata", &[Encoding::Ulog], |flight| {
        flight.with_event(3, |event| event["id"] = UNKNOWN.into())
    }),
    Mutant::flight_in("a reason that is missing from the metadata", &[Encoding::Ulog], |flight| {
        flight.with_refusal(|reply| reply["events"][0]["id"] = UNKNOWN.into())
    }),
]);

/// An event id that no component of the sample uses.
const UNKNOWN: u32 = 0x0102_0304;
