//! `constant-type-changed`: the type of a constant changed.

use uavspec_schema::{Shape, Type};

use super::message::ConstantChange;
use super::prelude::*;
use super::signature::plain;

pub(super) const RULE: Rule = Rule {
    id: "constant-type-changed",
    statement: "The type of a constant changed.",
    why: "The value is the same, but programs that compare it with a field of the old type may no longer compile.",
    fix: "Keep the old type, which should match the fields that use the constant.",
    breaks: &[(Category::Source, Level::Warning)],
    old: &[glider!["uint8 MODE_CRUISE = 0   # Straight on"]],
    new: &[glider!["int8 MODE_CRUISE = 0    # Straight on"]],
    check: Check::Constant(check),
};

fn check(pair: &Pair<'_>, change: &ConstantChange<'_>, sink: &mut Sink<'_>) {
    let (ConstantChange::Same(old, new) | ConstantChange::Renamed(old, new)) = change else { return };
    let types = (plain(pair.old_schema, pair.old, old.ty), plain(pair.new_schema, pair.new, new.ty));
    if types.0 == types.1 {
        return;
    }
    let text = |element| Type { element, shape: Shape::Single };
    let (before, now) = (pair.old_type(text(old.ty)), pair.new_type(text(new.ty)));
    let message = format!("`{}.{}` has type {now} instead of {before}", pair.name(), new.name);
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Source, "programs that expect the old type may no longer compile");
}
