//! `PX-CDR-01`.

use uavspec_types::px4::FailsafeFlags;

use super::prelude::*;

/// The rule.
pub static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-CDR-01",
    name: "CDR encapsulation header",
    level: Level::Must,
    status: Status::Normative,
    statement: "The encapsulation header of a CDR payload identifies a defined encoding. Messages in \
                encodings other than plain CDR version 1 are not checked further.",
    source: "DDSI-RTPS 2.5, section 10.5, and DDS-XTypes 1.3, table 60",
    applies_to: "CDR messages",
    why: "Readers use this header to choose the encoding and the byte order. Readers can't decode a \
          payload with an undefined encoding.",
    example: "payload:   00 42 00 00 …\n\
              plain CDR: 00 00 (big endian) or 00 01 (little endian)",
    fix: "Start each payload with `00 01 00 00` (little endian) or `00 00 00 00` (big endian), and encode \
          the message in that byte order.",
})
.check(Check::Source)
.bug(
    Bug::message(
        Side::Autopilot,
        "Every fifth FailsafeFlags has an undefined encapsulation header.",
        |out| {
            out.edit_payload::<FailsafeFlags>(5, |payload| {
                payload.iter_mut().take(2).for_each(|byte| *byte = 0xee);
            });
        },
    )
    .needs(Needs::Headers),
)
.mutants(&[Mutant::mcap("a header with an undefined encoding", |_, bag| {
    bag.with_payload(|payload| payload[1] = 0x42)
})]);
