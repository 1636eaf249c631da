//! The JSON Schema of `uavspec.toml`, for editors.

use clap::ValueEnum;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value, json};
use uavspec_emit::EMITTERS;

use super::config::File;

/// The JSON Schema of `uavspec.toml`: draft 7, which TOML extensions for editors support.
pub fn configuration_schema() -> Value {
    let settings = SchemaSettings::draft07().with(|settings| settings.inline_subschemas = true);
    let settings = settings.with_transform(RecursiveTransform(adapt));
    let schema = settings.into_generator().into_root_schema_for::<File>().to_value();
    let Value::Object(mut described) = schema else { return schema };
    let mut whole = Map::new();
    for (key, value) in [
        ("$schema", described.remove("$schema").unwrap_or_default()),
        ("$id", json!("https://www.schemastore.org/uavspec.json")),
        ("title", json!("configuration of uavspec")),
        ("description", described.remove("description").unwrap_or_default()),
    ] {
        whole.insert(key.to_owned(), value);
    }
    described.remove("title");
    whole.extend(described);
    Value::Object(whole)
}

/// The schema of the table `output`.
pub(super) fn outputs(generator: &mut SchemaGenerator) -> Schema {
    let outputs =
        EMITTERS.iter().map(|emitter| (emitter.name.to_owned(), emitter.schema(generator).to_value()));
    let outputs: Map<String, Value> = outputs.collect();
    json_schema!({ "type": "object", "properties": outputs, "additionalProperties": false })
}

/// The schema of an enum of the command line.
pub(super) fn values_of<T: ValueEnum>(_: &mut SchemaGenerator) -> Schema {
    let values = T::value_variants().iter().filter_map(ValueEnum::to_possible_value);
    let values: Vec<String> = values.map(|value| value.get_name().to_owned()).collect();
    json_schema!({ "type": "string", "enum": values })
}

/// Removes null, which TOML lacks, and the line breaks of comments.
fn adapt(schema: &mut Schema) {
    if let Some([only, Value::String(null)]) = schema.get("type").and_then(Value::as_array).map(Vec::as_slice)
        && null == "null"
    {
        let only = only.clone();
        schema.insert("type".to_owned(), only);
    }
    if schema.get("default").is_some_and(Value::is_null) {
        schema.remove("default");
    }
    if let Some(Value::String(text)) = schema.get_mut("description") {
        *text = text.replace('\n', " ");
    }
}
