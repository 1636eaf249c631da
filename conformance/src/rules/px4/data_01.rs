//! `PX-DATA-01`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};

pub(crate) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-DATA-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "A payload has the full size of its format, or the full size less the padding at its end.",
        source: "the format in the log, and PX4's logger",
        applies_to: "logs",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Source,
    mutants: &[
        Mutant {
            name: "a payload of four bytes",
            change: Change::Ulog(|_, log| log.with_payload(0, |payload| payload.truncate(4))),
            also: &[],
        },
        Mutant {
            name: "a payload with a byte more",
            change: Change::Ulog(|_, log| log.with_payload(0, |payload| payload.push(0))),
            also: &[],
        },
    ],
};
