//! `field-type-changed`: the type of a field changed.

use uavspec_schema::Element;

use super::field_added::uorb;
use super::message::Held;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "field-type-changed",
    statement: "The type of a field changed.",
    why: "The field's bytes have a different meaning, and later fields may move.",
    fix: "Keep the type, and add a new field with the new type. Otherwise update all peers together.",
    breaks: &[
        (Category::Source, Level::Error),
        (Category::Json, Level::Error),
        (Category::Cdr, Level::Error),
        (Category::Uorb, Level::Error),
    ],
    old: &[glider!["uint8 height     # [m] Height above ground"]],
    new: &[glider!["int16 height     # [m] Height above ground"]],
    check: Check::Message(check),
};

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    for kept in pair.kept().filter(|kept| kept.held == Held::Other) {
        let (old, new) = (&pair.old.fields[kept.old], &pair.new.fields[kept.new]);
        if is_same_string(old.ty.element, new.ty.element) {
            continue;
        }
        let (before, now) = (pair.old_type(old.ty), pair.new_type(new.ty));
        let message = format!("`{}.{}` has type {now} instead of {before}", pair.name(), new.name);
        let mut change = sink.change(new.span, both(old.span, new.span), message);
        change.breaks(Category::Source, "programs that expect the old type no longer compile");
        if !is_same_json(old.ty.element, new.ty.element) {
            change.breaks(Category::Json, "a value that is valid for one type may be invalid for the other");
        }
        change.breaks(
            Category::Cdr,
            "readers decode the field's bytes as a different type, and later fields may move",
        );
        if pair.is_uorb() {
            change.breaks(Category::Uorb, uorb(pair));
        }
    }
}

/// True if both types are strings of the same kind. A different length is reported by `array-length-changed`.
fn is_same_string(old: Element, new: Element) -> bool {
    let wide = |element| match element {
        Element::String { wide, .. } => Some(wide),
        Element::Scalar(_) | Element::Text(_) | Element::Message(_) => None,
    };
    wide(old).is_some() && wide(old) == wide(new)
}

/// True if both types are float types, which all have the same JSON form.
fn is_same_json(old: Element, new: Element) -> bool {
    old.is_float() && new.is_float()
}
