//! Describes a schema in words: its fields with their types, units and constraints, and its values.

use serde_json::{Map, Value};

use super::markdown::{code, text};

/// A section of a page: the schema itself, or a schema under `$defs`.
pub(super) struct Part<'s> {
    pub(super) title: String,
    pub(super) description: &'s str,
    pub(super) columns: [&'static str; 6],
    pub(super) rows: Vec<[String; 6]>,
}

/// Keywords that combine several schemas.
const ALTERNATIVES: [&str; 3] = ["oneOf", "anyOf", "allOf"];

/// The maximum limit that is shown. Larger limits are the limits of a floating-point type.
const MAX_LIMIT: f64 = 1e30;

/// Splits a schema into parts.
pub(super) fn parts(schema: &Value) -> Vec<Part<'_>> {
    let definitions = schema["$defs"].as_object().into_iter().flatten();
    let definitions = definitions.filter(|(name, _)| *name != "annotations").map(|(name, definition)| Part {
        title: name.clone(),
        description: definition["description"].as_str().unwrap_or_default(),
        ..part(definition)
    });
    [part(schema)].into_iter().chain(definitions).collect()
}

fn part(schema: &Value) -> Part<'static> {
    members(schema)
        .or_else(|| values(schema))
        .unwrap_or_else(|| fields("Value", vec![row("", &without_description(schema), "")]))
}

/// A copy without the description, which is shown above the table.
fn without_description(schema: &Value) -> Value {
    let mut schema = schema.clone();
    if let Some(keywords) = schema.as_object_mut() {
        keywords.remove("description");
    }
    schema
}

fn fields(title: &str, rows: Vec<[String; 6]>) -> Part<'static> {
    let columns = ["Field", "Type", "Required", "Unit", "Constraints", "Description"];
    Part { title: title.to_owned(), description: "", columns, rows }
}

/// The table of the fields or elements, including the fields of nested schemas without a name.
fn members(schema: &Value) -> Option<Part<'static>> {
    let mut rows = Vec::new();
    add_members("", schema, &mut rows);
    let title = if schema["properties"].is_object() { "Fields" } else { "Elements" };
    (!rows.is_empty()).then(|| fields(title, rows))
}

fn add_members(prefix: &str, schema: &Value, rows: &mut Vec<[String; 6]>) {
    let required = schema["required"].as_array().map_or(&[][..], Vec::as_slice);
    for (name, field) in schema["properties"].as_object().into_iter().flatten() {
        let is_required = required.iter().any(|required| required == name.as_str());
        add_member(&format!("{prefix}{name}"), field, is_required, rows);
    }
    if let Some(elements) = elements(schema) {
        let required = schema["minItems"].as_u64().or_else(|| shortest(schema)).unwrap_or(0);
        for (at, element) in (0..).zip(elements) {
            let name = element["title"].as_str().map_or_else(|| at.to_string(), str::to_owned);
            add_member(&format!("{prefix}{name}"), element, at < required, rows);
        }
        return;
    }
    for alternative in ALTERNATIVES.iter().filter_map(|keyword| schema[*keyword].as_array()).flatten() {
        add_members(prefix, alternative, rows);
    }
}

/// Adds a field, and the fields of its items and values if their schema has no name.
fn add_member(name: &str, field: &Value, is_required: bool, rows: &mut Vec<[String; 6]>) {
    rows.push(row(name, field, if is_required { "yes" } else { "no" }));
    add_members(&format!("{name}."), field, rows);
    add_members(&format!("{name}[]."), &field["items"], rows);
    add_members(&format!("{name}.*."), &field["additionalProperties"], rows);
}

/// The elements of a tuple. If elements are optional, there is one alternative for each length, and the longest
/// contains all elements.
fn elements(schema: &Value) -> Option<&Vec<Value>> {
    let tuples =
        schema["oneOf"].as_array().into_iter().flatten().filter_map(|one| one["prefixItems"].as_array());
    schema["prefixItems"].as_array().into_iter().chain(tuples).max_by_key(|elements| elements.len())
}

/// The length of the shortest alternative of a tuple.
fn shortest(schema: &Value) -> Option<u64> {
    schema["oneOf"].as_array()?.iter().filter_map(|one| one["minItems"].as_u64()).min()
}

