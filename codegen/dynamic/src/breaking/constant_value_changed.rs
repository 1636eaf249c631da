//! `constant-value-changed`: the value of a constant changed.

use uavspec_schema::Constant;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::message::{ConstantChange, Pair, both};
use super::rule::{Category, Check, Rule, Sink};

pub(super) const RULE: Rule = Rule {
    id: "constant-value-changed",
    statement: "The value of a constant changed.",
    why: "Programs still compile, but two peers misunderstand each other until both are rebuilt.",
    fix: "Keep the value, and add a new constant.",
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
    // Compared as text, since NaN doesn't equal itself.
    let (before, now) = (old.value.to_string(), new.value.to_string());
    if before == now {
        return;
    }
    let message = format!("`{}.{}` is {now} instead of {before}", pair.name(), new.name);
    let mut change = sink.change(new.span, both(old.span, new.span), message);
    let successor = pair.new.constants.iter().take(MAX_CONSTANTS).find(|other| takes_value_of(old, other));
    match successor {
        Some(successor) => change.breaks(
            Category::Semantic,
            format!(
                "existing programs read {before} as this constant, but {before} is now `{}`",
                successor.name
            ),
        ),
        None => change.breaks(Category::Semantic, "existing programs misinterpret the value"),
    };
}

/// The maximum number of constants to search. No known enum has more constants.
const MAX_CONSTANTS: usize = 1_000;

/// True if a constant has the old value of another constant, and both names start with the same word.
fn takes_value_of(old: &Constant, other: &Constant) -> bool {
    let is_related = old.name.split('_').next() == other.name.split('_').next();
    other.value == old.value && other.name != old.name && is_related
}
