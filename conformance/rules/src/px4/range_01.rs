//! `PX-RANGE-01`.

use uavspec_runtime::ConstraintKind;
use uavspec_types::px4::BatteryStatus;

use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-RANGE-01",
    name: "Values are within their range",
    level: Level::Should,
    status: Status::Normative,
    statement: "Each value is within the range of its field, or is the field's value for missing data.",
    source: "`@range` and `@invalid` in the definition",
    applies_to: "message values",
    why: "Readers rely on the range for scaling, limits and display. A value outside the range is often \
          in the wrong unit.",
    example: "definition: float32 remaining  # [-] [@range 0, 1] [@invalid -1]\n\
              message:    {…, \"remaining\": 87.5, …}",
    fix: "Check the unit and the scale of the value. The example has a percentage instead of a fraction. \
          If the value is valid, extend the range in the definition.",
})
.check(Check::Value)
.bug(Bug::message(Side::Autopilot, "`remaining` of every third BatteryStatus is 1.5.", |out| {
    out.edit(3, |battery: &mut BatteryStatus| battery.remaining = 1.5);
}))
.mutants(&[Mutant::flight("a value outside its range", |flight| flight.violating(ConstraintKind::Range))]);
