//! `constant-value-changed`: the value of a constant changed.

use uavspec_schema::Constant;

use super::message::ConstantChange;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "constant-value-changed",
    statement: "The value of a constant changed.",
    why: "Programs still compile, but two peers misunderstand each other until both are rebuilt.",
    fix: "Keep the value, and add a new constant.",
    breaks: &[(Category::Semantic, Level::Error)],
    old: &[glider!["uint8 MODE_CRUISE = 0   # Straight on"]],
    new: &[glider!["uint8 MODE_CRUISE = 2   # Straight on"]],
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
