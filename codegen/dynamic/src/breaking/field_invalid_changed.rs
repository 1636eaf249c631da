//! `field-invalid-changed`: the value for missing data changed.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;
use uavspec_schema::value::Value;
use uavspec_schema::{Constraint, Field};

use super::message::{Pair, both};
use super::rule::{Category, Check, Rule, Sink};

pub(super) const RULE: Rule = Rule {
    id: "field-invalid-changed",
    statement: "The value that represents missing data changed. Adding a missing-data value to a field that \
        had none is not reported.",
    why: "Existing programs treat the new value as data and still check for the old value.",
    fix: "Keep the value, or update all readers before the writers.",
    breaks: &[(Category::Semantic, Level::Error)],
    old: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               float32 sink      # [m/s] [@invalid -1] Sink rate\n",
    }],
    new: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               float32 sink      # [m/s] [@invalid NaN] Sink rate\n",
    }],
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
