//! `PX-EXT-05`.

use uavspec_types::px4::ArmingCheckReply;

use super::ext::{is_reply, number};
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EXT-05",
    name: "Reasons for refused arming",
    level: Level::Should,
    status: Status::Normative,
    statement: "If `can_arm_and_run` of an ArmingCheckReply is false, the reply has at least one event \
                that gives the reason.",
    source: "`can_arm_and_run` and `events` of ArmingCheckReply",
    applies_to: "message values",
    why: "The flight controller forwards the events to ground stations. Without an event, the operator \
          sees that arming is refused, but not why.",
    example: "{…, \"can_arm_and_run\": false, \"num_events\": 0, …}",
    fix: "Add an event for each reason to `events`, and set `num_events`.",
})
.check(Check::State(|| Box::new(Refusals)))
.bug(Bug::message(Side::Component, "The component refuses arming without an event.", |out| {
    out.edit(1, |reply: &mut ArmingCheckReply| reply.num_events = 0);
}))
.mutants(&[Mutant::flight("a refusal without a reason", without_reason)]);

struct Refusals;

impl Checker for Refusals {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        if is_reply(channel, context) { Interest::Values } else { Interest::Nothing }
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let Some(values) = message.values else { return };
        let can_arm = number::<u8>(values, "can_arm_and_run").map(|value| value != 0);
        let (Some(false), Some(events)) = (can_arm, number::<u64>(values, "num_events")) else { return };
        context.covered();
        if events == 0 {
            context.violation_in_field(channel, "num_events", message.location, || {
                Detail::new("can_arm_and_run is false, but no event gives the reason")
                    .expected("1 or more")
                    .actual("0")
            });
        }
    }
}

/// Removes the reasons from the last refusal.
fn without_reason<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    flight.with_refusal(|reply| reply["num_events"] = 0.into())
}
