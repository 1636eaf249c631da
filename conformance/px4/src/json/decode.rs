//! Decodes JSON messages in the forms that programs write: with the deviations that `check` accepts.

use serde_json::{Number, Value};
use uavspec_dynamic::{DynamicMessage, Field, MessageType};
use uavspec_model::json::{Tree, base64};
use uavspec_schema::{Element, Shape};

use super::dialect::{Dialect, Dialects};
use super::value::is_byte;

/// Decodes a message. Returns the message, and the deviations that it uses. Values may violate their definitions.
pub fn decode<'t>(
    tree: &Tree<'_>,
    ty: MessageType<'t>,
    is_rosbridge: bool,
) -> Result<(DynamicMessage<'t>, Dialects), String> {
    if tree.repeats_a_key() {
        return Err("a field appears twice".to_owned());
    }
    let mut reading = Reading { is_rosbridge, dialects: Dialects::default() };
    let value = reading.message(tree, ty)?;
    let message = ty.from_json(&value).map_err(|error| error.to_string())?;
    Ok((message, reading.dialects))
}

/// Converts values to the form of the published schemas.
struct Reading {
    is_rosbridge: bool,
    dialects: Dialects,
}

impl Reading {
    fn message(&mut self, tree: &Tree<'_>, ty: MessageType<'_>) -> Result<Value, String> {
        let Tree::Object(members) = tree else { return Err(format!("expected an object, found {tree}")) };
        let fields = ty.fields();
        let converted = members.iter().enumerate().map(|(at, (key, value))| {
            // Most messages list their fields in the order of the definition.
            let guess = fields.get(at).filter(|field| *field.name == **key);
            let value = match guess.or_else(|| ty.field(key)) {
                Some(field) => self
                    .field(value, ty, field)
                    .map_err(|error| format!("{}.{}: {error}", ty.name(), field.name))?,
                // The decoder reports the unknown field.
                None => Value::Null,
            };
            Ok((key.to_string(), value))
        });
        converted.collect::<Result<serde_json::Map<_, _>, String>>().map(Value::Object)
    }

    fn field(&mut self, tree: &Tree<'_>, ty: MessageType<'_>, field: &Field) -> Result<Value, String> {
        match (tree, field.element) {
            (_, Element::Text(room)) if field.shape == Shape::Single => self.text(tree, room),
            (Tree::Text(text), element) if is_byte(element) && field.shape != Shape::Single => {
                let bytes = self.base64(text).ok_or("expected an array or base64")?;
                Ok(bytes.into())
            }
            (Tree::List(values), element) if field.shape != Shape::Single => values
                .iter()
                .map(|value| self.element(value, ty, element))
                .collect::<Result<_, _>>()
                .map(Value::Array),
            (_, element) => self.element(tree, ty, element),
        }
    }

    fn element(&mut self, tree: &Tree<'_>, ty: MessageType<'_>, element: Element) -> Result<Value, String> {
        Ok(match (tree, element) {
            (Tree::Object(_), Element::Message(id)) => return self.message(tree, ty.nested(id)),
            (_, Element::Text(room)) => return self.text(tree, room),
            (Tree::Null, _) => Value::Null,
            (Tree::Token("NaN"), _) => {
                self.dialects.insert(Dialect::BareNan);
                Value::Null
            }
            (Tree::Bool(value), _) => (*value).into(),
            (Tree::Float(value, _), Element::Scalar(scalar)) if scalar.is_float() => (*value).into(),
            (Tree::Int(_) | Tree::Float(..), _) => {
                let value = tree.as_integer().ok_or_else(|| format!("expected an integer, found {tree}"))?;
                Number::from_i128(value).map_or(Value::Null, Value::Number)
            }
            (Tree::Text(text), _) => (&**text).into(),
            _ => return Err(format!("unexpected value: {tree}")),
        })
    }

    /// Reads PX4's `char[N]`.
    fn text(&mut self, tree: &Tree<'_>, room: u32) -> Result<Value, String> {
        let bytes = match tree {
            // The base64 of an array is longer than any text that fits into the array.
            Tree::Text(text) if text.len() > room as usize => {
                self.base64(text).ok_or("the text is too long")?
            }
            Tree::Text(text) => return Ok((&**text).into()),
            Tree::List(values) if self.is_rosbridge => {
                self.dialects.insert(Dialect::NumbersForText);
                let byte = |value: &Tree<'_>| u8::try_from(value.as_integer()?).ok();
                let bytes: Option<Vec<u8>> = values.iter().map(byte).collect();
                bytes.ok_or("expected integers from 0 to 255")?
            }
            _ => return Err(format!("expected a string, found {tree}")),
        };
        if bytes.len() != room as usize {
            return Err(format!("expected {room} bytes, found {}", bytes.len()));
        }
        let end = memchr::memchr(0, &bytes).unwrap_or(bytes.len());
        std::str::from_utf8(&bytes[..end]).map(Value::from).map_err(|error| error.to_string())
    }

    fn base64(&mut self, text: &str) -> Option<Vec<u8>> {
        let bytes = base64::decode(text).filter(|_| self.is_rosbridge)?;
        self.dialects.insert(Dialect::Base64);
        Some(bytes)
    }
}
