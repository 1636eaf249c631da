//! `PX-HASH-01`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};

pub(crate) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-HASH-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "A hash that is stated for the type of messages is that of the definition. Where the source brings a schema of its own that differs, so does the hash, which is no breach of its own.",
        source: "ROS 2's REP 2016 (RIHS01)",
        applies_to: "what a source says of its types",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Source,
    mutants: &[Mutant {
        name: "the hash of another type",
        change: Change::Mcap(|_, mut bag| {
            bag.channels.first_mut()?.hash = format!("RIHS01_{}", "0".repeat(64));
            Some(bag)
        }),
        also: &[],
    }],
};
