//! `field-added`: a field was added.

use uavspec_schema::Message;

use super::message::FieldChange;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "field-added",
    statement: "A field was added.",
    why: "Existing messages lack the field and are encoded differently, so all peers must be updated together.",
    fix: "Update all peers together, and raise `MESSAGE_VERSION` of a versioned message.",
    breaks: &[
        (Category::Source, Level::Warning),
        (Category::Json, Level::Error),
        (Category::Cdr, Level::Error),
        (Category::Uorb, Level::Error),
    ],
    old: &[glider!["float32 sink      # [m/s] Sink rate"]],
    new: &[glider!["float32 bank      # [rad] Bank angle", "float32 sink      # [m/s] Sink rate"]],
    check: Check::Message(check),
};

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    // All fields from this index on were added.
    let end = pair.kept().map(|kept| kept.new + 1).max().unwrap_or(0);
    for change in &pair.fields {
        let FieldChange::Added(at) = *change else { continue };
        let field = &pair.new.fields[at];
        let cdr = if at >= end {
            "messages are longer: existing readers reject the extra bytes, and new readers don't find the field in \
                old messages"
        } else {
            "all later fields move, so existing readers decode the new field's bytes as other fields"
        };
        let message = format!("`{}.{}` ({}) was added", pair.name(), field.name, pair.new_type(field.ty));
        let mut change = sink.change(field.span, Sides { old: None, new: Some(field.span) }, message);
        change
            .breaks(
                Category::Source,
                "Rust code that constructs the message without the field no longer compiles",
            )
            .breaks(Category::Json, "old messages lack the field, and existing readers don't know it")
            .breaks(Category::Cdr, cdr);
        if pair.is_uorb() {
            change.breaks(Category::Uorb, uorb(pair));
        }
    }
}

/// Describes the change in memory layout.
pub(super) fn uorb(pair: &Pair<'_>) -> String {
    let size = |message: &Message| message.uorb.as_ref().map_or(0, |layout| layout.size);
    let (before, now) = (size(pair.old), size(pair.new));
    if before == now {
        "the layout changes but the size doesn't: existing programs interpret the bytes as other fields"
            .to_owned()
    } else {
        format!(
            "the layout changes: {now} bytes instead of {before}; log readers can still find fields by name"
        )
    }
}
