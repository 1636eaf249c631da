//! `array-length-changed`: an array or a string of another length.

use super::field_added::uorb;
use super::message::Pair;
use super::message::both;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::{Element, Field, Shape};

pub(super) const RULE: Rule = Rule {
    id: "array-length-changed",
    purpose: "A field holds another number of elements or characters. Messages have other bytes, and readers expect \
              another count.",
    breaks: &[
        (Category::Source, Level::Error),
        (Category::Json, Level::Error),
        (Category::Cdr, Level::Error),
        (Category::Uorb, Level::Error),
    ],
    old: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               float32[2] flaps  # [rad] Angle of each flap\n",
    }],
    new: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               float32[4] flaps  # [rad] Angle of each flap\n",
    }],
    check: Check::Field(check),
};

fn check(pair: &Pair<'_>, old: &Field, new: &Field, sink: &mut Sink<'_>) {
    let (before, now) = if old.ty.shape == new.ty.shape {
        let (before, now) = (characters(old.ty.element), characters(new.ty.element));
        if before == now || before.is_none() || now.is_none() {
            return;
        }
        (before.unwrap_or_default(), now.unwrap_or_default())
    } else {
        (elements(old.ty.shape), elements(new.ty.shape))
    };
    let message = format!("`{}.{}` holds {now}, and held {before}", pair.name(), new.name);
    let is_counted = |field: &Field| !matches!(field.ty.shape, Shape::Single | Shape::Array(_));
    let is_string = matches!(new.ty.element, Element::String { .. }) && old.ty.shape == new.ty.shape;
    // Their length stands before them, so that only what is too long is read wrongly.
    let cdr = if is_string || is_counted(old) && is_counted(new) {
        "readers refuse what is longer than they know; the type's hash is another one"
    } else {
        "all that follows it stands elsewhere: readers of before take other bytes for it"
    };
    let mut change = sink.change(new.span, both(old.span, new.span), message);
    change
        .breaks(Category::Source, "its type is another one: programs that use it as before may not compile")
        .breaks(Category::Json, "readers of before expect another length")
        .breaks(Category::Cdr, cdr);
    if pair.is_uorb() {
        change.breaks(Category::Uorb, uorb(pair));
    }
}

/// How many elements a shape has, in words.
fn elements(shape: Shape) -> String {
    match shape {
        Shape::Single => "one value".to_owned(),
        Shape::Array(length) => format!("{length} elements"),
        Shape::Bounded(bound) => format!("up to {bound} elements"),
        Shape::Sequence => "any number of elements".to_owned(),
    }
}

/// How many characters a string has, in words; none where it is no string.
fn characters(element: Element) -> Option<String> {
    match element {
        Element::String { bound: Some(bound), .. } => Some(format!("up to {bound} characters")),
        Element::String { bound: None, .. } => Some("any number of characters".to_owned()),
        Element::Scalar(_) | Element::Message(_) => None,
    }
}
