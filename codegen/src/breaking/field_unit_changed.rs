//! `field-unit-changed`: a field in another unit.

use super::message::Pair;
use super::message::both;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::Field;

pub(super) const RULE: Rule = Rule {
    id: "field-unit-changed",
    purpose: "A field has another unit: the same number means another quantity, and nothing but the \
              definition tells. Where a unit is stated for the first time, nothing is reported: the field \
              was in some unit all along.",
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
    let message = format!("`{}.{}` is in {now}, and was in {before}", pair.name(), new.name);
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Semantic, "programs of before read the numbers as if the unit were the old one");
}
