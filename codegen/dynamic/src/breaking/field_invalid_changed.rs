//! `field-invalid-changed`: the value for missing data changed.

use uavspec_schema::Constraint;
use uavspec_schema::value::Value;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "field-invalid-changed",
    statement: "The value that represents missing data changed. Adding a missing-data value to a field that \
        had none is not reported.",
    why: "Existing programs treat the new value as data and still check for the old value.",
    fix: "Keep the value, or update all readers before the writers.",
    breaks: &[(Category::Semantic, Level::Error)],
    old: &[glider!["float32 sink      # [m/s] [@invalid -1] Sink rate"]],
    new: &[glider!["float32 sink      # [m/s] [@invalid NaN] Sink rate"]],
    check: Check::Field(check),
};

fn check(pair: &Pair<'_>, old: &Field, new: &Field, sink: &mut Sink<'_>) {
    for before in old.constraints.iter().filter(|found| found.is_special()) {
        let now = new.constraint(before.kind).map_or_else(|| "nothing".to_owned(), text);
        if text(before) == now {
            continue;
        }
        let message = format!(
            "the value for missing data in `{}.{}` is {now} instead of {}",
            pair.name(),
            new.name,
            text(before)
        );
        sink.change(new.span, both(old.span, new.span), message).breaks(
            Category::Semantic,
            "existing programs treat the new value as data and still check for the old value",
        );
    }
}

fn text(special: &Constraint) -> String {
    special.stated.value().map_or_else(|| "an empty value".to_owned(), Value::to_string)
}
