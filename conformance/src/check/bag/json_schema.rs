//! Compares the JSON Schema in a file with the definition.
//!
//! Only explicit statements are compared: the names of properties, their types, and whether they are required. `number`
//! matches an integer, since many writers have no integer type. A missing type matches anything, and so does `anyOf`.

use serde_json::Value;
use uavspec_codegen::schema::{self, Dialect, Element, Field, Form, MessageId, Schema, Shape};
use uavspec_runtime::Scalar;

use crate::px4::comparison::{Comparison, Differences};

/// The maximum depth of compared objects. Definitions don't nest more deeply than this.
const MAX_DEPTH: usize = 32;

/// The maximum number of consecutive references to follow.
const MAX_REFERENCES: usize = 8;

/// Compares the text of a schema with a definition. Returns `None` if the schema has no properties. The error is a
/// one-line message.
pub(super) fn compare(
    text: &[u8],
    defined: MessageId,
    schema: &Schema,
) -> Result<Option<Comparison>, String> {
    let root: Value = serde_json::from_slice(text).map_err(|error| error.to_string())?;
    let comparing = Comparing { root: &root, schema };
    let Some(differences) = comparing.message(&root, defined, 0) else { return Ok(None) };
    let is_equal = differences == Differences::default();
    Ok(Some(if is_equal { Comparison::Equal } else { Comparison::Differs(differences) }))
}

struct Comparing<'s> {
    root: &'s Value,
    schema: &'s Schema,
}

impl<'s> Comparing<'s> {
    /// The differences between an object and a message. `None` if the object has no properties.
    fn message(&self, found: &'s Value, defined: MessageId, depth: usize) -> Option<Differences> {
        let found = self.followed(found);
        let properties = found.get("properties")?.as_object()?;
        let required = found.get("required").and_then(Value::as_array);
        let message = self.schema.message(defined);
        let mut differences = Differences::default();
        for field in &message.fields {
            let types = self.types_of(message, field);
            let Some(property) = properties.get(&field.name) else {
                differences.missing.push(format!("{} ({})", field.name, types.join(" or ")));
                continue;
            };
            if let Some(stated) = self.contradicted(property, &types) {
                differences.retyped.push(format!(
                    "{} ({stated}, defined as {})",
                    field.name,
                    types.join(" or ")
                ));
            } else if let Element::Message(nested) = field.ty.element
                && depth < MAX_DEPTH
                && self
                    .element(property, field)
                    .and_then(|element| self.message(element, nested, depth + 1))
                    .is_some_and(|nested| nested != Differences::default())
            {
                differences.nested.push(field.name.clone());
            } else if let (Element::Scalar(_), Some(items)) = (field.ty.element, self.items(property))
                && let Some(stated) = self.contradicted(items, &[element_type(field)])
            {
                let ty = element_type(field);
                let text = format!("{} (array of {stated}, defined as array of {ty})", field.name);
                differences.retyped.push(text);
            }
            let is_required =
                |required: &Vec<Value>| required.iter().any(|name| *name == field.name.as_str());
            if required.is_some_and(|required| !is_required(required)) {
                differences.optional.push(field.name.clone());
            }
        }
        let is_defined = |name: &str| message.fields.iter().any(|field| field.name == name);
        let extra = properties.iter().filter(|(name, _)| !is_defined(name));
        differences.extra = extra
            .map(|(name, property)| {
                let stated = stated(self.followed(property)).unwrap_or_else(|| "any type".to_owned());
                format!("{} ({stated})", name.escape_debug())
            })
            .collect();
        Some(differences)
    }

    /// The schema of a single element of a field.
    fn element(&self, property: &'s Value, field: &Field) -> Option<&'s Value> {
        if field.ty.shape == Shape::Single { Some(property) } else { self.items(property) }
    }

    fn items(&self, property: &'s Value) -> Option<&'s Value> {
        self.followed(property).get("items")
    }

    /// Resolves references within the document.
    fn followed(&self, mut found: &'s Value) -> &'s Value {
        for _ in 0..MAX_REFERENCES {
            let reference = found.get("$ref").and_then(Value::as_str);
            let Some(target) = reference.and_then(|to| self.root.pointer(to.strip_prefix('#')?)) else {
                break;
            };
            found = target;
        }
        found
    }

    /// The types in a property's schema, if none of them is an expected type.
    fn contradicted(&self, property: &'s Value, types: &[&str]) -> Option<String> {
        let found = self.followed(property);
        let is_among = |name: &str| types.contains(&name) || name == "number" && types.contains(&"integer");
        let is_ordered = match found.get("type")? {
            Value::String(name) => is_among(name),
            Value::Array(names) => names.iter().filter_map(Value::as_str).any(is_among),
            _ => return None,
        };
        if is_ordered { None } else { stated(found) }
    }

    /// The JSON types of a field. Bytes may be base64, and text may be an array of byte values.
    fn types_of(&self, message: &schema::Message, field: &Field) -> Vec<&'static str> {
        let is_px4 = self.schema.package_of(message).form == Form::Msg(Dialect::Px4);
        let is_text = is_px4 && field.is_text(Dialect::Px4);
        let is_bytes =
            matches!(field.ty.element, Element::Scalar(Scalar::UInt8 | Scalar::Byte | Scalar::Char));
        match field.ty.shape {
            Shape::Single => vec![element_type(field)],
            _ if is_text => vec!["string", "array"],
            _ if is_bytes => vec!["array", "string"],
            _ => vec!["array"],
        }
    }
}

/// The JSON type of a single value of a field.
fn element_type(field: &Field) -> &'static str {
    match field.ty.element {
        Element::Scalar(Scalar::Bool) => "boolean",
        Element::Scalar(scalar) if scalar.is_float() => "number",
        Element::Scalar(_) => "integer",
        Element::String { .. } => "string",
        Element::Message(_) => "object",
    }
}

/// The types that a schema states.
fn stated(found: &Value) -> Option<String> {
    match found.get("type")? {
        Value::String(name) => Some(name.escape_debug().to_string()),
        Value::Array(names) => {
            let names: Vec<&str> = names.iter().filter_map(Value::as_str).collect();
            Some(names.join(" or ").escape_debug().to_string())
        }
        _ => None,
    }
}
