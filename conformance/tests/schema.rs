//! Tests of user-defined JSON Schemas for message types that the definitions don't contain.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};
use tempfile::TempDir;

/// Files by name.
type Files<'f> = &'f [(&'f str, Value)];

/// A folder with files.
fn folder(files: Files<'_>) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, value) in files {
        write(folder.path(), name, &value.to_string());
    }
    folder
}

fn write(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    fs::write(path, text).expect("a file");
}

/// Writes a recorded session of responses and notifications with these bodies.
fn recording(folder: &Path, responses: &[Value], notifications: &[Value]) {
    let line = |body: &Value, refs: Option<&str>| {
        let mut message = json!({ "$fw.version": "1.0", "id": "say", "body": body });
        if let Some(refs) = refs {
            message["refs"] = refs.into();
        }
        format!("{}\n", json!({ "dir": "in", "msg": message }))
    };
    let responses = responses.iter().map(|body| line(body, Some("ask")));
    let notifications = notifications.iter().map(|body| line(body, None));
    write(folder, "hill.jsonl", &responses.chain(notifications).collect::<String>());
}

/// Runs `check`. Returns the exit status, standard output and standard error.
fn check(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    let output = command.arg("check").args(arguments).current_dir(folder).output().expect("it runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// The findings in the recorded session: rule, subject, location, expected and actual value.
fn findings(folder: &Path, arguments: &[&str]) -> Vec<[String; 5]> {
    let all = [&["--format", "json", "hill.jsonl"], arguments].concat();
    let (status, printed, output) = check(folder, &all);
    assert!(matches!(status, Some(0 | 1 | 6)), "{output}");
    let report: Value = serde_json::from_str(&printed).expect("JSON");
    let found = report["subjects"][0]["findings"].as_array().expect("findings").iter();
    let example = |group: &Value, example: &Value| {
        [&group["rule"], &group["subject"], &example["path"], &example["expected"], &example["actual"]]
            .map(|value| value.as_str().unwrap_or_default().to_owned())
    };
    found
        .flat_map(|group| {
            group["examples"].as_array().expect("examples").iter().map(move |one| example(group, one))
        })
        .collect()
}

/// A schema for bodies of this type, with a field `lift`.
fn lift(type_name: &str, lift: &Value) -> Value {
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "type": "object",
        "properties": { "type": { "const": type_name }, "lift": lift },
        "required": ["type", "lift"],
    })
}

#[test]
fn checks_bodies_against_the_schema_of_their_type() {
    let number = json!({ "type": "number", "minimum": 0 });
    let by_name = json!({ "required": ["marks"] });
    let one_of_two =
        json!({ "properties": { "type": { "enum": ["SOAR-ON", "SOAR-OFF"] } }, "maxProperties": 1 });
    let folder = folder(&[
        ("schemas/lift.json", lift("SOAR-INF", &number)),
        ("schemas/more/SOAR-LIST.json", by_name),
        ("schemas/more/switch.json", one_of_two),
        ("schemas/notes.txt", json!("no schema")),
    ]);
    let responses = [
        json!({ "type": "SOAR-INF", "lift": 1.5 }),
        json!({ "type": "SOAR-INF", "lift": -1 }),
        json!({ "type": "SOAR-LIST" }),
        json!({ "type": "SOAR-OFF", "now": true }),
        json!({ "type": "SOAR-ON" }),
        json!({ "type": "SOAR-HIGH" }),
    ];
    recording(folder.path(), &responses, &[]);
    let slash = std::path::MAIN_SEPARATOR;
    let expected: Vec<[String; 5]> = [
        ["SOAR-INF", "/body/lift", "lift.json at /properties/lift/minimum: 0", "-1"],
        ["SOAR-LIST", "/body", "more/SOAR-LIST.json at /required: [\"marks\"]", "an object"],
        ["SOAR-OFF", "/body", "more/switch.json at /maxProperties: 1", "an object"],
    ]
    .map(|[subject, path, what, actual]| {
        let expected = format!(
            "a value that matches schemas{slash}{}",
            what.replacen("more/", &format!("more{slash}"), 1)
        );
        ["FW-ENV-18".to_owned(), subject.to_owned(), path.to_owned(), expected, actual.to_owned()]
    })
    .to_vec();
    assert_eq!(findings(folder.path(), &["--schema", "schemas"]), expected);

    let (_, text, _) = check(folder.path(), &["--schema", "schemas", "hill.jsonl"]);
    assert!(text.contains("unsupported  1 message without a definition: SOAR-HIGH"), "{text}");
    assert!(findings(folder.path(), &[]).is_empty(), "bodies aren't checked without schemas");
}

#[test]
fn reads_the_direction_from_the_file_name() {
    let folder = folder(&[
        ("a/response_SOAR-INF.json", lift("SOAR-INF", &json!({ "type": "number" }))),
        ("b/SOAR-INF.notification.schema.json", json!({ "required": ["wind"] })),
    ]);
    let body = json!({ "type": "SOAR-INF", "lift": "much" });
    recording(folder.path(), std::slice::from_ref(&body), std::slice::from_ref(&body));
    let found = findings(folder.path(), &["--schema", "a", "--schema", "b"]);
    let places: Vec<&str> = found.iter().map(|[_, _, path, ..]| path.as_str()).collect();
    assert_eq!(places, ["/body/lift", "/body"]);
    let found = findings(folder.path(), &["--schema", "a"]);
    assert_eq!(found.len(), 1, "{found:?}");
}

/// Definitions take precedence over user-defined schemas.
#[test]
fn prefers_definitions_to_schemas() {
    let folder = folder(&[("schemas/SYS-VER.json", json!({ "maxProperties": 0 }))]);
    recording(folder.path(), &[json!({ "type": "SYS-VER", "software": "Windward", "version": "3.1" })], &[]);
    assert!(findings(folder.path(), &["--schema", "schemas"]).is_empty());
}

/// Schemas refer to each other by file name or by `$id`. All of them use the draft that one of them declares.
#[test]
fn resolves_references_between_schemas() {
    let common = json!({
        "pair": { "type": "array", "items": [{ "type": "integer" }, { "type": "string" }] },
        "$schema": "http://json-schema.org/draft-07/schema#",
    });
    let by_id = json!({
        "$id": "https://example.org/soar/response_SOAR-TWO.json",
        "properties": { "type": { "const": "SOAR-TWO" }, "lift": { "$ref": "common.json#/pair" } },
    });
    let by_name = json!({
        "properties": { "type": { "const": "SOAR-ONE" }, "lift": { "$ref": "common.json#/pair" } },
    });
    let folder = folder(&[
        ("schemas/common.json", common),
        ("schemas/one.json", by_name),
        ("schemas/two.json", by_id),
    ]);
    let responses = ["SOAR-ONE", "SOAR-TWO"].map(|name| json!({ "type": name, "lift": [1, 2] }));
    recording(folder.path(), &responses, &[]);
    let found = findings(folder.path(), &["--schema", "schemas"]);
    let places: Vec<&str> = found.iter().map(|[_, _, path, ..]| path.as_str()).collect();
    assert_eq!(places, ["/body/lift/1", "/body/lift/1"]);
}

#[test]
fn reports_an_invalid_schema_with_its_location() {
    let good = || lift("SOAR-INF", &json!({}));
    let bad_type = lift("SOAR-INF", &json!({ "type": "altitude" }));
    let missing = lift("SOAR-INF", &json!({ "$ref": "https://example.org/none.json" }));
    let cases: [(Files<'_>, &str, &str); 5] = [
        (&[("s/a.json", bad_type)], "a.json:/properties/lift/type: invalid JSON Schema", "altitude"),
        (
            &[("s/a.json", missing)],
            "a.json",
            "no file in the folder is named `none.json`, and remote schemas aren't fetched",
        ),
        (&[("s/a.json", json!({ "type": "object" }))], "s: no `*.json` file in this folder", "SYS-VER.json"),
        (
            &[("s/a.json", good()), ("s/b.json", good())],
            "b.json: ",
            "is also a schema for the body of SOAR-INF",
        ),
        (&[("t/a.json", good())], "s: can't be read", ""),
    ];
    for (files, location, what) in cases {
        let folder = folder(files);
        recording(folder.path(), &[], &[]);
        let (status, _, output) = check(folder.path(), &["--schema", "s", "hill.jsonl"]);
        assert_eq!(status, Some(2), "{output}");
        assert!(
            output.starts_with("error: ") && output.contains(location) && output.contains(what),
            "{location}: {output}"
        );
    }
    let folder = folder(&[]);
    write(folder.path(), "s/a.json", "{\n  \"type\": }");
    let (status, _, output) = check(folder.path(), &["--schema", "s", "hill.jsonl"]);
    assert_eq!(status, Some(2));
    assert!(output.contains("a.json:2:11: invalid JSON: "), "{output}");
}

/// Other rules cover invalid JSON, and numbers that a float can't represent.
#[test]
fn ignores_bodies_that_schemas_cannot_represent() {
    let folder = folder(&[("s/a.json", lift("SOAR-INF", &json!({ "type": "string" })))]);
    let line = |lift: &str| {
        let body = format!("{{\"type\":\"SOAR-INF\",\"lift\":{lift}}}");
        format!("{{\"dir\":\"in\",\"msg\":{{\"$fw.version\":\"1.0\",\"id\":\"a\",\"body\":{body}}}}}\n")
    };
    let of_schema = |lift: &str| {
        write(folder.path(), "hill.jsonl", &line(lift));
        findings(folder.path(), &["--schema", "s"]).iter().filter(|one| one[0] == "FW-ENV-18").count()
    };
    assert_eq!(["7", "NaN", "1e400"].map(of_schema), [1, 0, 0]);
}

/// An `$id` that isn't referenced has no effect.
#[test]
fn takes_inner_ids() {
    let shared = json!({
        "glider": { "$id": "Glider", "enum": ["wood", "glass"] },
        "pilot": { "$id": "Pilot", "properties": { "glider": { "$ref": "Glider" }, "name": { "$ref": "#/name" } } },
        "name": { "type": "string" },
        "label": { "$ref": "#/name" },
    });
    let schema = json!({ "properties": {
        "label": { "$ref": "shared.json#/label" },
        "pilot": { "$ref": "shared.json#/pilot" },
        "glider": { "$ref": "shared.json#/glider" },
    } });
    let folder = folder(&[("s/shared.json", shared), ("s/SOAR-INF.json", schema)]);
    let body = json!({
        "type": "SOAR-INF", "label": 5, "glider": "lead", "pilot": { "glider": "glass", "name": 7 },
    });
    recording(folder.path(), &[body], &[]);
    let found = findings(folder.path(), &["--schema", "s"]);
    let mut found: Vec<&str> = found.iter().map(|[_, _, path, ..]| path.as_str()).collect();
    found.sort_unstable();
    assert_eq!(found, ["/body/glider", "/body/label", "/body/pilot/name"]);
}

/// The problem is reported for the file that contains it, which may differ from the file with the reference.
#[test]
fn refuses_references_with_two_meanings() {
    let inner =
        json!({ "$id": "https://example.org/b/", "$ref": "#/$defs/c", "$defs": { "c": { "maxLength": 1 } } });
    let mut shared = json!({ "$defs": { "a": inner } });
    let schema = json!({ "properties": { "lift": { "$ref": "shared.json#/$defs/a" } } });
    let folder = folder(&[("s/shared.json", shared.clone()), ("s/SOAR-INF.json", schema)]);
    recording(folder.path(), &[json!({ "type": "SOAR-INF", "lift": "much" })], &[]);
    let found = findings(folder.path(), &["--schema", "s"]);
    assert_eq!(found.len(), 1, "{found:?}");

    shared["$defs"]["c"] = json!({ "minLength": 1 });
    write(folder.path(), "s/shared.json", &shared.to_string());
    let (status, _, output) = check(folder.path(), &["--schema", "s", "hill.jsonl"]);
    assert_eq!(status, Some(2), "{output}");
    let expected = "shared.json:/$defs/a: the reference `#/$defs/c` has two meanings";
    assert!(output.contains(expected) && output.contains("`https://example.org/b/`"), "{output}");
}

/// Definitions take precedence, so schemas for defined types needn't be valid, unique, or usable. Folders may also
/// contain example messages.
#[test]
fn ignores_schemas_of_defined_types() {
    let missing = json!({ "$ref": "none.json#/version" });
    let folder = folder(&[
        ("s/response_SYS-VER.json", json!({ "anyOf": [{ "$ref": "response_SYS-VER_Short.json#" }] })),
        ("s/response_SYS-VER_Short.json", json!({ "properties": { "type": { "const": "SYS-VER" } } })),
        ("s/SYS-TIME.json", json!({ "minimum": 0, "exclusiveMinimum": true })),
        ("s/SYS-PORTS.json", missing),
        ("s/SOAR-INF.json", lift("SOAR-INF", &json!({ "type": "number" }))),
        ("s/examples/response_SOAR-INF.json", json!({ "type": "SOAR-INF", "lift": 5 })),
    ]);
    recording(folder.path(), &[json!({ "type": "SOAR-INF", "lift": "much" })], &[]);
    let found = findings(folder.path(), &["--schema", "s"]);
    assert_eq!(found.len(), 1, "{found:?}");
}

/// In later drafts, keywords of draft 4 are errors, but only in schemas that are used.
#[test]
fn checks_only_the_schemas_that_are_used() {
    let old = json!({ "minimum": 0, "exclusiveMinimum": true });
    let shared = json!({ "old": old, "new": { "exclusiveMinimum": 0 }, "broken": { "$ref": "#/none" } });
    let mut schema = json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "definitions": { "old": old, "broken": { "$ref": "none.json" } },
        "properties": { "lift": { "$ref": "shared.json#/new" } },
    });
    let folder = folder(&[("s/shared.json", shared), ("s/SOAR-INF.json", schema.clone())]);
    recording(folder.path(), &[json!({ "type": "SOAR-INF", "lift": 0 })], &[]);
    let found = findings(folder.path(), &["--schema", "s"]);
    let file = Path::new("s").join("shared.json");
    let expected = format!("a value that matches {} at /new/exclusiveMinimum: 0", file.display());
    assert_eq!(found.iter().map(|one| one[3].clone()).collect::<Vec<_>>(), [expected]);

    schema["properties"]["lift"] = json!({ "allOf": [
        { "$ref": "shared.json#/old" },
        { "$ref": "shared.json#/broken" },
    ] });
    write(folder.path(), "s/SOAR-INF.json", &schema.to_string());
    write(folder.path(), "s/SOAR-LIST.json", r##"{"$ref": "#/none"}"##);
    let (status, _, output) = check(folder.path(), &["--schema", "s", "hill.jsonl"]);
    assert_eq!(status, Some(2), "{output}");
    let broken = "shared.json:/broken: unknown reference: nothing in the file has the location `/none`";
    assert!(output.contains(broken), "{output}");
    assert!(output.contains("SOAR-LIST.json: unknown reference"), "all problems are reported: {output}");

    schema["properties"]["lift"] = json!({ "$ref": "shared.json#/old" });
    write(folder.path(), "s/SOAR-INF.json", &schema.to_string());
    let (_, _, output) = check(folder.path(), &["--schema", "s", "hill.jsonl"]);
    assert!(output.contains("shared.json:/old/exclusiveMinimum: invalid JSON Schema"), "{output}");
}

/// Several files may describe the alternatives of a body, if one file refers to the others.
#[test]
fn takes_several_files_for_a_type_if_one_refers_to_the_others() {
    let alternative =
        |field: &str| json!({ "properties": { "type": { "const": "SOAR-INF" } }, "required": [field] });
    let both = json!({ "anyOf": [
        { "$ref": "response_SOAR-INF_Short.json#" },
        { "$ref": "response_SOAR-INF_Long.json" },
    ] });
    let folder = folder(&[
        ("s/response_SOAR-INF_Long.json", alternative("text")),
        ("s/response_SOAR-INF_Short.json", alternative("lift")),
        ("s/response_SOAR-INF.json", both),
    ]);
    let responses = [json!({ "type": "SOAR-INF", "lift": 1 }), json!({ "type": "SOAR-INF" })];
    recording(folder.path(), &responses, &[]);
    let found = findings(folder.path(), &["--schema", "s"]);
    assert_eq!(found.len(), 1, "{found:?}");
}

/// Each file has its own draft.
#[test]
fn takes_files_of_different_drafts() {
    let old = json!({
        "$schema": "http://json-schema.org/draft-04/schema#", "id": "old", "minimum": 0, "exclusiveMinimum": true,
    });
    let schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "properties": { "lift": { "$ref": "old.json", "maximum": 9 } },
    });
    let folder = folder(&[("s/old.json", old), ("s/SOAR-INF.json", schema)]);
    let responses = [0, 1, 10].map(|lift| json!({ "type": "SOAR-INF", "lift": lift }));
    recording(folder.path(), &responses, &[]);
    let found = findings(folder.path(), &["--schema", "s"]);
    let found: Vec<&str> = found.iter().map(|one| one[3].rsplit(' ').nth(1).unwrap_or_default()).collect();
    assert_eq!(found, ["/exclusiveMinimum:", "/properties/lift/maximum:"]);
}

