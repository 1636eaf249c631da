//! Documentation of declarations as plain text.

use uavspec_schema::{Constant, Constraint, Docs, Field, Message, Package, Schema};

use super::declaration::Type;
use crate::facts::{PLAIN, with_facts};

/// The documentation of a definition, or `default` if it has none.
pub(super) fn documentation(docs: &Docs, default: impl FnOnce() -> String) -> String {
    let text = docs.text();
    if text.is_empty() { default() } else { text }
}

/// The documentation of a package.
pub(super) fn package(package: &Package) -> String {
    let mut lines = vec![format!("Package {}, in the {} dialect.", package.name, package.form.name())];
    lines.extend(package.origin.as_ref().map(|origin| format!("Origin: {origin}")));
    lines.extend(package.revision.as_ref().map(|revision| format!("Revision: {revision}")));
    lines.join("\n\n")
}

/// The documentation of a message.
pub(super) fn message(message: &Message) -> String {
    let mut facts = Vec::new();
    if !message.topics.is_empty() {
        facts.push(format!("topics: {}", message.topics.join(", ")));
    }
    facts.extend(message.version.map(|version| format!("message version: {version}")));
    facts.extend(message.queue_length.map(|length| format!("queue length: {length}")));
    let default = || format!("Message {}; the definition has no description.", message.name);
    with_facts(&documentation(&message.docs, default), &facts)
}

/// The documentation of a field of a message. `ty` is the type in the declaration.
pub(super) fn field(schema: &Schema, message: &Message, field: &Field, ty: &Type) -> String {
    let mut facts = vec![format!("type: {}", schema.type_text(message, field.ty))];
    facts.extend(values(ty));
    facts.extend(PLAIN.field(message, field));
    let counted = field.counts.and_then(|array| message.fields.get(array));
    facts.extend(counted.map(|array| format!("number of used entries in {}", array.name)));
    let is_float = field.ty.element.is_float();
    facts.extend(is_float.then(|| "null represents NaN".to_owned()));
    with_facts(&field.description, &facts)
}

/// The declarations that name the values of a type: enums, sets and error codes. Editors show the documentation of a
/// field, but not always its type.
pub(super) fn values(ty: &Type) -> Option<String> {
    let names = named_values(ty);
    (!names.is_empty()).then(|| format!("values: {}", names.join(", ")))
}

fn named_values(ty: &Type) -> Vec<String> {
    match ty {
        Type::Enumeration { module: Some(module), name } => vec![format!("{module}.{name}")],
        Type::Enumeration { module: None, name } | Type::Set(name) => vec![name.clone()],
        Type::List(inner) | Type::Map(inner) => named_values(inner),
        Type::Tuple(elements) => elements.iter().flat_map(|(_, _, element)| named_values(element)).collect(),
        Type::Either(alternatives) => alternatives.iter().flat_map(named_values).collect(),
        _ => Vec::new(),
    }
}

/// The documentation of a constant.
pub(super) fn constant(constant: &Constant) -> String {
    let text = match constant.name.as_str() {
        _ if !constant.description.is_empty() => constant.description.as_str(),
        "MESSAGE_VERSION" => "Version of the message, incremented when its fields change.",
        "ORB_QUEUE_LENGTH" => "Number of messages queued per topic before the oldest is dropped.",
        _ => "",
    };
    let parameters = constant.parameters.iter().enumerate().filter(|(_, found)| !found.is_unused());
    let lines: Vec<String> = parameters
        .map(|(index, found)| {
            let constraints = found.constraints.iter().filter(|found| !found.is_special());
            let constraints = constraints.filter_map(Constraint::valid_values);
            let facts: Vec<String> =
                PLAIN.unit(found.unit.as_deref()).into_iter().chain(constraints).collect();
            let facts = if facts.is_empty() { String::new() } else { format!(" ({})", facts.join("; ")) };
            format!("- parameter {}: {}{facts}", index + 1, found.description)
        })
        .collect();
    [text, &lines.join("\n")].into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>().join("\n\n")
}
