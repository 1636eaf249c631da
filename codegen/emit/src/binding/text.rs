//! Documentation of declarations as plain text.

use uavspec_schema::json_type::Limits;
use uavspec_schema::value::Value;
use uavspec_schema::{Constant, Constraint, Docs, Field, Message, Package, Range, Schema, unit};

use super::declaration::Type;

/// Joins a description and a paragraph that lists facts.
pub(super) fn with_facts(description: &str, facts: &[String]) -> String {
    let facts = facts.join("; ");
    let mut text = description.trim().to_owned();
    let Some(first) = facts.chars().next() else { return text };
    if !text.is_empty() {
        text.push_str("\n\n");
    }
    text.extend(first.to_uppercase());
    text.push_str(&facts[first.len_utf8()..]);
    text.push('.');
    text
}

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
    let group = field.group.and_then(|group| message.groups.get(group));
    facts.extend(group.map(|group| format!("group: {}", group.summary)));
    facts.extend(unit(field.unit.as_deref()));
    facts.extend(field.constraints.iter().filter_map(|found| found.fact(str::to_owned, str::to_owned)));
    facts.extend(field.attributes().map(|(attribute, text)| attribute.to_text(text)));
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
            let facts: Vec<String> = unit(found.unit.as_deref()).into_iter().chain(constraints).collect();
            let facts = if facts.is_empty() { String::new() } else { format!(" ({})", facts.join("; ")) };
            format!("- parameter {}: {}{facts}", index + 1, found.description)
        })
        .collect();
    [text, &lines.join("\n")].into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>().join("\n\n")
}

/// The annotations of a value defined on a page.
pub(super) fn limits(limits: &Limits) -> Vec<String> {
    let int = |value: u32| Value::Int(value.into());
    let length = Range { low: limits.min.map(int), high: limits.max.map(int) };
    let mut facts: Vec<String> = unit(limits.unit.as_deref()).into_iter().collect();
    facts.extend(limits.range.as_ref().and_then(Range::to_text).map(|range| format!("range: {range}")));
    facts.extend(length.to_text().map(|length| format!("length: {length}")));
    facts.extend(limits.is_unique.then(|| "elements are unique".to_owned()));
    facts.extend(limits.pattern.as_ref().map(|pattern| format!("pattern: {pattern}")));
    facts.extend(limits.format.as_ref().map(|format| format!("format: {format}")));
    facts
}

fn unit(symbol: Option<&str>) -> Option<String> {
    let symbol = symbol.filter(|symbol| *symbol != unit::NONE)?;
    Some(match unit::lookup(symbol) {
        Some(unit) => format!("unit: {symbol} ({})", unit.name),
        None => format!("unit: {symbol}"),
    })
}
