//! `PX-ENUM-01`.

use uavspec_runtime::ConstraintKind;
use uavspec_types::px4::BatteryStatus;
use uavspec_types::px4::battery_status::BatteryWarning;

use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-ENUM-01",
    name: "Documented constants and bits",
    level: Level::Should,
    status: Status::Normative,
    statement: "A field with `@enum` contains a documented constant, and a field with `@flags` contains \
                only documented bits.",
    source: "`@enum` and `@flags` in the definition",
    applies_to: "message values",
    why: "Readers don't know the meaning of an undocumented value. They show an unknown state or mistake \
          the value for a known state.",
    example: "definition: uint8 source  # [@enum BATTERY_SOURCE], constants: 0, 1, 2\n\
              message:    {…, \"source\": 7, …}",
    fix: "Send a documented constant. If the value is intentional, add a constant with a comment to the \
          definition.",
})
.check(Check::Value)
.bug(Bug::message(Side::Autopilot, "`warning` of every third BatteryStatus is 100.", |out| {
    out.edit(3, |battery: &mut BatteryStatus| battery.warning = BatteryWarning(100));
}))
.mutants(&[Mutant::flight("an undocumented value", |flight| flight.violating(ConstraintKind::Enum))]);
