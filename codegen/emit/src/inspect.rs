//! The schema as JSON, in the form that the `inspect` command prints.
//!
//! ```
//! # use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! let model = uavspec_emit::inspect::schema(&schema);
//! let message = model.pointer("/packages/px4/messages/Wind").unwrap();
//! assert_eq!(message["fields"][1]["unit"], "m/s");
//! ```

mod event;
mod json_type;
mod value;

use serde_json::{Map, Value as Json, json};
use uavspec_schema::msg::attribute::FRAME;
use uavspec_schema::msg::constraint::{INVALID, RANGE};
use uavspec_schema::{
    Constant, Constraint, Element, Field, Interface, Message, MessageId, Package, Schema, Type, unit,
};

use self::value::stated;
pub(crate) use self::value::value;

/// Converts the schema to one JSON value.
pub fn schema(schema: &Schema) -> Json {
    let packages: Map<String, Json> =
        schema.packages.iter().map(|found| (found.name.clone(), package(schema, found))).collect();
    json!({ "packages": packages })
}

fn package(schema: &Schema, package: &Package) -> Json {
    let messages = |ids: &[MessageId]| -> Map<String, Json> {
        ids.iter()
            .map(|id| (schema.message(*id).name.clone(), message(schema, schema.message(*id))))
            .collect()
    };
    let interfaces = |name: &str| -> Map<String, Json> {
        let interfaces = package.interfaces.iter().filter(|interface| interface.kind.name() == name);
        interfaces
            .map(|Interface { name, type_hash, parts, .. }| {
                (name.clone(), json!({ "rihs01": type_hash, "messages": messages(parts) }))
            })
            .collect()
    };
    let error_codes: Map<String, Json> = package
        .error_tables
        .iter()
        .flat_map(|table| &table.codes)
        .map(|code| {
            let entry = json!({
                "abbreviation": code.abbreviation,
                "severity": uavspec_runtime::Severity::of(code.code) as u8,
                "class": code.class.name(),
                "see_also": code.see_also,
                "alternatives": code.alternatives,
                "since": code.since,
                "description": code.description,
            });
            (code.code.to_string(), entry)
        })
        .collect();
    json!({
        "messages": messages(&package.messages),
        "services": interfaces("srv"),
        "actions": interfaces("action"),
        "error_codes": error_codes,
        "types": json_type::types(schema, package),
        "json_messages": json_type::messages(schema, package),
        "components": package.components.iter().map(|found| event::component(package, found)).collect::<Map<_, _>>(),
    })
}

fn message(schema: &Schema, message: &Message) -> Json {
    let uorb = message.uorb.as_ref().map(|layout| {
        let fields: Vec<Json> = layout
            .slots
            .iter()
            .map(|slot| json!({ "name": slot.name, "type": slot.type_text, "offset": slot.offset }))
            .collect();
        json!({ "size": layout.size, "size_no_padding": layout.size_no_padding, "fields": fields })
    });
    json!({
        "summary": message.docs.summary,
        "description": message.docs.description,
        "topics": message.topics,
        "version": message.version,
        "queue_length": message.queue_length,
        "hash": message.hash,
        "rihs01": message.type_hash,
        "uorb": uorb,
        "cdr": { "least": message.cdr.min, "fixed": message.cdr.is_fixed },
        "fields": message.fields.iter().map(|found| field(schema, message, found)).collect::<Vec<_>>(),
        "constants": message.constants.iter().map(|found| constant(schema, message, found)).collect::<Vec<_>>(),
    })
}

fn field(schema: &Schema, message: &Message, field: &Field) -> Json {
    let mut model = json!({
        "name": field.name,
        "type": schema.type_text(message, field.ty),
        "default": field.default.as_ref().map(value),
        "unit": field.unit.as_deref().filter(|unit| *unit != unit::NONE),
    });
    constraints(&mut model, &field.constraints);
    // A missing frame is null; other missing attributes are omitted.
    model["frame"] = json!(field.attribute(&FRAME));
    for (attribute, text) in field.attributes() {
        model[attribute.name] = json!(text);
    }
    model["enum"] = json!((!field.enum_prefixes.is_empty()).then(|| field.enum_prefixes.join(" ")));
    model["count_of"] = json!(field.counts.map(|array| &message.fields[array].name));
    model["group"] = json!(field.group.map(|group| &message.groups[group].summary));
    model["description"] = json!(field.description);
    model
}

fn constant(schema: &Schema, message: &Message, constant: &Constant) -> Json {
    let ty = Type { element: constant.ty, shape: uavspec_schema::Shape::Single };
    let parameters: Vec<Json> = constant
        .parameters
        .iter()
        .map(|parameter| {
            let mut model = json!({ "unit": parameter.unit.as_deref().filter(|unit| *unit != unit::NONE) });
            constraints(&mut model, &parameter.constraints);
            model["enum"] =
                json!((!parameter.enum_prefixes.is_empty()).then(|| parameter.enum_prefixes.join(" ")));
            model["description"] = json!(parameter.description);
            model
        })
        .collect();
    debug_assert!(!matches!(constant.ty, Element::Message(_)));
    json!({
        "name": constant.name,
        "type": schema.type_text(message, ty),
        "value": value(&constant.value),
        "parameters": (!parameters.is_empty()).then_some(parameters),
        "description": constant.description,
    })
}

/// Adds constraints by name. A missing `range` or `invalid` constraint is null; other missing constraints are omitted.
fn constraints(model: &mut Json, constraints: &[Constraint]) {
    for kind in [&RANGE, &INVALID] {
        model[kind.name] = Json::Null;
    }
    for constraint in constraints {
        model[constraint.kind.name] = stated(&constraint.stated);
    }
}
