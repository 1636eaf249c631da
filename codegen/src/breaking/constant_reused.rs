//! `constant-reused`: a value that stands for something else.

use super::message::both;
use super::message::{ConstantChange, Pair};
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "constant-reused",
    purpose: "A constant is gone, and another one has its value: what programs of before send or show as \
              the old is now the new.",
    breaks: &[(Category::Source, Level::Error), (Category::Semantic, Level::Error)],
    old: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               uint8 MODE_CRUISE = 0  # Straight on\n",
    }],
    new: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               uint8 MODE_WINCH = 0   # On the rope\n",
    }],
    check: Check::Constant(check),
};

fn check(pair: &Pair<'_>, change: &ConstantChange<'_>, sink: &mut Sink<'_>) {
    let ConstantChange::Reused(old, new) = change else { return };
    let message = format!("{} is now `{}.{}`, and was `{}`", new.value, pair.name(), new.name, old.name);
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Source, format!("programs that use `{}` don't compile", old.name))
        .breaks(Category::Semantic, "programs of before take the value for what it was");
}
