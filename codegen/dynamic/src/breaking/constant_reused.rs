//! `constant-reused`: the value of a removed constant was reused.

use super::message::ConstantChange;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "constant-reused",
    statement: "A new constant has the value of a removed constant.",
    why: "Existing programs send and show the value with its old meaning.",
    fix: "Use a new value for the new constant, and don't reuse values.",
    breaks: &[(Category::Source, Level::Error), (Category::Semantic, Level::Error)],
    old: &[glider!["uint8 MODE_CRUISE = 0  # Straight on"]],
    new: &[glider!["uint8 MODE_WINCH = 0   # On the rope"]],
    check: Check::Constant(check),
};

fn check(pair: &Pair<'_>, change: &ConstantChange<'_>, sink: &mut Sink<'_>) {
    let ConstantChange::Reused(old, new) = change else { return };
    let message = format!("{} is now `{}.{}` instead of `{}`", new.value, pair.name(), new.name, old.name);
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Source, format!("programs that use `{}` no longer compile", old.name))
        .breaks(Category::Semantic, "existing programs use the old meaning of the value");
}
