//! `field-renamed`: a field was renamed.

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "field-renamed",
    statement: "A field was renamed; its type and position are the same.",
    why: "The bytes do not change. However, PX4 and ROS 2 include field names in the type hash, and peers with \
        different hashes reject each other.",
    fix: "Keep the name, or update all peers together.",
    breaks: &[
        (Category::Source, Level::Error),
        (Category::Json, Level::Error),
        (Category::Cdr, Level::Warning),
        (Category::Uorb, Level::Warning),
    ],
    old: &[glider!["float32 descent   # [m/s] Sink rate"]],
    new: &[glider!["float32 sink      # [m/s] Sink rate"]],
    check: Check::Field(check),
};

fn check(pair: &Pair<'_>, old: &Field, new: &Field, sink: &mut Sink<'_>) {
    if old.name == new.name {
        return;
    }
    let message =
        format!("`{}.{}` ({}) was renamed to `{}`", pair.name(), old.name, pair.new_type(new.ty), new.name);
    let mut change = sink.change(new.span, both(old.span, new.span), message);
    change
        .breaks(Category::Source, "programs that use the old name no longer compile")
        .breaks(Category::Json, "existing readers look for the old member and don't know the new member")
        .breaks(
            Category::Cdr,
            "the bytes are the same, but the type hash changes: peers that compare hashes reject each other",
        );
    if pair.is_uorb() {
        let help =
            "the bytes are the same, but the message hash changes, and log readers look for the old name";
        change.breaks(Category::Uorb, help);
    }
}
