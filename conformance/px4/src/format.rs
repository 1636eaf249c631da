//! The formats of types in logs.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use uavspec_dynamic::{Field, MessageType};
use uavspec_runtime::Scalar;
use uavspec_schema::{Element, shape_text};

/// The fields of a type's format, with the padding of the memory layout.
pub fn fields(ty: MessageType<'_>) -> String {
    let mut fields: Vec<&Field> = ty.fields().iter().collect();
    fields.sort_by_key(|field| field.offset);
    let (mut text, mut end, mut paddings) = (String::new(), 0, 0);
    // Writing to a string can't fail.
    let mut pad = |text: &mut String, from: usize, to: usize| {
        if to > from {
            let _ = write!(text, "uint8_t[{}] _padding{paddings};", to - from);
            paddings += 1;
        }
    };
    for field in fields {
        pad(&mut text, end, field.offset);
        let array = shape_text(field.ty().written().shape);
        let _ = write!(text, "{}{array} {};", name_of(ty, field), field.name);
        end = field.offset + field.stride * field.count();
    }
    pad(&mut text, end, ty.size().map_or(end, |size| size.padded));
    text
}

/// The types that a type contains, including the types in its nested messages.
pub fn nested(ty: MessageType<'_>) -> Vec<MessageType<'_>> {
    let mut found: Vec<MessageType<'_>> = Vec::new();
    let mut waiting = vec![ty];
    while let Some(ty) = waiting.pop() {
        for field in ty.fields() {
            let Element::Message(id) = field.element else { continue };
            let nested = ty.nested(id);
            if !found.iter().any(|known| known.name() == nested.name()) {
                found.push(nested);
                waiting.push(nested);
            }
        }
    }
    found
}

/// The definition of a format as bags store it: the text of a `.msg` file, followed by those of the nested types. `package` is
/// the ROS package of these types. `None` if two nested types get the same name.
pub fn bag_text(format: MessageType<'_>, package: &str) -> Option<String> {
    let mut text = declarations(format);
    let mut names = BTreeSet::new();
    for nested in nested(format) {
        let name = message_name(nested.name());
        if !names.insert(name.clone()) {
            return None;
        }
        let _ = write!(text, "{}\nMSG: {package}/{name}\n{}", "=".repeat(80), declarations(nested));
    }
    Some(text)
}

/// The fields of a format, each on a line.
fn declarations(format: MessageType<'_>) -> String {
    let mut text = String::new();
    for field in format.fields() {
        let ty = field.ty().written();
        let element = match ty.element {
            Element::Scalar(scalar) => scalar.name().to_owned(),
            Element::Message(id) => message_name(format.nested(id).name()),
            // Formats have no strings, and a text is written as an array.
            Element::Text(_) | Element::String { .. } => String::new(),
        };
        let _ = writeln!(text, "{element}{} {}", shape_text(ty.shape), field.name);
    }
    text
}

/// The name of the message of a format: the format's name in `PascalCase`.
pub fn message_name(format: &str) -> String {
    let words = format.split('_').filter_map(|word| {
        let mut letters = word.chars();
        Some(letters.next()?.to_uppercase().chain(letters).collect::<String>())
    });
    words.collect()
}

/// The name of a nested type: the message's name in `snake_case`, as in topic names.
pub fn format_name(message: &str) -> String {
    let mut text = String::new();
    for (at, letter) in message.char_indices() {
        if letter.is_ascii_uppercase() && at > 0 {
            text.push('_');
        }
        text.push(letter.to_ascii_lowercase());
    }
    text
}

/// The name of a field's type.
fn name_of(ty: MessageType<'_>, field: &Field) -> String {
    match field.element {
        Element::Scalar(scalar) => match scalar {
            Scalar::Float32 => "float".to_owned(),
            Scalar::Float64 => "double".to_owned(),
            Scalar::Bool | Scalar::Char => scalar.name().to_owned(),
            _ => format!("{}_t", scalar.name()),
        },
        Element::Text(_) => "char".to_owned(),
        // Messages of a fixed size have no strings.
        Element::String { .. } => String::new(),
        Element::Message(id) => format_name(ty.nested(id).name()),
    }
}
