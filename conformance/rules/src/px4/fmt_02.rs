//! `PX-FMT-02`.

use super::prelude::*;
use crate::sample::Entry;

/// The rule.
pub static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-FMT-02",
    name: "Formats of nested types",
    level: Level::Must,
    status: Status::Normative,
    statement: "Each nested type in a format has its own format in the same log.",
    source: "ULog file format, section on format messages",
    applies_to: "logs",
    why: "Without the format of the nested type, readers can't compute the type's size, so they can't \
          read any record of the topic.",
    example: "format tow: uint64_t timestamp;rope[2] ropes;\n\
              \x20           (the log has no format `rope`)",
    fix: "Write the formats of all nested types to the header of the log.",
})
.check(Check::Source)
.mutants(&[Mutant::ulog("a nested type without a format", |_, mut log| {
    let fields = "uint64_t timestamp;rope[2] ropes;".to_owned();
    log.entries.insert(1, Entry::Format("tow".to_owned(), fields));
    Some(log)
})]);
