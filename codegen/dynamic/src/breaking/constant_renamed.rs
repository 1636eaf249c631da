//! `constant-renamed`: a constant was renamed.

use super::message::ConstantChange;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "constant-renamed",
    statement: "A constant was renamed; its value is the same.",
    why: "Messages do not change, but programs that use the old name no longer compile.",
    fix: "Keep the old name if programs outside the repository use it. Otherwise, update all uses of the \
        name.",
    breaks: &[(Category::Source, Level::Error)],
    old: &[glider!["uint8 MODE_CRUISE = 0   # Straight on"]],
    new: &[glider!["uint8 MODE_CRUISING = 0   # Straight on"]],
    check: Check::Constant(check),
};

fn check(pair: &Pair<'_>, change: &ConstantChange<'_>, sink: &mut Sink<'_>) {
    let ConstantChange::Renamed(old, new) = change else { return };
    let message = format!("`{}.{}` (= {}) was renamed to `{}`", pair.name(), old.name, new.value, new.name);
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Source, "programs that use the old name no longer compile");
}
