//! `PX-FMT-03`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status, fmt_01};

pub(crate) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-FMT-03",
        level: Level::Must,
        status: Status::Normative,
        statement: "Each message has a field `timestamp` of type uint64.",
        source: "ULog file format, section on format messages",
        applies_to: "logs",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Source,
    mutants: &[Mutant {
        name: "`timestamp` has another name",
        change: Change::Ulog(|flight, mut log| {
            let topic = flight.regular(|_| true)?;
            let fields = log.format_mut(&flight.topics[topic].name)?;
            *fields = fields.replace("uint64_t timestamp;", "uint64_t time;");
            Some(log)
        }),
        also: &[&fmt_01::RULE],
    }],
};
