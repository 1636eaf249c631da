//! The target for user-supplied JSON Schemas.

use std::fs;

use uavspec_flockwave::body_schema::Schemas;
use uavspec_model::json::Tree;
use uavspec_schema::json_type::Direction;
use uavspec_schema::terminal::shown;

use super::DEFINITIONS;

/// The message type of the schema, which is also the name of its file.
pub(super) const TYPE: &str = "SOAR-INF";

/// Bodies to check.
pub(super) const BODIES: [&str; 4] = [
    "{\"type\":\"SOAR-INF\"}",
    "{\"type\":\"SOAR-INF\",\"lift\":2.5,\"ids\":[\"kite\",\"vane\"],\"at\":{\"lat\":1,\"lon\":null}}",
    "{\"type\":\"SOAR-INF\",\"ids\":[1,true,{}],\"lift\":-1e300,\"\":[[[]]]}",
    "[\"\\u0000\u{202e}\"]",
];

/// Loads a schema, and checks bodies with it. A schema that can't be used must result in an error message.
pub(super) fn body_schema(data: &[u8]) {
    let Some(schemas) = loaded(data) else { return };
    for body in BODIES {
        let body = Tree::read(body).unwrap_or_else(|error| panic!("{error:?}"));
        for direction in Direction::ALL {
            for deviation in schemas.check(TYPE, direction, &body).unwrap_or_default() {
                assert!(deviation.mismatch.path.starts_with("/body"), "{deviation:?}");
            }
        }
    }
}

/// Loads a folder that contains a schema file with these bytes. Returns `None` if the schema can't be used. The error
/// message must be safe to print.
pub(super) fn loaded(data: &[u8]) -> Option<Schemas> {
    let folder = tempfile::tempdir().unwrap_or_else(|error| panic!("{error}"));
    let path = folder.path().join(format!("{TYPE}.json"));
    fs::write(&path, data).unwrap_or_else(|error| panic!("{error}"));
    match Schemas::load(&[folder.path().to_owned()], DEFINITIONS.defined_schemas()) {
        Ok(schemas) => Some(schemas),
        Err(error) => {
            let text = error.to_string();
            assert!(!text.lines().any(|line| shown(line).contains(char::is_control)), "{text:?}");
            None
        }
    }
}

pub(super) fn body_schema_seeds() -> Vec<Vec<u8>> {
    [
        r##"{"$schema":"https://json-schema.org/draft/2020-12/schema","properties":{"type":{"const":"SOAR-INF"},"lift":{"type":"number","minimum":0},"ids":{"type":"array","items":{"$ref":"#/$defs/id"},"uniqueItems":true}},"required":["lift"],"$defs":{"id":{"type":"string","pattern":"^[a-z]{1,9}$","$anchor":"id"}}}"##,
        r##"{"$schema":"http://json-schema.org/draft-07/schema#","$id":"https://example.org/soar.json","definitions":{"at":{"type":"object","additionalProperties":false,"patternProperties":{"^l":{"type":["number","null"]}}}},"properties":{"at":{"$ref":"#/definitions/at"}},"dependencies":{"at":["lift"]}}"##,
        r##"{"allOf":[{"$ref":"#/$defs/a"},{"not":{"$ref":"#b"}}],"$defs":{"a":{"oneOf":[true,false,{"$ref":"#/$defs/a"}]},"b":{"$anchor":"b","enum":[1,"a",null]}},"unevaluatedProperties":false}"##,
        r#"{"if":{"required":["lift"]},"then":{"$ref":"SOAR-INF.json#/$defs/x"},"else":{"maxProperties":2},"$defs":{"x":{"format":"date-time","multipleOf":0.5,"contains":{},"minContains":2}}}"#,
        r##"{"$dynamicRef":"#m","$defs":{"m":{"$dynamicAnchor":"m","propertyNames":{"maxLength":4},"prefixItems":[{}]},"n":{"$id":"other.json","$ref":"#"}}}"##,
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec()
}
