//! `field-removed`: a field was removed.

use super::field_added::uorb;
use super::message::FieldChange;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "field-removed",
    statement: "A field was removed.",
    why: "Programs that use the field no longer compile. The encoding of the message changes, so all peers \
        must be updated together.",
    fix: "Keep the field, and mark it as deprecated in its comment. Otherwise update all peers together.",
    breaks: &[
        (Category::Source, Level::Error),
        (Category::Json, Level::Error),
        (Category::Cdr, Level::Error),
        (Category::Uorb, Level::Error),
    ],
    old: &[glider!["float32 bank      # [rad] Bank angle", "float32 sink      # [m/s] Sink rate"]],
    new: &[glider!["float32 sink      # [m/s] Sink rate"]],
    check: Check::Message(check),
};

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    // All fields from this index on were removed.
    let end = pair.kept().map(|kept| kept.old + 1).max().unwrap_or(0);
    for change in &pair.fields {
        let FieldChange::Removed(at) = *change else { continue };
        let field = &pair.old.fields[at];
        let message = format!("`{}.{}` ({}) was removed", pair.name(), field.name, pair.old_type(field.ty));
        let cdr = if at >= end {
            "messages are shorter: existing readers expect more bytes, and new readers reject the extra bytes of old \
                messages"
        } else {
            "all later fields move, so existing readers decode the wrong bytes for them"
        };
        let mut change = sink.change(pair.head(), Sides { old: Some(field.span), new: None }, message);
        change
            .breaks(Category::Source, "programs that use the field no longer compile")
            .breaks(
                Category::Json,
                "existing readers don't find the member, and existing writers send an unknown member",
            )
            .breaks(Category::Cdr, cdr);
        if pair.is_uorb() {
            change.breaks(Category::Uorb, uorb(pair));
        }
    }
}
