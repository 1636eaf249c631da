use std::fs;

use serde_json::{Map, json};

use super::bundle::{Bundle, Size};
use super::*;
use crate::body_schema::DefinedSchemas;

/// The size of a schema in a file.
fn size_of(schema: &Value) -> Result<Size, Problem> {
    let file = SchemaFile {
        path: PathBuf::from("SOAR-INF.json"),
        address: "SOAR-INF.json".to_owned(),
        draft: Draft::default(),
        value: schema.clone(),
    };
    let files = [file];
    let places = Places::new(&files).expect("an address");
    Bundle::new(&places, 0, &mut 0).map(|bundle| bundle.size())
}

fn count_of(schema: &Value) -> u64 {
    size_of(schema).expect("known references").count
}

/// A schema in which each level refers twice to the next one.
fn doubling(levels: usize) -> Value {
    let level = |at: usize| {
        let reference = json!({ "$ref": format!("#/$defs/level{}", at + 1) });
        let schema = if at == levels {
            json!({ "type": "string" })
        } else {
            json!({ "allOf": [reference, reference] })
        };
        (format!("level{at}"), schema)
    };
    let levels: Map<String, Value> = (0..=levels).map(level).collect();
    json!({ "$ref": "#/$defs/level0", "$defs": levels })
}

#[test]
fn references_count_like_copies() {
    assert_eq!(
        count_of(&json!({ "properties": { "a": {}, "b": { "const": {} } }, "$defs": { "c": {} } })),
        3
    );
    assert!(count_of(&doubling(3)) > 2 * count_of(&doubling(2)) - 20);
    assert!(size_of(&doubling(10)).expect("known").is_small());
    for levels in [40, 2_000] {
        assert!(!size_of(&doubling(levels)).expect("known").is_small(), "{levels}");
    }
    let anchored = json!({ "$ref": "#top", "$defs": { "a": { "$anchor": "top", "not": {} } } });
    assert_eq!(count_of(&anchored), 3);
    let encoded = doubling(40).to_string().replace("#/$defs", "#/%24defs");
    assert!(!size_of(&serde_json::from_str(&encoded).expect("JSON")).expect("known").is_small());
    // All levels are in a cycle, and the first reference leads to the last one.
    let mut cyclic = doubling(40);
    cyclic["$defs"]["level40"] = json!({ "properties": { "in": { "$ref": "#" } } });
    let levels: Vec<Value> =
        (0..=40).rev().map(|level| json!({ "$ref": format!("#/$defs/level{level}") })).collect();
    cyclic["$ref"] = Value::Null;
    cyclic["allOf"] = levels.into();
    assert!(!size_of(&cyclic).expect("known").is_small());
    let list = json!({ "properties": { "next": { "$ref": "#" }, "other": { "$ref": "#" } } });
    assert!(count_of(&list) < 10);
}

/// Properties may have the names of keywords, and data may look like a reference.
#[test]
fn only_keywords_are_references() {
    let schema = json!({
        "properties": { "default": { "$ref": "#/$defs/a" }, "$ref": { "not": {} } },
        "const": { "$ref": "#/none" },
        "default": { "$ref": "#/none" },
        "$defs": { "a": { "allOf": [{}, {}] } },
    });
    assert_eq!(count_of(&schema), 7);
    // The compiler reads keywords of old drafts as well.
    let old = json!({ "dependencies": { "a": { "$ref": "#/none" }, "b": ["c"] } });
    assert!(size_of(&old).is_err());
    for unknown in ["#/none", "#none", "none.json", "#/$defs/a/allOf/2", "#%"] {
        let schema = json!({ "$ref": unknown, "$defs": { "a": { "allOf": [{}, {}] } } });
        assert!(size_of(&schema).is_err(), "{unknown}");
    }
}

/// If a file describes many types, its schema is compiled only once.
#[test]
fn types_share_a_schema() {
    let folder = tempfile::tempdir().expect("a folder");
    let defined = DefinedSchemas::default();
    let copied = |count: usize| {
        let types: Vec<String> = (0..count).map(|number| format!("SOAR-{number}")).collect();
        let schema = json!({ "properties": { "type": { "enum": types } } });
        fs::write(folder.path().join("all.json"), schema.to_string()).expect("a file");
        let mut copied = 0;
        let (mut schemas, mut problems) = (Schemas::default(), Vec::new());
        let loaded = schemas.load_folder(folder.path(), &defined, &mut copied, &mut problems);
        loaded.expect("a schema");
        let first = &schemas.by_type["SOAR-0"][0];
        assert!(schemas.by_type.values().all(|known| Arc::ptr_eq(&known[0], first)));
        assert_eq!(schemas.by_type.len(), count);
        copied
    };
    let (once, twice) = (copied(2_000), copied(4_000));
    assert!(twice <= 2 * once, "{once}, {twice}");
}

/// Files that share a schema contain a copy each, so the total is bounded.
#[test]
fn bounds_the_copies_of_shared_schemas() {
    let folder = tempfile::tempdir().expect("a folder");
    let large: Vec<usize> = (0..10_000).collect();
    fs::write(folder.path().join("shared.json"), json!({ "enum": large }).to_string()).expect("a file");
    for number in 0..20 {
        let path = folder.path().join(format!("SOAR-{number}.json"));
        fs::write(path, r#"{"$ref":"shared.json"}"#).expect("a file");
    }
    let defined = DefinedSchemas::default();
    let problem = Schemas::load(&[folder.path().to_owned()], &defined).expect_err("too many");
    assert!(problem.to_string().contains("too many references: "), "{problem}");
}
