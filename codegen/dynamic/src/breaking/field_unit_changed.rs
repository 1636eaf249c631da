//! `field-unit-changed`: the unit of a field changed.

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "field-unit-changed",
    statement: "The unit of a field changed. Adding a unit to a field that had none is not reported.",
    why: "The same number now means a different quantity, and nothing in the data reveals the change.",
    fix: "Keep the unit, or add a new field with the new unit in its name.",
    breaks: &[(Category::Semantic, Level::Error)],
    old: &[glider!["float32 bank      # [deg] Bank angle"]],
    new: &[glider!["float32 bank      # [rad] Bank angle"]],
    check: Check::Field(check),
};

fn check(pair: &Pair<'_>, old: &Field, new: &Field, sink: &mut Sink<'_>) {
    let (Some(before), Some(now)) = (&old.unit, &new.unit) else { return };
    if before == now {
        return;
    }
    let message = format!("`{}.{}` is in {now} instead of {before}", pair.name(), new.name);
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Semantic, "existing programs interpret the numbers in the old unit");
}
