//! The JSON Schemas of messages, as bags contain them.
//!
//! The published schemas are more precise, but refer to each other. Programs that show bags, such as Foxglove, read only
//! schemas without references.

use serde_json::{Map, Value, json};
use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Field, MessageId, Schema, Shape};

/// The schema of a message as text.
pub(super) fn text(schema: &Schema, id: MessageId) -> Vec<u8> {
    message(schema, id).to_string().into_bytes()
}

fn message(schema: &Schema, id: MessageId) -> Value {
    let message = schema.message(id);
    let properties = message.fields.iter().map(|one| (one.name.clone(), field(schema, one)));
    let names: Vec<&str> = message.fields.iter().map(|field| field.name.as_str()).collect();
    json!({
        "title": message.name,
        "type": "object",
        "properties": properties.collect::<Map<_, _>>(),
        "required": names,
    })
}

fn field(schema: &Schema, field: &Field) -> Value {
    let element = element(schema, field);
    match field.ty.shape {
        Shape::Single => element,
        Shape::Array(length) => {
            json!({ "type": "array", "items": element, "minItems": length, "maxItems": length })
        }
        Shape::Bounded(bound) => json!({ "type": "array", "items": element, "maxItems": bound }),
        Shape::Sequence => json!({ "type": "array", "items": element }),
    }
}

fn element(schema: &Schema, field: &Field) -> Value {
    let ty = match field.ty.element {
        Element::Message(id) => return message(schema, id),
        Element::Scalar(Scalar::Bool) => "boolean",
        Element::Scalar(scalar) if scalar.is_float() => "number",
        Element::Scalar(_) => "integer",
        Element::Text(_) | Element::String { .. } => "string",
    };
    json!({ "type": ty })
}
