//! `field-unit-changed`: the unit of a field changed.

use uavspec_schema::Field;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::message::{Pair, both};
use super::rule::{Category, Check, Rule, Sink};

pub(super) const RULE: Rule = Rule {
    id: "field-unit-changed",
    statement: "The unit of a field changed. Adding a unit to a field that had none is not reported.",
    why: "The same number now means a different quantity, and nothing in the data reveals the change.",
    fix: "Keep the unit, or add a new field with the new unit in its name.",
    breaks: &[(Category::Semantic, Level::Error)],
    old: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               float32 bank      # [deg] Bank angle\n",
    }],
    new: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               float32 bank      # [rad] Bank angle\n",
    }],
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
