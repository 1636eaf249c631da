//! Data for the script that lets readers compose a message: fields, offsets in memory, and labels. Without the script,
//! the composer section shows only one sentence.

use serde_json::{Map, Value as Json, json};
use uavspec_schema::prose::{gist, visible, xml};
use uavspec_schema::translation::MessageText;
use uavspec_schema::{Element, EnumRef, Field, Message, MessageId, Shape, UorbLayout, unit};

use super::language::heading;
use super::markdown::Page;
use super::site::{Localized, Site};
use super::words::{self, Word, Words};

/// Maximum number of controls on a page. Larger forms would be unusable.
const MAX_CONTROLS: usize = 500;

/// Maximum number of levels of nested messages in a form.
const MAX_DEPTH: usize = 16;

/// Maximum length of a label, in characters.
const MAX_LABEL: usize = 160;

/// User interface text, by the names used in the script.
const WORDS: [(&str, Word); 20] = [
    ("fieldsOf", words::FIELDS_OF),
    ("setToZero", words::SET_TO_ZERO),
    ("copyJson", words::COPY_JSON),
    ("copyBytes", words::COPY_BYTES),
    ("copied", words::COPIED),
    ("copyingRefused", words::COPYING_REFUSED),
    ("padding", words::PADDING),
    ("byteOf", words::BYTE_OF),
    ("byteIs", words::BYTE_IS),
    ("andMore", words::AND_MORE),
    ("anotherValue", words::ANOTHER_VALUE),
    ("upToBytes", words::UP_TO_BYTES),
    ("upToValues", words::UP_TO_VALUES),
    ("notAllFit", words::NOT_ALL_FIT),
    ("expectedInteger", words::EXPECTED_INTEGER),
    ("expectedNumber", words::EXPECTED_NUMBER),
    ("expectedBool", words::EXPECTED_BOOL),
    ("outOfRange", words::OUT_OF_RANGE),
    ("tooManyBytes", words::TOO_MANY_BYTES),
    ("tooManyValues", words::TOO_MANY_VALUES),
];

/// Writes the composer section of a message page. Skips messages with no memory layout, no fields, or too many fields.
pub(super) fn write(page: &mut Page, site: &Site<'_>, id: MessageId) {
    let message = site.schema.message(id);
    let Some(layout) = site.layout(message) else { return };
    let controls = controls(site, message, 0);
    if controls == 0 || controls > MAX_CONTROLS {
        return;
    }
    let words: Map<String, Json> =
        WORDS.iter().map(|(name, word)| ((*name).to_owned(), site.words.get(*word).into())).collect();
    let data = json!({
        "name": message.name,
        "size": layout.size,
        "title": site.words.fill(words::UORB_OF_SIZE, &[("size", &size(site.words, layout))]),
        "words": words,
        "fields": fields(site, id, layout),
    });
    heading(page, site.words, 2, words::COMPOSE);
    page.block(&format!("<div class=\"composer\" data-message=\"{}\">", embedded(&data)));
    page.block(site.words.get(words::COMPOSE_MEANS));
    page.block("</div>");
}

/// The size of a message in memory, with its padding.
fn size(words: Words, layout: &UorbLayout) -> String {
    let size = words.bytes(layout.size as u64);
    match layout.size - layout.size_no_padding {
        0 => size,
        padding => words.fill(words::PADDED_SIZE, &[("size", &size), ("padding", &padding.to_string())]),
    }
}

/// Escapes data for an HTML attribute. Invisible characters are replaced, and template syntax of site generators is
/// escaped.
fn embedded(data: &Json) -> String {
    let text: String = data.to_string().chars().map(visible).collect();
    xml(&text.replace("{{", "{\\u007b").replace("{%", "\\u007b%"))
}

/// The number of controls needed for a message. More than the maximum if messages are nested too deeply.
fn controls(site: &Site<'_>, message: &Message, depth: usize) -> usize {
    if depth > MAX_DEPTH {
        return usize::MAX;
    }
    let nested = |id: MessageId| controls(site, site.schema.message(id), depth + 1);
    let count = |field: &Field| match (field.ty.element, field.ty.shape) {
        (Element::Message(id), Shape::Single) => nested(id),
        (Element::Message(id), Shape::Array(count)) => nested(id).saturating_mul(count as usize),
        _ => 1,
    };
    message.fields.iter().map(count).fold(0, usize::saturating_add)
}

/// The fields of a message in declaration order, as in JSON.
fn fields(site: &Site<'_>, id: MessageId, layout: &UorbLayout) -> Vec<Json> {
    let fields = 0..site.schema.message(id).fields.len();
    let offsets = layout.offsets();
    fields.map(|index| field(site, id, index, offsets.get(&index).copied())).collect()
}

fn field(site: &Site<'_>, id: MessageId, index: usize, offset: Option<usize>) -> Json {
    let field = &site.schema.message(id).fields[index];
    let mut data = Map::new();
    let mut put = |key: &str, value: Json| {
        let is_present = !value.is_null() && value.as_str() != Some("");
        if is_present {
            data.insert(key.to_owned(), value);
        }
    };
    let label = site.localized_of(id, MessageText::Field(index));
    put("name", field.name.as_str().into());
    put("label", short(label));
    put("lang", label.tag.into());
    put("group", field.group.map(|group| short(site.localized_of(id, MessageText::Group(group)))).into());
    // The script shows plain text, not Markdown.
    put("unit", field.unit.as_deref().filter(|symbol| *symbol != unit::NONE).into());
    put("offset", offset.into());
    if let Shape::Array(count) = field.ty.written().shape {
        put("count", count.into());
    }
    match field.ty.element {
        Element::Text(_) => put("type", "text".into()),
        Element::Scalar(scalar) => {
            put("type", scalar.name().into());
            if let Some(reference) = field.enumeration {
                put(
                    if site.schema.enumeration(reference).is_flags { "flags" } else { "values" },
                    values(site, reference),
                );
            }
        }
        Element::Message(nested) => {
            if let Some(layout) = site.schema.message(nested).uorb.as_ref() {
                put("size", layout.size.into());
                put("fields", fields(site, nested, layout).into());
            }
        }
        // A message that contains strings has no memory layout.
        Element::String { .. } => {}
    }
    data.into()
}

/// Shortens a text to a label.
fn short(text: Localized<'_>) -> Json {
    gist(text.text, MAX_LABEL).into()
}

/// The value, name and description of each enum member. Aliases are skipped.
fn values(site: &Site<'_>, reference: EnumRef) -> Json {
    let found = site.schema.enumeration(reference);
    let members = found.with_aliases().filter(|(_, alias_of)| alias_of.is_none());
    members
        .map(|(member, _)| {
            let description =
                short(site.localized_of(reference.message, MessageText::Constant(member.constant)));
            json!([member.value.to_string(), member.name, description])
        })
        .collect()
}
