//! The JSON Schema of vector files.

use serde_json::json;

use super::options::Options;
use crate::file::{GENERATED_BY, OutputFile};
use crate::json_schema::DRAFT;

/// Version of the file format. The version is incremented if existing readers would misinterpret the files.
pub(super) const FORM: u32 = 1;

/// Path of the schema file.
const PATH: &str = "vectors.schema.json";

/// Creates the schema of all `.vectors.json` files.
pub(super) fn file(options: &Options) -> OutputFile {
    let hex = |what: &str| json!({"description": what, "type": "string", "pattern": "^([0-9a-f]{2})*$"});
    let text = |what: &str| json!({"description": what, "type": "string"});
    let case = json!({
        "type": "object",
        "properties": {
            "id": text("Unique id of the case within its file. The id describes the input, and stays the \
                same when fields are added."),
            "description": text("Description of the input."),
            "valid": {"description": "True if no rule is violated.", "type": "boolean"},
            "rule": text("Id of the violated rule."),
            "class": text("Class of an error code."),
            "severity": text("Severity of an error code."),
            "json": {"description": "The value as JSON. If the case has bytes, encoding the value produces them, and decoding them produces the value."},
            "decoded": {"description": "The decoded value as JSON. Present only if re-encoding \
                it produces different bytes."},
            "uorb": hex("The uORB payload in hexadecimal."),
            "cdr": hex("The CDR payload with its header in hexadecimal. The payload is little-endian unless \
                the header declares otherwise."),
            "arguments": hex("The arguments of an event in hexadecimal."),
            "texts": {
                "description": "The texts of an event in English, by the profile of the reader.",
                "type": "object",
                "additionalProperties": {
                    "type": "object",
                    "properties": {"message": {"type": "string"}, "description": {"type": "string"}},
                    "required": ["message", "description"],
                    "additionalProperties": false,
                },
            },
        },
        "required": ["id", "description", "valid"],
        "additionalProperties": false,
        "anyOf": [{"required": ["json"]}, {"required": ["uorb"]}, {"required": ["cdr"]}],
        "if": {"properties": {"valid": {"const": true}}},
        "then": {"not": {"required": ["rule"]}},
        "else": {"required": ["rule"]},
    });
    let schema = json!({
        "$schema": DRAFT,
        "$id": format!("{}/{PATH}", options.schemas().base.trim_end_matches('/')),
        "$comment": format!("{GENERATED_BY}. Do not edit."),
        "title": "Vectors",
        "description": "Test vectors of a type: valid and invalid values.",
        "type": "object",
        "properties": {
            "$comment": {"type": "string"},
            "form": {"description": "Version of this format.", "const": FORM},
            "type": text("Package and name of the type."),
            "version": {"description": "Version of the message in PX4.", "type": "integer", "minimum": 0},
            "hash": {"description": "PX4 hash of the fields.", "type": "integer", "minimum": 0},
            "type_hash": text("ROS 2 type hash."),
            "schema": {"description": "URL of the JSON Schema of the type.", "type": "string", "format": "uri"},
            "cases": {"type": "array", "items": case},
        },
        "required": ["form", "type", "schema", "cases"],
        "additionalProperties": false,
    });
    OutputFile { path: PATH.to_owned(), text: format!("{schema:#}\n") }
}
