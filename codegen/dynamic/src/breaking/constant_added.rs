//! `constant-added`: a constant was added.

use super::message::ConstantChange;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "constant-added",
    statement: "A constant was added.",
    why: "Enums are open, so existing programs may receive a value that they don't know.",
    fix: "Check that existing programs handle unknown values.",
    breaks: &[(Category::Semantic, Level::Note)],
    old: &[glider!["uint8 MODE_CRUISE = 0   # Straight on"]],
    new: &[glider!["uint8 MODE_CRUISE = 0   # Straight on", "uint8 MODE_THERMAL = 1  # Circling in lift"]],
    check: Check::Constant(check),
};

fn check(pair: &Pair<'_>, change: &ConstantChange<'_>, sink: &mut Sink<'_>) {
    let ConstantChange::Added(new) = change else { return };
    let message = format!("`{}.{}` (= {}) was added", pair.name(), new.name, new.value);
    sink.change(new.span, Sides { old: None, new: Some(new.span) }, message)
        .breaks(Category::Semantic, "existing programs don't know the new value");
}
