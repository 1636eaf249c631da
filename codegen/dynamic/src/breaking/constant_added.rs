//! `constant-added`: a constant was added.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;
use uavspec_schema::finding::Sides;

use super::message::{ConstantChange, Pair};
use super::rule::{Category, Check, Rule, Sink};

pub(super) const RULE: Rule = Rule {
    id: "constant-added",
    statement: "A constant was added.",
    why: "Enums are open, so existing programs may receive a value that they don't know.",
    fix: "Check that existing programs handle unknown values.",
    breaks: &[(Category::Semantic, Level::Note)],
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
               uint8 MODE_CRUISE = 0   # Straight on\n\
               uint8 MODE_THERMAL = 1  # Circling in lift\n",
    }],
    check: Check::Constant(check),
};

fn check(pair: &Pair<'_>, change: &ConstantChange<'_>, sink: &mut Sink<'_>) {
    let ConstantChange::Added(new) = change else { return };
    let message = format!("`{}.{}` (= {}) was added", pair.name(), new.name, new.value);
    sink.change(new.span, Sides { old: None, new: Some(new.span) }, message)
        .breaks(Category::Semantic, "existing programs don't know the new value");
}
