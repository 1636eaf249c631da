//! `PX-DATA-02`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};
use crate::rules::sample::Entry;

pub(crate) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-DATA-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "Each payload belongs to a subscription that was made before it.",
        source: "ULog file format, section on data messages",
        applies_to: "logs",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Source,
    mutants: &[
        Mutant {
            name: "data of an id that is never subscribed",
            change: Change::Ulog(|_, mut log| {
                log.entries.push(Entry::Data(u16::MAX, vec![0; 8]));
                Some(log)
            }),
            also: &[],
        },
        Mutant {
            name: "a subscription that comes after its data",
            change: Change::Ulog(|_, mut log| {
                let is_first = |entry: &Entry| matches!(entry, Entry::Subscription(0, ..));
                let at = log.entries.iter().position(is_first)?;
                let late = log.entries.remove(at);
                log.entries.push(late);
                Some(log)
            }),
            also: &[],
        },
    ],
};
