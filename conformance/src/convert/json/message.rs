//! JSON messages in the forms that programs write: with the deviations that `check` accepts.

use serde_json::{Number, Value};
use uavspec_codegen::dynamic::{DynamicMessage, MessageType, Placed, PlacedElement};
use uavspec_codegen::schema::Shape;
use uavspec_runtime::Scalar;

use crate::json::{Tree, base64};
use crate::px4::json::{Dialect, Dialects};

/// Parses a message. Returns the message, and the deviations that it uses.
pub(super) fn read<'t>(
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

/// Writes a message with these deviations.
pub(super) fn write(message: &DynamicMessage<'_>, dialects: Dialects) -> Result<String, String> {
    let text = message.view().to_json_text().map_err(|error| error.to_string())?;
    let has = |wanted| dialects.iter().any(|dialect| dialect == wanted);
    let notation = match (has(Dialect::Base64), has(Dialect::NumbersForText)) {
        (false, false) => return Ok(text),
        (is_base64, has_numbers) => Notation { is_base64, has_numbers },
    };
    let mut value = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    notation.apply(&mut value, message.message_type());
    serde_json::to_string(&value).map_err(|error| error.to_string())
}

/// True if two types have the same JSON messages, provided that they have the same CDR payloads.
pub(super) fn has_same_names(source: MessageType<'_>, target: MessageType<'_>) -> bool {
    source.layout().zip(target.layout()).all(|(source, target)| {
        source.name == target.name
            && match (source.element, target.element) {
                (PlacedElement::Message(source), PlacedElement::Message(target)) => {
                    has_same_names(source, target)
                }
                _ => true,
            }
    })
}

/// Converts values to the form of the published schemas.
struct Reading {
    is_rosbridge: bool,
    dialects: Dialects,
}

impl Reading {
    fn message(&mut self, tree: &Tree<'_>, ty: MessageType<'_>) -> Result<Value, String> {
        let Tree::Object(members) = tree else { return Err(format!("expected an object, found {tree}")) };
        let fields: Vec<Placed<'_>> = ty.layout().collect();
        let converted = members.iter().enumerate().map(|(at, (key, value))| {
            // Most messages list their fields in the order of the definition.
            let guess = fields.get(at).filter(|field| field.name == key);
            let value = match guess.or_else(|| fields.iter().find(|field| field.name == key)) {
                Some(field) => self
                    .field(value, field)
                    .map_err(|error| format!("{}.{}: {error}", ty.name(), field.name))?,
                // The decoder reports the unknown field.
                None => Value::Null,
            };
            Ok((key.to_string(), value))
        });
        converted.collect::<Result<serde_json::Map<_, _>, String>>().map(Value::Object)
    }

    fn field(&mut self, tree: &Tree<'_>, field: &Placed<'_>) -> Result<Value, String> {
        match (tree, field.element) {
            (_, PlacedElement::Text(room)) if field.shape == Shape::Single => self.text(tree, room),
            (Tree::Text(text), element) if is_bytes(element) && field.shape != Shape::Single => {
                let bytes = self.base64(text).ok_or("expected an array or base64")?;
                Ok(bytes.into())
            }
            (Tree::List(values), element) if field.shape != Shape::Single => values
                .iter()
                .map(|value| self.element(value, element))
                .collect::<Result<_, _>>()
                .map(Value::Array),
            (_, element) => self.element(tree, element),
        }
    }

    fn element(&mut self, tree: &Tree<'_>, element: PlacedElement<'_>) -> Result<Value, String> {
        Ok(match (tree, element) {
            (Tree::Object(_), PlacedElement::Message(ty)) => return self.message(tree, ty),
            (_, PlacedElement::Text(room)) => return self.text(tree, room),
            // The deviation `NaN` isn't kept, because the token isn't JSON.
            (Tree::Null | Tree::Token("NaN"), _) => Value::Null,
            (Tree::Bool(value), _) => (*value).into(),
            (Tree::Int(value), _) => Number::from_i128(*value).map_or(Value::Null, Value::Number),
            (Tree::Float(value, _), _) => (*value).into(),
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
                let byte = |value: &Tree<'_>| match value {
                    Tree::Int(value) => u8::try_from(*value).ok(),
                    _ => None,
                };
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

/// The notation of bytes in a message.
#[derive(Clone, Copy)]
struct Notation {
    /// True if arrays of bytes are base64.
    is_base64: bool,
    /// True if text is an array of numbers.
    has_numbers: bool,
}

impl Notation {
    fn apply(self, message: &mut Value, ty: MessageType<'_>) {
        for field in ty.layout() {
            let Some(value) = message.get_mut(field.name) else { continue };
            match (field.element, value) {
                (PlacedElement::Message(ty), Value::Array(elements)) => {
                    for element in elements {
                        self.apply(element, ty);
                    }
                }
                (PlacedElement::Message(ty), value) => self.apply(value, ty),
                (PlacedElement::Text(room), value) => {
                    let mut bytes = value.as_str().unwrap_or_default().as_bytes().to_vec();
                    bytes.resize(room as usize, 0);
                    *value = if self.has_numbers { bytes.into() } else { base64::encode(&bytes).into() };
                }
                (element, value @ Value::Array(_)) if self.is_base64 && is_bytes(element) => {
                    let byte = |value: &Value| value.as_u64().and_then(|value| u8::try_from(value).ok());
                    let bytes: Option<Vec<u8>> =
                        value.as_array().and_then(|all| all.iter().map(byte).collect());
                    *value = base64::encode(&bytes.unwrap_or_default()).into();
                }
                _ => {}
            }
        }
    }
}

/// True if rosbridge writes an array with these elements as base64.
fn is_bytes(element: PlacedElement<'_>) -> bool {
    matches!(element, PlacedElement::Scalar(Scalar::UInt8 | Scalar::Byte | Scalar::Char))
}
