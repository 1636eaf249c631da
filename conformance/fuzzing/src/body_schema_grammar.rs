//! User-supplied JSON Schemas that follow the grammar. Random bytes would rarely be a valid schema.

use jsonschema::Draft;
use serde_json::{Map, Value, json};
use uavspec_model::json::Tree;
use uavspec_schema::json_type::Direction;

use super::Choices;
use super::schemas::{BODIES, TYPE, body_schema, loaded};

/// The maximum depth of nested schemas.
const DEPTH: usize = 4;

/// The form of a keyword's value.
#[derive(Clone, Copy)]
enum Form {
    Schema,
    /// A list of schemas.
    List,
    /// An object whose values are schemas.
    Map,
    /// One of these JSON texts.
    Data(&'static [&'static str]),
}

const NUMBERS: Form = Form::Data(&["0", "1", "2.5", "-1", "1e300", "true", "\"1\""]);

const COUNTS: Form = Form::Data(&["1", "0", "3", "18446744073709551615", "1.5", "-1"]);

const KEYWORDS: [(&str, Form); 36] = [
    ("$ref", Form::Data(&REFERENCES)),
    ("allOf", Form::List),
    ("anyOf", Form::List),
    ("oneOf", Form::List),
    ("not", Form::Schema),
    ("if", Form::Schema),
    ("then", Form::Schema),
    ("else", Form::Schema),
    ("properties", Form::Map),
    ("patternProperties", Form::Map),
    ("additionalProperties", Form::Schema),
    ("propertyNames", Form::Schema),
    ("dependentSchemas", Form::Map),
    ("dependencies", Form::Map),
    ("unevaluatedProperties", Form::Schema),
    ("items", Form::Schema),
    ("items", Form::List),
    ("prefixItems", Form::List),
    ("additionalItems", Form::Schema),
    ("contains", Form::Schema),
    ("unevaluatedItems", Form::Schema),
    ("required", Form::Data(&["[\"lift\"]", "[]", "[\"at\",\"at\"]", "\"lift\"", "true"])),
    (
        "type",
        Form::Data(&[
            "\"object\"",
            "\"string\"",
            "[\"number\",\"null\"]",
            "[\"array\"]",
            "\"altitude\"",
            "[]",
        ]),
    ),
    ("enum", Form::Data(&["[2.5,\"kite\",null]", "[{\"$ref\":\"#/none\"}]", "[]", "7"])),
    ("const", Form::Data(&["\"kite\"", "2.5", "{\"$ref\":\"#/none\"}", "[[[]]]"])),
    ("minimum", NUMBERS),
    ("maximum", NUMBERS),
    ("exclusiveMinimum", NUMBERS),
    ("multipleOf", NUMBERS),
    ("minItems", COUNTS),
    ("maxProperties", COUNTS),
    ("minContains", COUNTS),
    ("maxLength", COUNTS),
    ("uniqueItems", Form::Data(&["true", "false", "1"])),
    ("pattern", Form::Data(&["\"^[a-z]{1,9}$\"", "\"(?=k)k|v\"", "\"(\"", "\"a{9999}\"", "7"])),
    ("title", Form::Data(&["\"Kite\"", "{\"$ref\":\"#/none\"}"])),
];

const REFERENCES: [&str; 10] = [
    "\"#/$defs/a\"",
    "\"#/$defs/b\"",
    "\"#\"",
    "\"SOAR-INF.json#/$defs/a\"",
    "\"#/properties/lift\"",
    "\"#/%24defs/a/allOf/0\"",
    "\"#/$defs\"",
    "\"#/none\"",
    "\"none.json\"",
    "7",
];

const DRAFTS: [Option<&str>; 6] = [
    None,
    Some("https://json-schema.org/draft/2020-12/schema"),
    Some("https://json-schema.org/draft/2019-09/schema"),
    Some("http://json-schema.org/draft-07/schema#"),
    Some("http://json-schema.org/draft-06/schema#"),
    Some("http://json-schema.org/draft-04/schema#"),
];

/// The names of properties. They are also used as patterns.
const NAMES: [&str; 6] = ["lift", "ids", "at", "^l", "", "$ref"];

/// The content of a schema file. The bytes select it.
fn written(data: &[u8]) -> Value {
    let mut choices = Choices::new(data);
    let draft = choices.of(&DRAFTS);
    let mut root = object(&mut choices, DEPTH);
    let inner = [schema(&mut choices, 2), schema(&mut choices, 2)];
    root.insert("$defs".to_owned(), json!({ "a": inner[0], "b": inner[1] }));
    if let Some(draft) = draft {
        root.insert("$schema".to_owned(), draft.into());
    }
    root.into()
}

fn schema(choices: &mut Choices<'_>, depth: usize) -> Value {
    match choices.below(12) {
        10 => true.into(),
        11 => false.into(),
        _ => object(choices, depth).into(),
    }
}

fn object(choices: &mut Choices<'_>, depth: usize) -> Map<String, Value> {
    let mut keywords = Map::new();
    if depth == 0 {
        return keywords;
    }
    for _ in 0..choices.below(4) {
        let (keyword, form) = choices.of(&KEYWORDS);
        let value = match form {
            Form::Schema => schema(choices, depth - 1),
            Form::List => {
                let count = choices.below(3) + 1;
                (0..count).map(|_| schema(choices, depth - 1)).collect()
            }
            Form::Map => {
                let count = choices.below(3) + 1;
                let member = |_| (choices.of(&NAMES).to_owned(), schema(choices, depth - 1));
                Value::Object((0..count).map(member).collect())
            }
            Form::Data(texts) => {
                serde_json::from_str(choices.of(texts)).unwrap_or_else(|error| panic!("{error}"))
            }
        };
        keywords.insert(keyword.to_owned(), value);
    }
    keywords
}

/// Checks bodies with a schema that follows the grammar. The schema must accept the same bodies as the whole file.
pub(super) fn grammar(data: &[u8]) {
    let schema = written(data);
    let text = schema.to_string();
    body_schema(text.as_bytes());
    let Some(schemas) = loaded(text.as_bytes()) else { return };
    let draft = schema["$schema"].as_str().map_or(Draft::default(), Draft::from_schema_uri);
    let options = jsonschema::options().with_draft(draft).with_base_uri("json:///SOAR-INF.json");
    // Parts that the schema doesn't use may be invalid.
    let Ok(whole) = options.build(&schema) else { return };
    for body in BODIES {
        let (Ok(tree), Ok(value)) = (Tree::read(body), serde_json::from_str(body)) else { panic!("{body}") };
        let found = schemas.check(TYPE, Direction::ALL[0], &tree);
        assert_eq!(found.map(|found| found.is_empty()), Some(whole.is_valid(&value)), "{body}: {text}");
    }
}