#[test]
fn bounds_the_size_of_schemas() {
    let values: Vec<u32> = (0..300_000).collect();
    let folder = folder(&[("s/SOAR-INF.json", json!({ "enum": values }))]);
    recording(folder.path(), &[], &[json!({ "type": "SOAR-INF" })]);
    let (status, _, output) = check(folder.path(), &["--schema", "s", "hill.jsonl"]);
    assert_eq!(status, Some(2), "{output}");
    assert!(output.contains("contain more than 200000 values"), "{output}");
}

#[test]
fn schemas_that_double_with_each_reference_are_refused() {
    let level = |at: usize| {
        let reference = json!({ "$ref": format!("#/$defs/level{}", at + 1) });
        (format!("level{at}"), json!({ "allOf": [reference, reference] }))
    };
    let mut levels: serde_json::Map<String, Value> = (0..40).map(level).collect();
    levels.insert("level40".to_owned(), json!({ "type": "object" }));
    let schema = json!({ "$ref": "#/$defs/level0", "$defs": levels });
    let folder = folder(&[("schemas/SOAR-INF.json", schema)]);
    recording(folder.path(), &[], &[json!({ "type": "SOAR-INF" })]);
    let (status, _, output) = check(folder.path(), &["--schema", "schemas", "hill.jsonl"]);
    assert_eq!(status, Some(2), "{output}");
    assert!(output.contains("SOAR-INF.json: too many references"), "{output}");
}
