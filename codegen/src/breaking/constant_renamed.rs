//! `constant-renamed`: a constant under another name.

use super::message::both;
use super::message::{ConstantChange, Pair};
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "constant-renamed",
    purpose: "A constant has another name and the same value. Messages are the same; programs that use the \
              old name don't compile.",
    breaks: &[(Category::Source, Level::Error)],
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
               uint8 MODE_CRUISING = 0   # Straight on\n",
    }],
    check: Check::Constant(check),
};

fn check(pair: &Pair<'_>, change: &ConstantChange<'_>, sink: &mut Sink<'_>) {
    let ConstantChange::Renamed(old, new) = change else { return };
    let message = format!("`{}.{}` (= {}) is now called `{}`", pair.name(), old.name, new.value, new.name);
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Source, "programs that use it by its old name don't compile");
}
