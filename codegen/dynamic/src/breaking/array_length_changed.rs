//! `array-length-changed`: the length of an array or string changed.

use uavspec_schema::{Element, Shape, Type};

use super::field_added::uorb;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "array-length-changed",
    statement: "The length of an array, a sequence or a string changed.",
    why: "The encoding of the message changes, and existing readers expect a different number of elements.",
    fix: "Update all peers together, and raise `MESSAGE_VERSION` of a versioned message. To stay \
        compatible, add a new field or message.",
    breaks: &[
        (Category::Source, Level::Error),
        (Category::Json, Level::Error),
        (Category::Cdr, Level::Error),
        (Category::Uorb, Level::Error),
    ],
    old: &[glider!["float32[2] flaps  # [rad] Angle of each flap"]],
    new: &[glider!["float32[4] flaps  # [rad] Angle of each flap"]],
    check: Check::Field(check),
};

fn check(pair: &Pair<'_>, old: &Field, new: &Field, sink: &mut Sink<'_>) {
    let (old_type, new_type) = (old.ty.written(), new.ty.written());
    let (before, now) = if old_type.shape == new_type.shape {
        let (before, now) = (characters(old_type.element), characters(new_type.element));
        if before == now || before.is_none() || now.is_none() {
            return;
        }
        (before.unwrap_or_default(), now.unwrap_or_default())
    } else {
        (elements(old_type.shape), elements(new_type.shape))
    };
    let message = format!("`{}.{}` has {now} instead of {before}", pair.name(), new.name);
    let is_counted = |ty: Type| !matches!(ty.shape, Shape::Single | Shape::Array(_));
    let is_string = matches!(new_type.element, Element::String { .. }) && old_type.shape == new_type.shape;
    // Sequences and strings have a length prefix, so only values that are too long are misread.
    let cdr = if is_string || is_counted(old_type) && is_counted(new_type) {
        "existing readers reject longer values, and the type hash changes"
    } else {
        "all later fields move, so existing readers decode the wrong bytes for them"
    };
    let mut change = sink.change(new.span, both(old.span, new.span), message);
    change
        .breaks(Category::Source, "its type changes: existing programs may no longer compile")
        .breaks(Category::Json, "existing readers expect a different length")
        .breaks(Category::Cdr, cdr);
    if pair.is_uorb() {
        change.breaks(Category::Uorb, uorb(pair));
    }
}

/// Describes how many elements a field of this shape has.
fn elements(shape: Shape) -> String {
    match shape {
        Shape::Single => "one value".to_owned(),
        Shape::Array(length) => format!("{length} elements"),
        Shape::Bounded(bound) => format!("up to {bound} elements"),
        Shape::Sequence => "any number of elements".to_owned(),
    }
}

/// Describes the length of a string. `None` for other types.
fn characters(element: Element) -> Option<String> {
    match element {
        Element::String { bound: Some(bound), .. } => Some(format!("up to {bound} characters")),
        Element::String { bound: None, .. } => Some("any number of characters".to_owned()),
        Element::Scalar(_) | Element::Text(_) | Element::Message(_) => None,
    }
}
