//! `constant-value-changed`: a constant of another value.

use super::message::both;
use super::message::{ConstantChange, Pair};
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::Constant;

pub(super) const RULE: Rule = Rule {
    id: "constant-value-changed",
    purpose: "A constant has another value. Programs compile as before, and understand each other wrongly \
              where only one side was built anew.",
    breaks: &[(Category::Semantic, Level::Error)],
    old: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               uint8 MODE_CRUISE = 0   # Straight on\n",
    }],
    new: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               uint8 MODE_CRUISE = 2   # Straight on\n",
    }],
    check: Check::Constant(check),
};

fn check(pair: &Pair<'_>, change: &ConstantChange<'_>, sink: &mut Sink<'_>) {
    let ConstantChange::Same(old, new) = change else { return };
    // As text, since NaN equals nothing.
    let (before, now) = (old.value.to_string(), new.value.to_string());
    if before == now {
        return;
    }
    let message = format!("`{}.{}` is {now}, and was {before}", pair.name(), new.name);
    let mut change = sink.change(new.span, both(old.span, new.span), message);
    let heir = pair.new.constants.iter().take(MAX_CONSTANTS).find(|other| is_heir(old, other));
    match heir {
        Some(heir) => change.breaks(
            Category::Semantic,
            format!("programs of before take `{}`, which is {before} now, for it", heir.name),
        ),
        None => change.breaks(Category::Semantic, "programs of before take its value for something else"),
    };
}

/// How many constants are searched for one that has the value now: more than any enum known has.
const MAX_CONSTANTS: usize = 1_000;

/// Whether a constant has the value that another one had, and belongs with it by its first word.
fn is_heir(old: &Constant, other: &Constant) -> bool {
    let is_of_one_family = old.name.split('_').next() == other.name.split('_').next();
    other.value == old.value && other.name != old.name && is_of_one_family
}
