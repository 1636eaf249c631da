//! `field-range-changed`: the range or another limit of a field changed.

use uavspec_schema::value::Value;
use uavspec_schema::{Constraint, Stated};

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "field-range-changed",
    statement: "The range of a field changed. Adding a range to a field that had none is not reported.",
    why: "Valid values may now be out of range, and invalid values may now be valid. A new range often means a \
        new scale.",
    fix: "Check that readers accept the new range. If the scale changes, add a new field.",
    breaks: &[(Category::Semantic, Level::Warning)],
    old: &[glider!["float32 charge    # [-] [@range 0, 100] Charge"]],
    new: &[glider!["float32 charge    # [-] [@range 0, 1] Charge"]],
    check: Check::Field(check),
};

fn check(pair: &Pair<'_>, old: &Field, new: &Field, sink: &mut Sink<'_>) {
    for before in old.constraints.iter().filter(|found| !found.is_special()) {
        let Some(now) = new.constraint(before.kind).map(text) else { continue };
        // Compared as text, since the integer 0 doesn't equal the float 0.0.
        let before = text(before);
        if before == now {
            continue;
        }
        let message = format!("the range of `{}.{}` is {now} instead of {before}", pair.name(), new.name);
        sink.change(new.span, both(old.span, new.span), message)
            .breaks(Category::Semantic, "valid values may now be out of range or have a different scale");
    }
}

fn text(constraint: &Constraint) -> String {
    let bound = |value: &Option<Value>, none: &str| value.as_ref().map_or(none.to_owned(), Value::to_string);
    match &constraint.stated {
        Stated::Range(range) => {
            format!("from {} to {}", bound(&range.low, "-inf"), bound(&range.high, "inf"))
        }
        Stated::Value(_) | Stated::Empty => constraint.valid_values().unwrap_or_default(),
    }
}
