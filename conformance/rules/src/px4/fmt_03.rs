//! `PX-FMT-03`.

use super::fmt_01;
use super::prelude::*;

/// The rule.
pub static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-FMT-03",
    name: "Timestamp field",
    level: Level::Must,
    status: Status::Normative,
    statement: "Each message has a `timestamp` field of type uint64.",
    source: "ULog file format, section on format messages",
    applies_to: "logs and MCAP schemas",
    why: "Readers use this field to order records and to compare topics. Without a timestamp, the values \
          of a topic can't be plotted over time.",
    example: "format battery_status: uint64_t time;float voltage_v;…",
    fix: "Add `uint64 timestamp  # [us] Time since boot` to the definition, and set it when you \
          publish the message.",
})
.check(Check::Source)
.mutants(&[Mutant::ulog("a renamed `timestamp`", |flight, mut log| {
    let topic = flight.regular(|_| true)?;
    let fields = log.format_mut(&flight.topics[topic].name)?;
    *fields = fields.replace("uint64_t timestamp;", "uint64_t time;");
    Some(log)
})
.also(&[&fmt_01::RULE])]);
