//! `PX-DATA-02`.

use super::prelude::*;
use crate::sample::Entry;

/// The rule.
pub static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-DATA-02",
    name: "Subscription of data messages",
    level: Level::Must,
    status: Status::Normative,
    statement: "Each data message has the id of a subscription that precedes it and is still active.",
    source: "ULog file format, section on data messages",
    applies_to: "logs",
    why: "The subscription defines the topic and the format of a record. Without the subscription, \
          readers can't decode the record.",
    example: "subscription: id 0, battery_status\n\
              data:         id 7, …                 (id 7 was never subscribed)",
    fix: "Write the subscription for an id before the first data message with that id. After the id is \
          unsubscribed, write no more data messages with it.",
})
.check(Check::Source)
.mutants(&[
    Mutant::ulog("data with an id that was never subscribed", |_, mut log| {
        log.entries.push(Entry::Data(u16::MAX, vec![0; 8]));
        Some(log)
    }),
    Mutant::ulog("a subscription after its data", |_, mut log| {
        let is_first = |entry: &Entry| matches!(entry, Entry::Subscription(0, ..));
        let at = log.entries.iter().position(is_first)?;
        let late = log.entries.remove(at);
        log.entries.push(late);
        Some(log)
    }),
]);
