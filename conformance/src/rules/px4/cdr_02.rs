//! `PX-CDR-02`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};

pub(crate) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-CDR-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "A CDR payload holds its message whole and nothing more but what fills it up to a multiple of four bytes; sequences and strings keep their bounds, and strings end with their NUL.",
        source: "DDS-XTypes 1.3, section 7.4; the types of the definition",
        applies_to: "messages as CDR",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Source,
    mutants: &[
        Mutant {
            name: "a payload without its last four bytes",
            change: Change::Mcap(|_, bag| {
                // The first bytes that are cut off may be padding.
                bag.with_payload(|payload| (0..4).for_each(|_| _ = payload.pop()))
            }),
            also: &[],
        },
        Mutant {
            name: "a payload with four bytes more",
            change: Change::Mcap(|_, bag| bag.with_payload(|payload| payload.extend([0; 4]))),
            also: &[],
        },
        Mutant {
            name: "a payload without a header",
            change: Change::Mcap(|_, bag| bag.with_payload(|payload| payload.truncate(3))),
            also: &[],
        },
    ],
};
