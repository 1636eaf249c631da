//! `PX-CDR-01`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};

pub(crate) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-CDR-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "The encapsulation header of a CDR payload names an encoding that exists. Those that aren't plain CDR of version 1 are known, and their messages aren't judged.",
        source: "DDSI-RTPS 2.5, section 10.5, and DDS-XTypes 1.3, table 60",
        applies_to: "messages as CDR",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Source,
    mutants: &[Mutant {
        name: "a header that names no encoding",
        change: Change::Mcap(|_, bag| bag.with_payload(|payload| payload[1] = 0x42)),
        also: &[],
    }],
};
