//! `field-frame-changed`: the coordinate frame of a field changed.

use uavspec_schema::msg::attribute::FRAME;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "field-frame-changed",
    statement: "The coordinate frame of a field changed.",
    why: "The same numbers now mean a different direction or position, and nothing in the data reveals the change.",
    fix: "Keep the frame, or add a new field with the new frame.",
    breaks: &[(Category::Semantic, Level::Error)],
    old: &[glider!["float32[3] wind   # [m/s] [@frame NED] Wind"]],
    new: &[glider!["float32[3] wind   # [m/s] [@frame FRD] Wind"]],
    check: Check::Field(check),
};

fn check(pair: &Pair<'_>, old: &Field, new: &Field, sink: &mut Sink<'_>) {
    let (Some(before), Some(now)) = (old.attribute(&FRAME), new.attribute(&FRAME)) else { return };
    if pair.is_same_frame(before, now) {
        return;
    }
    let message = format!("`{}.{}` is in frame {now} instead of {before}", pair.name(), new.name);
    sink.change(new.span, both(old.span, new.span), message).breaks(
        Category::Semantic,
        "existing programs interpret the numbers as a different direction or position",
    );
}
