//! `PX-DATA-01`.

use super::prelude::*;

/// The rule.
pub static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-DATA-01",
    name: "Size of data messages",
    level: Level::Must,
    status: Status::Normative,
    statement: "A data message has the size of its format, with or without the trailing padding.",
    source: "the format in the log, and PX4's logger",
    applies_to: "logs",
    why: "Readers find fields by their offset in the format. If the size differs, the record was written \
          with a different format, and its values are unreliable.",
    example: "format:  uint64_t timestamp;uint32_t valid_registrations_mask;\n\
              \x20        uint8_t request_id;uint8_t[3] _padding0;\n\
              payload: 12 bytes; expected 16, or 13 without padding",
    fix: "Generate the format and the logged struct from the same definition. Log the whole struct.",
})
.check(Check::Source)
.mutants(&[
    Mutant::ulog("a payload of four bytes", |_, log| log.with_payload(0, |payload| payload.truncate(4))),
    Mutant::ulog("a payload with an extra byte", |_, log| log.with_payload(0, |payload| payload.push(0))),
]);
