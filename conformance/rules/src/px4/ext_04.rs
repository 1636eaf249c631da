//! `PX-EXT-04`.

use uavspec_dynamic::Value;
use uavspec_types::px4::ArmingCheckReply;

use super::ext::{is_reply, number};
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EXT-04",
    name: "Events of an arming check reply",
    level: Level::Must,
    status: Status::Normative,
    statement: "In an ArmingCheckReply, the first `num_events` entries of `events` have an `id` other \
                than 0. Later entries are ignored.",
    source: "`num_events` and `events` of ArmingCheckReply, `id` of Event",
    applies_to: "message values",
    why: "Ground stations look up the text of an event by its id, and 0 means no event. If the id is 0, \
          the operator can't see why the vehicle doesn't arm.",
    example: "{…, \"num_events\": 2, \"events\": [{\"id\": 1011, …}, {\"id\": 0, …}, …], …}",
    fix: "Set `num_events` to the number of events that you write. Set the `id` of each event to an id \
          from the event metadata.",
})
.check(Check::State(|| Box::new(Reasons)))
.bug(Bug::message(Side::Component, "The events of ArmingCheckReply have `id` 0.", |out| {
    out.edit(1, |reply: &mut ArmingCheckReply| reply.events.iter_mut().for_each(|event| event.id = 0));
}))
.mutants(&[Mutant::flight("an event without an id", without_id)]);

struct Reasons;

impl Checker for Reasons {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        if is_reply(channel, context) { Interest::Values } else { Interest::Nothing }
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let Some(values) = message.values else { return };
        let in_use: Option<usize> = number(values, "num_events");
        let (Some(in_use), Some(Value::Array(events))) = (in_use, values.get("events")) else { return };
        // A count above the array length violates another rule, and it is unknown which events are used.
        for (index, event) in events.iter().take(in_use).enumerate().filter(|_| in_use <= events.len()) {
            let Value::Message(event) = event else { return };
            let Some(id) = number::<u32>(event, "id") else { return };
            context.covered();
            if id == 0 {
                context.violation_in_field(channel, "events", message.location, || {
                    Detail::new(format!("an entry among the first {in_use} has no id"))
                        .at(format!("events[{index}].id"))
                        .expected("an id other than 0")
                        .actual("0")
                });
            }
        }
    }
}

/// Clears the event id in the last refusal.
fn without_id<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    flight.with_refusal(|reply| reply["events"][0]["id"] = 0.into())
}
