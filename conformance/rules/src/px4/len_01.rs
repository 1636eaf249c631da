//! `PX-LEN-01`.

use uavspec_runtime::ConstraintKind;
use uavspec_types::px4::ArmingCheckReply;

use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-LEN-01",
    name: "Count of used array entries",
    level: Level::Must,
    status: Status::Normative,
    statement: "The count of used array entries does not exceed the array length.",
    source: "`@count` in the definition, or the field names `num_x` and `x_count`",
    applies_to: "message values",
    why: "If the count is too large, a reader that trusts it reads beyond the end of the array. In C++, \
          this is undefined behavior.",
    example: "definition: uint8 num_events  # [@count events]\n\
              \x20           Event[5] events\n\
              message:    {…, \"num_events\": 7, …}",
    fix: "Limit the count to the length of the array before you publish the message.",
})
.check(Check::Value)
.bug(Bug::message(Side::Component, "`num_events` of every fifth ArmingCheckReply is 6.", |out| {
    out.edit(5, |reply: &mut ArmingCheckReply| reply.num_events = 6);
}))
.mutants(&[Mutant::flight("a count above the array length", |flight| {
    flight.violating(ConstraintKind::Count)
})]);
