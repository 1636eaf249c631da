//! `PX-NAN-01`.

use uavspec_runtime::ConstraintKind;
use uavspec_types::px4::BatteryStatus;

use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-NAN-01",
    name: "NaN has a meaning",
    level: Level::Should,
    status: Status::Advisory,
    statement: "A field with restricted values may be NaN only if its definition says what NaN means.",
    source: "`@invalid NaN` in the definition, or the description of the field",
    applies_to: "message values",
    why: "Comparisons such as `x < 10` are false for NaN, so limit checks and failsafes may not trigger.",
    example: "definition: float32 remaining  # [-] [@range 0, 1] [@invalid -1]\n\
              message:    {…, \"remaining\": null, …}",
    fix: "Send the value for missing data (`-1` in the example). If NaN is intended, add `[@invalid NaN]` \
          to the definition.",
})
.check(Check::Value)
.bug(Bug::message(Side::Autopilot, "`remaining` of every third BatteryStatus is NaN.", |out| {
    out.edit(3, |battery: &mut BatteryStatus| battery.remaining = f32::NAN);
}))
.mutants(&[Mutant::flight("NaN in a field without `@invalid NaN`", |flight| {
    flight.violating(ConstraintKind::Nan)
})]);
