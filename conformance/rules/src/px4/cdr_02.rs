//! `PX-CDR-02`.

use uavspec_types::px4::ArmingCheckReply;

use super::prelude::*;

/// The rule.
pub static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-CDR-02",
    name: "Complete CDR payload",
    level: Level::Must,
    status: Status::Normative,
    statement: "A CDR payload contains one complete message, followed by nothing but padding to a \
                multiple of four bytes. Sequences and strings do not exceed their bounds, and strings end \
                with NUL.",
    source: "DDS-XTypes 1.3, section 7.4; the field types in the definition",
    applies_to: "CDR messages",
    why: "A payload that is too short has no values for its last fields. Extra bytes show that the writer \
          uses a different definition, so the other values may be wrong as well.",
    example: "ArmingCheckRequest: 4 (header) + 8 + 1 + 3 (alignment) + 4 = 20 bytes\n\
              payload:            16 bytes, without valid_registrations_mask",
    fix: "Encode all fields in the order of the definition, with the alignment that CDR requires. Build \
          the writer and the reader from the same definition.",
})
.check(Check::Source)
.bug(Bug::message(Side::Component, "Every fifth ArmingCheckReply lacks its last four bytes.", |out| {
    out.edit_payload::<ArmingCheckReply>(5, |payload| {
        payload.truncate(payload.len().saturating_sub(4));
    });
}))
.mutants(&[
    Mutant::mcap("a payload without its last four bytes", |_, bag| {
        // Some of the removed bytes may be padding.
        bag.with_payload(|payload| (0..4).for_each(|_| _ = payload.pop()))
    }),
    Mutant::mcap("a payload with four extra bytes", |_, bag| {
        bag.with_payload(|payload| payload.extend([0; 4]))
    }),
    Mutant::mcap("a payload of three bytes", |_, bag| bag.with_payload(|payload| payload.truncate(3))),
]);