fn row(name: &str, schema: &Value, required: &str) -> [String; 6] {
    let annotations = &schema["$defs"]["annotations"];
    let name = if name.is_empty() { String::new() } else { code(name) };
    let unit = annotations["x-unit"].as_str().map(text).unwrap_or_default();
    let description = schema["description"].as_str().map(text).unwrap_or_default();
    [name, type_of(schema), required.to_owned(), unit, constraints(schema).join("; "), description]
}

/// The table of listed values.
fn values(schema: &Value) -> Option<Part<'static>> {
    let listed = listed(schema);
    let row = |value: &&Value| {
        let annotations = &value["$defs"]["annotations"];
        let word =
            |key: &str| annotations[key].as_str().or(value[key].as_str()).map(text).unwrap_or_default();
        let value_of = code(&value["const"].to_string());
        [
            value_of,
            word("title"),
            word("x-severity"),
            word("x-abbreviation"),
            String::new(),
            word("description"),
        ]
    };
    let rows: Vec<[String; 6]> = listed.iter().map(row).collect();
    let columns = ["Value", "Name", "Severity", "Abbreviation", "", "Description"];
    (!rows.is_empty()).then(|| Part { title: "Values".to_owned(), description: "", columns, rows })
}

/// The schemas that each allow one value.
fn listed(schema: &Value) -> Vec<&Value> {
    let alternatives = ALTERNATIVES.iter().filter_map(|keyword| schema[*keyword].as_array()).flatten();
    alternatives.filter(|one| one.get("const").is_some()).collect()
}

/// The JSON type in words, with links to other schemas.
fn type_of(schema: &Value) -> String {
    if let Some(reference) = schema["$ref"].as_str() {
        return link(reference);
    }
    if let Some(alternatives) = ALTERNATIVES.iter().find_map(|keyword| schema[*keyword].as_array()) {
        let mut types: Vec<String> = alternatives.iter().map(type_of).filter(|ty| !ty.is_empty()).collect();
        types.dedup();
        if !types.is_empty() {
            return types.join(" or ");
        }
    }
    let types = match &schema["type"] {
        Value::String(one) => vec![one.as_str()],
        Value::Array(several) => several.iter().filter_map(Value::as_str).collect(),
        _ => Vec::new(),
    };
    let name = |ty: &&str| match *ty {
        "array" if schema["items"].is_object() => format!("array of {}", or_any(type_of(&schema["items"]))),
        "object" if schema["additionalProperties"].is_object() && schema["properties"].is_null() => {
            format!("map of {}", or_any(type_of(&schema["additionalProperties"])))
        }
        ty => ty.to_owned(),
    };
    types.iter().map(name).collect::<Vec<_>>().join(" or ")
}

fn or_any(ty: String) -> String {
    if ty.is_empty() { "any value".to_owned() } else { ty }
}

/// A link to the page of another schema, or to a section of this page.
fn link(reference: &str) -> String {
    let (file, definition) = reference.split_once("#/$defs/").unwrap_or((reference, ""));
    let name = if definition.is_empty() { file.trim_end_matches(super::ENDING) } else { definition };
    let page = file.replace(super::ENDING, ".schema.md");
    let anchor =
        if definition.is_empty() { String::new() } else { format!("#{}", definition.to_lowercase()) };
    if file.is_empty() && definition.is_empty() {
        "this schema".to_owned()
    } else {
        format!("[{}]({page}{anchor})", text(name))
    }
}

/// The constraints in words.
fn constraints(schema: &Value) -> Vec<String> {
    let Some(keywords) = schema.as_object() else { return Vec::new() };
    let mut constraints = Vec::new();
    constraints.extend(keywords.get("const").map(|value| code(&value.to_string())));
    constraints.extend(range(keywords, "minimum", "maximum", ""));
    constraints.extend(range(keywords, "minItems", "maxItems", " items"));
    constraints.extend(range(keywords, "minLength", "maxLength", " characters"));
    constraints.extend(keywords.get("uniqueItems").map(|_| "unique items".to_owned()));
    for keyword in ["pattern", "format", "contentEncoding"] {
        let word = if keyword == "contentEncoding" { "encoding" } else { keyword };
        constraints.extend(
            keywords.get(keyword).and_then(Value::as_str).map(|value| format!("{word} {}", code(value))),
        );
    }
    let annotations = &schema["$defs"]["annotations"];
    if let Some(invalid) = annotations.get("x-invalid") {
        constraints.push(format!("{} means missing", code(&invalid.to_string())));
    }
    let listed: Vec<String> = listed(schema).into_iter().map(value).collect();
    if !listed.is_empty() {
        constraints.push(listed.join(", "));
    }
    constraints.extend(constraints_of_items(schema));
    constraints
}

