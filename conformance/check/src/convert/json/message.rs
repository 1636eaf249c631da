//! Writes JSON messages in the form in which programs write them, with the deviations that `check` accepts.

use serde_json::Value;
use uavspec_dynamic::{DynamicMessage, MessageType};
use uavspec_model::json::base64;
use uavspec_px4::json::{Dialect, Dialects, is_byte};
use uavspec_schema::Element;

/// Writes a message with these deviations. `NaN` becomes `null`, because the token isn't JSON.
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

/// True if two types have the same JSON messages. The types must have the same CDR payloads.
pub(super) fn has_same_names(source: MessageType<'_>, target: MessageType<'_>) -> bool {
    source.fields().iter().zip(target.fields()).all(|(old, new)| {
        old.name == new.name
            && match (old.element, new.element) {
                (Element::Message(old), Element::Message(new)) => {
                    has_same_names(source.nested(old), target.nested(new))
                }
                _ => true,
            }
    })
}

/// The notation of bytes in a message.
#[derive(Clone, Copy)]
struct Notation {
    /// True if arrays of bytes are written as base64.
    is_base64: bool,
    /// True if text is written as an array of numbers.
    has_numbers: bool,
}

impl Notation {
    fn apply(self, message: &mut Value, ty: MessageType<'_>) {
        for field in ty.fields() {
            let Some(value) = message.get_mut(&*field.name) else { continue };
            match (field.element, value) {
                (Element::Message(id), Value::Array(elements)) => {
                    for element in elements {
                        self.apply(element, ty.nested(id));
                    }
                }
                (Element::Message(id), value) => self.apply(value, ty.nested(id)),
                (Element::Text(room), value) => {
                    let mut bytes = value.as_str().unwrap_or_default().as_bytes().to_vec();
                    bytes.resize(room as usize, 0);
                    *value = if self.has_numbers { bytes.into() } else { base64::encode(&bytes).into() };
                }
                (element, value @ Value::Array(_)) if self.is_base64 && is_byte(element) => {
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
