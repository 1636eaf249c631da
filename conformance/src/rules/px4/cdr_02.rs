//! `PX-CDR-02`.

use super::{Check, Level, Mutant, Px4Rule, Rule, Status};

pub(crate) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-CDR-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "A CDR payload holds its message whole and nothing more but what fills it up to a multiple of four bytes; sequences and strings keep their bounds, and strings end with their NUL.",
        source: "DDS-XTypes 1.3, section 7.4; the types of the definition",
        applies_to: "messages as CDR",
    },
    check: Check::Source,
    mutants: &[
        Mutant {
            name: "a payload without its last four bytes",
            make: |flight| {
                // What is cut off first may only fill it up.
                let shorten = |payload: &mut Vec<u8>| (0..4).for_each(|_| _ = payload.pop());
                Some(flight.bag().with_payload(shorten)?.to_bytes())
            },
            also: &[],
        },
        Mutant {
            name: "a payload with four bytes more",
            make: |flight| Some(flight.bag().with_payload(|payload| payload.extend([0; 4]))?.to_bytes()),
            also: &[],
        },
        Mutant {
            name: "a payload without a header",
            make: |flight| Some(flight.bag().with_payload(|payload| payload.truncate(3))?.to_bytes()),
            also: &[],
        },
    ],
};
