//! `PX-DATA-03`.

use std::collections::HashMap;

use super::prelude::*;
use crate::sample::Entry;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-DATA-03",
    name: "One subscription per topic instance",
    level: Level::Must,
    status: Status::Normative,
    statement: "A log has at most one active subscription for each instance of a topic.",
    source: "ULog file format, section on subscription messages",
    applies_to: "logs",
    why: "Readers identify a stream by topic and instance. If two subscriptions describe the same stream, \
          readers merge their samples or drop some, so samples seem to be duplicated, out of order or \
          missing.",
    example: "subscription: id 0, battery_status, instance 0\n\
              subscription: id 9, battery_status, instance 0",
    fix: "Give each instance of a topic a unique number. Unsubscribe from an instance before you \
          subscribe to it again.",
})
.check(Check::State(|| Box::new(Instances::default())))
.mutants(&[Mutant::ulog("a second subscription to an instance", |flight, mut log| {
    log.entries.push(Entry::Subscription(u16::MAX, 0, flight.topics.first()?.name.clone()));
    Some(log)
})]);

/// The channel of each subscribed topic and instance.
#[derive(Default)]
struct Instances {
    known: HashMap<(String, u8), usize>,
}

impl Checker for Instances {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        let Some(multi_id) = channel.multi_id else { return Interest::Nothing };
        context.covered();
        let first = *self.known.entry((channel.topic.to_owned(), multi_id)).or_insert(channel.index);
        if first != channel.index {
            let definition = context.defined(channel.definition);
            context.violation_of(channel.subject(), channel.location, definition, || {
                Detail::new(format!("a second subscription to instance {multi_id}"))
                    .expected("one active subscription")
                    .actual("two")
            });
        }
        Interest::Nothing
    }

    /// Removes an unsubscribed instance, because it may be subscribed again with any id.
    fn closed(&mut self, channel: &Channel<'_>) {
        let Some(multi_id) = channel.multi_id else { return };
        let key = (channel.topic.to_owned(), multi_id);
        if self.known.get(&key) == Some(&channel.index) {
            self.known.remove(&key);
        }
    }
}
