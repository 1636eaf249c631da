//! `PX-HASH-01`.

use super::prelude::*;

/// The rule.
pub static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-HASH-01",
    name: "Type hash",
    level: Level::Must,
    status: Status::Normative,
    statement: "The type hash in a capture matches the definition. If the schema in the capture differs \
                from the definition, the hash differs as well, and only `PX-FMT-01` is reported.",
    source: "ROS 2 REP 2016 (RIHS01)",
    applies_to: "type hashes in MCAP files",
    why: "ROS 2 tools compare hashes to detect incompatible types. If the hash is wrong, the tools warn \
          about compatible data or reject it.",
    example: "schema:          same fields as the definition\n\
              topic_type_hash: RIHS01_00000000… (64 digits)",
    fix: "Write the hash that the ROS 2 type support provides for the message type.",
})
.check(Check::Source)
.mutants(&[Mutant::mcap("the hash of a different type", |_, mut bag| {
    bag.channels.first_mut()?.hash = format!("RIHS01_{}", "0".repeat(64));
    Some(bag)
})]);
