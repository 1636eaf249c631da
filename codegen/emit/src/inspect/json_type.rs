//! Types and messages defined on pages.

use serde_json::{Map, Value as Json, json};
use uavspec_schema::json_type::{Definition, JsonPart, Limits, Member, SetValue, SetValues, Typed};
use uavspec_schema::{Package, Schema, unit};

use super::value::range;

/// The types of a package, by name.
pub(super) fn types(schema: &Schema, package: &Package) -> Map<String, Json> {
    let types = package.json_types.iter().map(|id| schema.json_type(*id));
    types
        .map(|found| {
            let mut model = definition(schema, &found.definition);
            model["summary"] = json!(found.docs.summary);
            model["description"] = json!(found.docs.description);
            (found.name.clone(), model)
        })
        .collect()
}

/// The messages of a package, by type.
pub(super) fn messages(schema: &Schema, package: &Package) -> Map<String, Json> {
    let messages = package.json_messages.iter().map(|id| schema.json_message(*id));
    messages
        .map(|found| {
            let mut model: Map<String, Json> = Map::new();
            model.insert("summary".to_owned(), json!(found.docs.summary));
            model.insert("description".to_owned(), json!(found.docs.description));
            model.extend(found.parts.iter().map(|body| (body.direction.to_string(), part(schema, body))));
            (found.name.clone(), Json::Object(model))
        })
        .collect()
}

fn part(schema: &Schema, part: &JsonPart) -> Json {
    json!({
        "summary": part.docs.summary,
        "description": part.docs.description,
        "answers": part.answers,
        "closed": part.body.is_closed,
        "fields": members(schema, &part.body.fields),
    })
}

fn definition(schema: &Schema, definition: &Definition) -> Json {
    match definition {
        Definition::Object(object) => {
            json!({ "kind": "object", "closed": object.is_closed, "fields": members(schema, &object.fields) })
        }
        Definition::Tuple(elements) => json!({ "kind": "tuple", "elements": members(schema, elements) }),
        Definition::Set(set) => {
            let values: Vec<Json> = match &set.values {
                SetValues::Integers(values) => values.iter().map(value).collect(),
                SetValues::Strings(values) => values.iter().map(value).collect(),
            };
            json!({ "kind": "set", "open": set.is_open, "values": values })
        }
        Definition::Named(found) => {
            let mut model = typed(schema, found);
            model["kind"] = json!("named");
            model
        }
    }
}

fn value<T: serde::Serialize>(value: &SetValue<T>) -> Json {
    json!({ "value": value.value, "description": value.description })
}

fn members(schema: &Schema, members: &[Member]) -> Vec<Json> {
    let model = |member: &Member| {
        let mut model = typed(schema, &member.typed);
        model["name"] = json!(member.name);
        model["required"] = json!(member.is_required);
        model["description"] = json!(member.description);
        model
    };
    members.iter().map(model).collect()
}

fn typed(schema: &Schema, typed: &Typed) -> Json {
    let Limits { unit, range: bounds, min, max, is_unique, pattern, format } = &typed.limits;
    json!({
        "type": schema.expression_text(&typed.ty, &str::to_owned),
        "unit": unit.as_deref().filter(|unit| *unit != unit::NONE),
        "range": bounds.as_ref().map(range),
        "length": (min.is_some() || max.is_some()).then(|| json!([min, max])),
        "unique": is_unique,
        "pattern": pattern,
        "format": format,
    })
}
