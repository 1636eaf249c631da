//! `PX-DATA-03`.

use std::collections::HashMap;

use super::{
    Change, Channel, Check, Checker, Detail, Interest, Level, Mutant, Px4Rule, Rule, RuleContext, Status,
};
use crate::rules::sample::Entry;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-DATA-03",
        level: Level::Must,
        status: Status::Normative,
        statement: "No two subscriptions of a log have the same topic and the same instance at one time.",
        source: "ULog file format, section on subscription messages",
        applies_to: "logs",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::State(|| Box::new(Instances::default())),
    mutants: &[Mutant {
        name: "a second subscription of an instance",
        change: Change::Ulog(|flight, mut log| {
            log.entries.push(Entry::Subscription(u16::MAX, 0, flight.topics.first()?.name.clone()));
            Some(log)
        }),
        also: &[],
    }],
};

/// The channel of each topic and instance that is subscribed.
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
            context.violation_of(channel.topic, channel.location, definition, || {
                Detail::new(format!("a second subscription of instance {multi_id}"))
                    .expected(format!("one subscription of instance {multi_id} at a time"))
                    .actual("a second one")
            });
        }
        Interest::Nothing
    }

    /// What was unsubscribed may be subscribed again, under any id.
    fn closed(&mut self, channel: &Channel<'_>) {
        let Some(multi_id) = channel.multi_id else { return };
        let key = (channel.topic.to_owned(), multi_id);
        if self.known.get(&key) == Some(&channel.index) {
            self.known.remove(&key);
        }
    }
}
