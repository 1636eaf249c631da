//! `PX-EVT-05`.

use super::evt::is_event;
use super::ext::number;
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EVT-05",
    name: "Sequence of events in a log",
    level: Level::Info,
    status: Status::Advisory,
    statement: "The `event_sequence` increases by one with each event, except after a dropout. The number \
                after 65535 is 0.",
    source: "`event_sequence` of Event",
    applies_to: "logs",
    why: "If numbers are missing, the log lacks events: the reason for a refusal or a failsafe may be \
          among them.",
    example: "event_sequence: 17, 18, 21        (19 and 20 are missing)",
    fix: "Check the load of the logger, and the queue length of the topic `event`.",
})
.check(Check::State(|| Box::new(Numbers::default())))
.mutants(&[Mutant::flight_in("an event that is missing from the log", &[Encoding::Ulog], |flight| {
    let mut changed = flight.clone();
    changed.messages.remove(flight.last_event(3)?);
    // The log ends with a later event.
    changed.messages.remove(changed.last_event(3)?);
    Some(changed)
})]);

#[derive(Default)]
struct Numbers {
    channels: PerChannel<Option<u16>>,
}

impl Checker for Numbers {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        self.channels.open(channel, None);
        // Buses may lose messages without a trace.
        let is_logged = channel.multi_id.is_some() && is_event(channel, context);
        if is_logged { Interest::Values } else { Interest::Nothing }
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let Some(previous) = self.channels.get(channel) else { return };
        let Some(number) = message.values.and_then(|values| number::<u16>(values, "event_sequence")) else {
            return;
        };
        let Some(before) = previous.replace(number) else { return };
        context.covered();
        let missing = number.wrapping_sub(before).wrapping_sub(1);
        // An event may be recorded twice.
        if missing != 0 && number != before {
            context.violation_in_field(channel, "event_sequence", message.location, || {
                let text = format!("follows {before}, and no dropout was recorded");
                Detail::new(text).expected(before.wrapping_add(1).to_string()).actual(number.to_string())
            });
        }
    }

    fn dropout(&mut self, _: u16, _: Location) {
        self.channels.reset();
    }

    fn corruption(&mut self, _: Location) {
        self.channels.reset();
    }
}
