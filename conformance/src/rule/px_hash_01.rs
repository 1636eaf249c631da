//! `PX-HASH-01`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-HASH-01",
    level: Level::Must,
    statement: "A hash that is stated for the type of messages is that of the definition. Where the source brings a schema of its own that differs, so does the hash, which is no breach of its own.",
    source: "ROS 2's REP 2016 (RIHS01)",
    check: Check::Source,
};
