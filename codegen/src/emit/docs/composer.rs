//! What a page needs to compose a message by hand: its fields, with their places in memory and the words that
//! people know them by. The script of the book makes controls of it; without one, nothing but a sentence is seen.

use serde_json::{Map, Value as Json, json};

use super::markdown::Page;
use super::site::Site;
use crate::emit::prose::{gist, visible, xml};
use crate::schema::{Dialect, Element, EnumRef, Field, Message, MessageId, Shape, UorbLayout};

/// Heading of the part of a page.
const TITLE: &str = "Compose";

/// Most controls of a page: with more of them, nobody finds the one that is looked for.
const MAX_CONTROLS: usize = 500;

/// Longest label of a control, in characters.
const MAX_LABEL: usize = 160;

/// Writes the part of a message's page where it is composed; nothing where it has no layout in memory, no fields,
/// or too many of them.
pub(super) fn write(page: &mut Page, site: &Site<'_>, id: MessageId) {
    let message = site.schema.message(id);
    let Some(layout) = site.layout(message) else { return };
    let controls = controls(site, message);
    if controls == 0 || controls > MAX_CONTROLS {
        return;
    }
    let data = json!({
        "name": message.name,
        "size": layout.size,
        "unpadded": layout.size_no_padding,
        "fields": fields(site, id, layout),
    });
    page.heading(2, TITLE);
    page.block(&format!("<div class=\"composer\" data-message=\"{}\">", embedded(&data)));
    page.block(
        "In the book, where scripts run, values are chosen here, and the message is shown as JSON and as uORB bytes.",
    );
    page.block("</div>");
}

/// Data as the value of an attribute. What stands in a text can neither hide nor be a mark of templates, which make
/// pages of others than mdBook.
fn embedded(data: &Json) -> String {
    let text: String = data.to_string().chars().map(visible).collect();
    xml(&text.replace("{{", "{\\u007b").replace("{%", "\\u007b%"))
}

/// How many controls a message needs.
fn controls(site: &Site<'_>, message: &Message) -> usize {
    let of_field = |field: &Field| match (field.ty.element, field.ty.shape) {
        (Element::Message(nested), Shape::Single) => controls(site, site.schema.message(nested)),
        (Element::Message(nested), Shape::Array(count)) => {
            controls(site, site.schema.message(nested)).saturating_mul(count as usize)
        }
        _ => 1,
    };
    message.fields.iter().map(of_field).fold(0, usize::saturating_add)
}

/// The fields of a message in declared order, which is that of JSON.
fn fields(site: &Site<'_>, id: MessageId, layout: &UorbLayout) -> Vec<Json> {
    let message = site.schema.message(id);
    let offset = |index| layout.slots.iter().find(|slot| slot.field == Some(index)).map(|slot| slot.offset);
    let fields = message.fields.iter().enumerate();
    fields.map(|(index, field)| described(site, message, field, offset(index))).collect()
}

fn described(site: &Site<'_>, message: &Message, field: &Field, offset: Option<usize>) -> Json {
    let mut data = Map::new();
    let mut put = |key: &str, value: Json| {
        let is_said = !matches!(&value, Json::Null) && value.as_str() != Some("");
        if is_said {
            data.insert(key.to_owned(), value);
        }
    };
    put("name", field.name.as_str().into());
    put("label", gist(&field.description, MAX_LABEL).into());
    put("group", field.group.map(|group| gist(&message.groups[group].summary, MAX_LABEL)).into());
    put("unit", super::fields::unit(field.unit.as_deref()).into());
    put("offset", offset.into());
    if let Shape::Array(count) = field.ty.shape {
        put("count", count.into());
    }
    match field.ty.element {
        Element::Scalar(_) if field.is_text(Dialect::Px4) => put("type", "text".into()),
        Element::Scalar(scalar) => {
            put("type", scalar.name().into());
            if let Some(held) = field.enumeration {
                put(
                    if site.schema.enumeration(held).is_flags { "flags" } else { "values" },
                    values(site, held),
                );
            }
        }
        Element::Message(nested) => {
            if let Some(layout) = site.schema.message(nested).uorb.as_ref() {
                put("size", layout.size.into());
                put("fields", fields(site, nested, layout).into());
            }
        }
        // A message that holds strings has no layout.
        Element::String { .. } => {}
    }
    data.into()
}

/// The members of an enum, without further names of the same value: value, name, description.
fn values(site: &Site<'_>, held: EnumRef) -> Json {
    let constants = &site.schema.message(held.message).constants;
    let found = site.schema.enumeration(held);
    let members = found.members.iter().filter(|member| found.alias_of(member).is_none());
    members
        .map(|member| {
            let description = gist(&constants[member.constant].description, MAX_LABEL);
            json!([member.value.to_string(), member.name, description])
        })
        .collect()
}
