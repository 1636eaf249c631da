//! `constant-removed`: a constant was removed.

use super::message::ConstantChange;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "constant-removed",
    statement: "A constant was removed.",
    why: "Programs that use the constant no longer compile. If a peer still sends the value, receivers have \
        no name for it.",
    fix: "Keep the constant, and mark it as deprecated in its comment.",
    breaks: &[(Category::Source, Level::Error)],
    old: &[glider!["uint8 MODE_CRUISE = 0   # Straight on", "uint8 MODE_THERMAL = 1  # Circling in lift"]],
    new: &[glider!["uint8 MODE_CRUISE = 0   # Straight on"]],
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
