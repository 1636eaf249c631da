//! `PX-FMT-02`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};
use crate::rules::sample::Entry;

pub(crate) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-FMT-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "Each type that a format nests has a format in the same log.",
        source: "ULog file format, section on format messages",
        applies_to: "logs",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Source,
    mutants: &[Mutant {
        name: "a type that the log doesn't have",
        change: Change::Ulog(|_, mut log| {
            let fields = "uint64_t timestamp;rope[2] ropes;".to_owned();
            log.entries.insert(1, Entry::Format("tow".to_owned(), fields));
            Some(log)
        }),
        also: &[],
    }],
};
