//! `constant-removed`: a constant was removed.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;
use uavspec_schema::finding::Sides;

use super::message::{ConstantChange, Pair};
use super::rule::{Category, Check, Rule, Sink};

pub(super) const RULE: Rule = Rule {
    id: "constant-removed",
    statement: "A constant was removed.",
    why: "Programs that use the constant no longer compile. If a peer still sends the value, receivers have \
        no name for it.",
    fix: "Keep the constant, and mark it as deprecated in its comment.",
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
    let message = format!("`{}.{}` (= {}) was removed", pair.name(), old.name, old.value);
    sink.change(pair.head(), Sides { old: Some(old.span), new: None }, message).breaks(
        Category::Source,
        "programs that use the constant no longer compile, and existing peers may still send its value",
    );
}
