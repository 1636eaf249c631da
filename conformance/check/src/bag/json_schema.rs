//! Compares the JSON Schema in a file with the definition.
//!
//! Only explicit statements are compared: the names of properties, their types, the bounds of integers, the lengths of
//! arrays, and whether properties are required. `number` matches an integer, since many writers have no integer type. A
//! missing type matches anything, and so does `anyOf`.

use serde_json::Value;
use uavspec_px4::comparison::Differences;
use uavspec_px4::json::{SharedFields, is_byte};
use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Field, MessageId, Schema, Shape};

use crate::limits::{MAX_REFERENCES, MAX_SCHEMA_DEPTH};

/// Compares the text of a schema with a definition. Returns the differences, and the fields without differences. `None`
/// if the schema has no properties. The error is a one-line message.
pub(super) fn compare(
    text: &[u8],
    defined: MessageId,
    schema: &Schema,
) -> Result<Option<(Differences, SharedFields)>, String> {
    let root: Value = serde_json::from_slice(text).map_err(|error| error.to_string())?;
    Ok(Comparing { root: &root, schema }.message(&root, defined, 0))
}

struct Comparing<'s> {
    root: &'s Value,
    schema: &'s Schema,
}

impl<'s> Comparing<'s> {
    /// The differences between an object and a message, and the fields without differences. `None` if the object has no
    /// properties.
    fn message(
        &self,
        found: &'s Value,
        defined: MessageId,
        depth: usize,
    ) -> Option<(Differences, SharedFields)> {
        let found = self.followed(found);
        let properties = found.get("properties")?.as_object().filter(|properties| !properties.is_empty())?;
        let required = found.get("required").and_then(Value::as_array);
        let message = self.schema.message(defined);
        let (mut differences, mut shared) = (Differences::default(), SharedFields::new());
        for field in &message.fields {
            let types = types_of(field);
            let Some(property) = properties.get(&field.name) else {
                differences.missing.push(format!("{} ({})", field.name, types.join(" or ")));
                continue;
            };
            let is_listed = |required: &Vec<Value>| required.iter().any(|name| *name == field.name.as_str());
            // Without a list, the schema doesn't specify which fields may be absent.
            let is_required = required.is_none_or(is_listed);
            if !is_required {
                differences.optional.push(field.name.clone());
            }
            if let Some((stated, defined)) = self.contradiction(property, field, &types) {
                differences.retyped.push(format!("{} ({stated}, defined as {defined})", field.name));
            } else if let Element::Message(nested) = field.ty.element
                && depth < MAX_SCHEMA_DEPTH
                && self
                    .element(property, field)
                    .and_then(|element| self.message(element, nested, depth + 1))
                    .is_some_and(|(nested, _)| nested != Differences::default())
            {
                differences.nested.push(field.name.clone());
            } else {
                shared.insert(field.name.clone(), is_required);
            }
        }
        // If an array differs, its length isn't known, so a count of its entries may exceed the defined length.
        for field in &message.fields {
            let array = field.counts.and_then(|array| message.fields.get(array));
            if array.is_some_and(|array| !shared.contains_key(&array.name)) {
                shared.remove(&field.name);
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
        Some((differences, shared))
    }

    /// The type in the schema of a property, and the type of its field, if the two contradict each other. `types`
    /// contains the JSON types of the field.
    fn contradiction(&self, property: &'s Value, field: &Field, types: &[&str]) -> Option<(String, String)> {
        if let Some(stated) = self.contradicted(property, types) {
            return Some((stated, types.join(" or ")));
        }
        if let Some(lengths) = self.other_length(property, field) {
            return Some(lengths);
        }
        let scalar = field.ty.element.scalar()?;
        if let Some(items) = self.items(property) {
            let ty = element_type(field);
            let stated = self.contradicted(items, &[ty]).map(|stated| (stated, ty.to_owned()));
            let (stated, defined) = stated.or_else(|| self.other_bounds(items, scalar))?;
            return Some((format!("array of {stated}"), format!("array of {defined}")));
        }
        self.other_bounds(property, scalar)
    }

    /// The number of elements that the schema states, and the number that the field defines, if the schema allows
    /// arrays that the field doesn't allow.
    fn other_length(&self, property: &'s Value, field: &Field) -> Option<(String, String)> {
        let found = self.followed(property);
        let stated = |key: &str| found.get(key).and_then(Value::as_u64);
        // Each array has at least 0 elements.
        let (min, max) = (stated("minItems").filter(|min| *min > 0), stated("maxItems"));
        let (differs, defined) = match field.ty.written().shape {
            Shape::Array(length) => {
                let is_other = |stated: u64| stated != u64::from(length);
                (min.is_some_and(is_other) || max.is_some_and(is_other), format!("array of {length}"))
            }
            Shape::Bounded(bound) => {
                (max.is_some_and(|max| max > u64::from(bound)), format!("array of at most {bound}"))
            }
            Shape::Single | Shape::Sequence => return None,
        };
        let text = match (min, max) {
            (Some(min), Some(max)) if min == max => format!("array of {max}"),
            (Some(min), Some(max)) => format!("array of {min} to {max}"),
            (Some(min), None) => format!("array of at least {min}"),
            (None, Some(max)) => format!("array of at most {max}"),
            (None, None) => return None,
        };
        differs.then_some((text, defined))
    }

    /// The bounds of an integer that the schema states, and the bounds of its type, if the schema allows integers that
    /// the type doesn't allow.
    fn other_bounds(&self, property: &'s Value, scalar: Scalar) -> Option<(String, String)> {
        let found = self.followed(property);
        let stated = |key: &str| {
            let number = found.get(key)?;
            number.as_i64().map(i128::from).or_else(|| number.as_u64().map(i128::from))
        };
        let (low, high) = scalar.integer_bounds()?;
        let (min, max) = (stated("minimum"), stated("maximum"));
        let differs = min.is_some_and(|min| min < low) || max.is_some_and(|max| max > high);
        let text = |min: i128, max: i128| format!("integer from {min} to {max}");
        differs.then(|| (text(min.unwrap_or(low), max.unwrap_or(high)), text(low, high)))
    }

    /// The schema of a single element of a field.
    fn element(&self, property: &'s Value, field: &Field) -> Option<&'s Value> {
        if field.ty.written().shape == Shape::Single { Some(property) } else { self.items(property) }
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

    /// The types in a property's schema, if none of them is among the expected types.
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
}

/// The JSON types of a field. Bytes may be base64, and text may be an array of byte values.
fn types_of(field: &Field) -> Vec<&'static str> {
    match (field.ty.element, field.ty.shape) {
        (Element::Text(_), _) => vec!["string", "array"],
        (_, Shape::Single) => vec![element_type(field)],
        (element, _) if is_byte(element) => vec!["array", "string"],
        _ => vec!["array"],
    }
}

/// The JSON type of a single value of a field.
fn element_type(field: &Field) -> &'static str {
    match field.ty.element {
        Element::Scalar(Scalar::Bool) => "boolean",
        Element::Scalar(scalar) if scalar.is_float() => "number",
        // The elements of a text that is written as an array.
        Element::Scalar(_) | Element::Text(_) => "integer",
        Element::String { .. } => "string",
        Element::Message(_) => "object",
    }
}

/// The types that a schema allows.
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
