//! `constant-removed`: a constant that is gone.

use super::message::{ConstantChange, Pair};
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::finding::Sides;

pub(super) const RULE: Rule = Rule {
    id: "constant-removed",
    purpose: "A constant is gone. Programs that use it don't compile, and its value has no name any more.",
    breaks: &[(Category::Source, Level::Error)],
    old: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               uint8 MODE_CRUISE = 0   # Straight on\n\
               uint8 MODE_THERMAL = 1  # Circling in lift\n",
    }],
    new: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               uint8 MODE_CRUISE = 0   # Straight on\n",
    }],
    check: Check::Constant(check),
};

fn check(pair: &Pair<'_>, change: &ConstantChange<'_>, sink: &mut Sink<'_>) {
    let ConstantChange::Removed(old) = change else { return };
    let message = format!("`{}.{}` (= {}) is gone", pair.name(), old.name, old.value);
    sink.change(pair.head(), Sides { old: Some(old.span), new: None }, message).breaks(
        Category::Source,
        "programs that use it don't compile; peers of before may still send its value",
    );
}
