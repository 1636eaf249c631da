//! The memory layout of messages: hints after fields, and pictures.

use lsp_types::{InlayHint, InlayHintKind, Label, Range, Tooltip};
use serde::Serialize;
use uavspec_emit::docs::picture;
use uavspec_schema::msg::Dialect;
use uavspec_schema::source::Span;
use uavspec_schema::{Message, UorbLayout};

use super::snapshot::Document;

/// The hints for the fields in a range: their offsets in uORB memory, and the padding after them.
pub(super) fn hints(document: &Document<'_>, range: Range) -> Vec<InlayHint> {
    if document.dialect() != Some(Dialect::Px4) {
        return Vec::new();
    }
    let wanted = document.lines.offsets(range);
    let schema = &document.snapshot.schema;
    let mut hints = Vec::new();
    for message in document.messages().into_iter().map(|(id, _)| schema.message(id)) {
        let Some(layout) = &message.uorb else { continue };
        for (at, slot) in layout.slots.iter().enumerate() {
            let Some(field) = slot.field.and_then(|field| message.fields.get(field)) else { continue };
            let end = document.snapshot.offsets(document.id, field.span).end;
            if wanted.start <= end && end <= wanted.end {
                let end = Span { start: field.span.end, end: field.span.end };
                hints.push(hint(document, layout, at, end));
            }
        }
    }
    hints.sort_by_key(|hint| hint.position);
    hints
}

fn hint(document: &Document<'_>, layout: &UorbLayout, at: usize, end: Span) -> InlayHint {
    let slot = &layout.slots[at];
    let padding = layout.slots.get(at + 1).filter(|next| next.field.is_none());
    let padding_text = padding.map(|padding| format!(", then {} padding", padding.size)).unwrap_or_default();
    let last = (slot.offset + slot.size).saturating_sub(1);
    let bytes =
        if slot.size == 1 { format!("Byte {last}") } else { format!("Bytes {} to {last}", slot.offset) };
    InlayHint {
        position: document.range(end).start,
        label: Label::String(format!("@{}{padding_text}", slot.offset)),
        kind: Some(InlayHintKind::Type),
        tooltip: Some(Tooltip::String(format!("{bytes} of {} in uORB memory", layout.size))),
        text_edits: None,
        padding_left: Some(true),
        padding_right: None,
        data: None,
    }
}

/// The picture of a message's memory layout.
#[derive(Debug, Serialize)]
pub(super) struct Picture {
    /// The name of the message.
    name: String,
    /// The picture.
    svg: String,
}

/// The pictures of the messages that a document defines. Messages without a fixed size have none.
pub(super) fn pictures(document: &Document<'_>) -> Vec<Picture> {
    if document.dialect() != Some(Dialect::Px4) {
        return Vec::new();
    }
    let schema = &document.snapshot.schema;
    let messages = document.messages().into_iter().map(|(id, _)| schema.message(id));
    let picture = |message: &Message| {
        let svg = picture::draw(schema, message, message.uorb.as_ref()?);
        Some(Picture { name: message.name.clone(), svg })
    };
    messages.filter_map(picture).collect()
}