fn constraints_of_items(schema: &Value) -> Option<String> {
    let items = constraints(&schema["items"]);
    (!items.is_empty()).then(|| format!("each item: {}", items.join(", ")))
}

/// A listed value with its name.
fn value(schema: &Value) -> String {
    let name = schema["title"].as_str().map(|title| format!(" {}", text(title))).unwrap_or_default();
    code(&schema["const"].to_string()) + &name
}

/// The words for a lower and an upper limit. Limits of floating-point types are omitted.
fn range(keywords: &Map<String, Value>, low: &str, high: &str, unit: &str) -> Option<String> {
    let limit = |keyword| {
        keywords.get(keyword).filter(|value| value.as_f64().is_some_and(|value| value.abs() < MAX_LIMIT))
    };
    match (limit(low), limit(high)) {
        (Some(low), Some(high)) if low == high => Some(format!("{low}{unit}")),
        (Some(low), Some(high)) => Some(format!("{low} to {high}{unit}")),
        (Some(low), None) => Some(format!("at least {low}{unit}")),
        (None, Some(high)) => Some(format!("at most {high}{unit}")),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// The cells of each row, without empty cells.
    fn rows(schema: &Value) -> Vec<Vec<Vec<String>>> {
        let cells = |row: [String; 6]| row.into_iter().filter(|cell| !cell.is_empty()).collect();
        parts(schema).into_iter().map(|part| part.rows.into_iter().map(cells).collect()).collect()
    }

    #[test]
    fn lists_fields_of_nested_schemas_and_definitions() {
        let schema = json!({
            "properties": {
                "speed": {
                    "type": ["number", "null"], "minimum": 0, "maximum": 3.4e38, "description": "Wind speed",
                    "$defs": { "annotations": { "x-unit": "m/s", "x-invalid": -1 } }
                },
                "gusts": { "type": "array", "maxItems": 2, "items": { "properties": { "at": { "$ref": "Time.schema.json" } } } },
                "state": { "$ref": "#/$defs/State" }
            },
            "required": ["speed"],
            "$defs": { "State": { "anyOf": [{ "const": "calm", "description": "No wind" }] }, "annotations": {} }
        });
        assert_eq!(
            rows(&schema),
            [
                vec![
                    vec![
                        "`speed`",
                        "number or null",
                        "yes",
                        "m/s",
                        "at least 0; `-1` means missing",
                        "Wind speed"
                    ],
                    vec!["`gusts`", "array of any value", "no", "at most 2 items"],
                    vec!["`gusts[].at`", "[Time](Time.schema.md)", "no"],
                    vec!["`state`", "[State](#state)", "no"],
                ],
                vec![vec!["`\"calm\"`", "No wind"]],
            ]
        );
    }

    #[test]
    fn lists_the_elements_of_a_tuple_once() {
        let (volt, percent) =
            (json!({ "title": "voltage" }), json!({ "title": "percentage", "type": "integer" }));
        let schema = json!({ "oneOf": [
            { "prefixItems": [volt], "minItems": 1 },
            { "prefixItems": [volt, percent], "minItems": 2 }
        ] });
        assert_eq!(rows(&schema), [[vec!["`voltage`", "yes"], vec!["`percentage`", "integer", "no"]]]);
    }

    #[test]
    fn describes_a_schema_without_fields() {
        let schema = json!({ "type": "string", "minLength": 1, "maxLength": 36, "pattern": "^a|b$", "description": "Id" });
        assert_eq!(rows(&schema), [[["string", "1 to 36 characters; pattern `^a\\|b$`"]]]);
    }
}
