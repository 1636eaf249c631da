//! Pictures of memory layouts: rows of eight bytes, with a box for each field.

mod grid;
mod svg;

use uavspec_schema::wording::plural;
use uavspec_schema::{Element, Message, MessageId, Schema, Slot, UorbLayout};

use self::grid::{Grid, Member, Tint};
use super::site::Site;
use crate::file::OutputFile;

/// The path of the picture for a message page.
pub(super) fn path(page: &str) -> String {
    format!("{}.svg", page.strip_suffix(".md").unwrap_or(page))
}

/// The picture of a message's memory layout, as a file next to its page.
pub(super) fn file(site: &Site<'_>, id: MessageId) -> Option<OutputFile> {
    let message = site.schema.message(id);
    let text = draw(site.schema, message, site.layout(message)?);
    Some(OutputFile { path: path(site.path(id)), text })
}

/// Draws the memory layout of a message as SVG.
pub fn draw(schema: &Schema, message: &Message, layout: &UorbLayout) -> String {
    let members: Vec<Member<'_>> = layout.slots.iter().map(|slot| member(schema, message, slot)).collect();
    svg::draw(&Grid::new(&members, layout.size), &message.name, &caption(layout))
}

fn member<'s>(schema: &Schema, message: &'s Message, slot: &'s Slot) -> Member<'s> {
    let field = slot.field.map(|index| &message.fields[index]);
    let (tint, element_size) = match field.map(|field| field.ty.element) {
        None => (Tint::Padding, slot.size),
        Some(Element::Scalar(scalar)) => (Tint::of_scalar(scalar.size()), scalar.size()),
        Some(Element::Message(id)) => {
            (Tint::Nested, schema.message(id).uorb.as_ref().map_or(0, |layout| layout.size))
        }
        Some(Element::Text(_)) => (Tint::of_scalar(1), 1),
        Some(Element::String { .. }) => (Tint::Padding, 0),
    };
    let unit =
        field.and_then(|field| field.unit.as_deref()).filter(|unit| *unit != uavspec_schema::unit::NONE);
    Member { slot, tint, element_size, unit }
}

/// The caption with the total size.
fn caption(layout: &UorbLayout) -> String {
    let padding: usize = layout.slots.iter().filter(|slot| slot.field.is_none()).map(|slot| slot.size).sum();
    let size = plural(layout.size as u64, "byte");
    if padding == 0 { size } else { format!("{size}, {padding} of them padding") }
}
