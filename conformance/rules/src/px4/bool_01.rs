//! `PX-BOOL-01`.

use uavspec_dynamic::Field;
use uavspec_runtime::Scalar;
use uavspec_schema::Element;

use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-BOOL-01",
    name: "Bytes of booleans",
    level: Level::Must,
    status: Status::Normative,
    statement: "A bool is stored as the byte 0 or 1.",
    source: "type `bool` in the definition; PX4 copies the byte from memory",
    applies_to: "uORB payloads",
    why: "Readers disagree about any other byte: some read true, others compare it with 1 and read false. \
          An invalid byte often comes from an uninitialized variable in the firmware.",
    example: "definition: bool connected\n\
              byte:       0x99 (153)",
    fix: "Initialize the message before you publish it, for example with `battery_status_s status{};`. \
          Assign only `true` or `false`.",
})
.check(Check::Value)
.mutants(&[Mutant::ulog("a bool whose byte is 153", |flight, log| {
    let is_bool = |field: &Field| field.element == Element::Scalar(Scalar::Bool);
    let (topic, at) = flight.find_field(is_bool)?;
    log.with_payload(topic, |payload| payload[at] = 153)
})]);
