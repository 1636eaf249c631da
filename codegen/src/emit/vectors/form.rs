//! The schema of the form in which vectors are, for those who read them.

use serde_json::json;

use super::options::Options;
use crate::emit::file::{GENERATED_BY, OutputFile};
use crate::emit::json_schema::DRAFT;

/// The version of the form of the files. It rises if an existing reader would misread them.
pub(super) const FORM: u32 = 1;

/// The file of the schema.
const PATH: &str = "vectors.schema.json";

/// The schema of all `.vectors.json` files.
pub(super) fn file(options: &Options) -> OutputFile {
    let hex = |what: &str| json!({"description": what, "type": "string", "pattern": "^([0-9a-f]{2})+$"});
    let text = |what: &str| json!({"description": what, "type": "string"});
    let case = json!({
        "type": "object",
        "properties": {
            "id": text("Names the case within its file, and says what is tried. It stays when fields are added."),
            "description": text("What is tried, in words."),
            "valid": {"description": "Whether no rule is broken.", "type": "boolean"},
            "rule": text("The id of the rule that is broken."),
            "class": text("The class of an error code."),
            "severity": text("The severity of an error code."),
            "json": {"description": "The value as JSON. It encodes to the bytes of the case, if any, and they decode to it."},
            "decoded": {"description": "What the bytes decode to, where no writer writes such bytes."},
            "uorb": hex("The payload of uORB, in hexadecimal."),
            "cdr": hex("The payload in CDR with its header, little-endian if the header says no other."),
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
        "description": "Test vectors of a type: values that it has and values that it doesn't have.",
        "type": "object",
        "properties": {
            "$comment": {"type": "string"},
            "form": {"description": "The version of this form.", "const": FORM},
            "type": text("The type, after its package."),
            "version": {"description": "The message's version, as PX4 counts it.", "type": "integer", "minimum": 0},
            "hash": {"description": "PX4's hash of the fields.", "type": "integer", "minimum": 0},
            "type_hash": text("ROS's hash of the type."),
            "schema": {"description": "The address of the type's JSON Schema.", "type": "string", "format": "uri"},
            "cases": {"type": "array", "items": case},
        },
        "required": ["form", "type", "schema", "cases"],
        "additionalProperties": false,
    });
    OutputFile { path: PATH.to_owned(), text: format!("{schema:#}\n") }
}
