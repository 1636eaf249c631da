//! Event metadata in an editor.

use serde_json::{Value, json};

use super::editor::Editor;

const CONFIG: &str = "[lint]\npreset = \"strict\"\n\n[[package]]\nname = \"events\"\ndialect = \"events\"\ninclude = [\"*.json\"]\n";

const COMMON: &str = r#"{
  "version": 2,
  "components": {
    "0": {
      "namespace": "common",
      "enums": {
        "mode_t": {
          "type": "uint8_t",
          "description": "Mode of the winch",
          "entries": {
            "1": { "name": "tow", "description": "Töw" }
          }
        }
      },
      "event_groups": {
        "default": {
          "events": {
            "1100": {
              "name": "released",
              "message": "Released {1} at {2:.1m}<profile name=\"dev\"> by hand</profile> \\{{3}",
              "description": "Check the hook.",
              "arguments": [
                { "name": "mode", "type": "mode_t" },
                { "name": "height", "type": "float", "description": "Height over the winch" },
                { "name": "side", "type": "kite::side_t" }
              ]
            }
          }
        }
      }
    }
  }
}
"#;

const KITE: &str = r#"{
  "version": 2,
  "components": {
    "7": {
      "namespace": "kite",
      "enums": {
        "side_t": { "type": "int8_t", "entries": { "-1": { "name": "left", "description": "Left" } } }
      }
    }
  }
}
"#;

fn editor() -> Editor {
    let mut editor = Editor::new(&[("uavspec.toml", CONFIG), ("common.json", COMMON), ("kite.json", KITE)]);
    editor.open("common.json");
    editor.expect_codes("common.json", &[]);
    editor
}

/// The names of symbols, each after the names of its parents.
fn names(symbols: &Value, above: &str) -> Vec<String> {
    let mut found = Vec::new();
    for symbol in symbols.as_array().into_iter().flatten() {
        let path = format!("{above}/{}", symbol["name"].as_str().expect("a name"));
        found.push(path.clone());
        found.append(&mut names(&symbol["children"], &path));
    }
    found
}

#[test]
fn each_mistake_is_reported_at_its_place() {
    let mut editor = editor();
    editor.edit("common.json", "\"mode_t\" }", "\"mod_t\" }");
    editor.edit("common.json", "\"1\": {", "\"256\": {");
    editor.expect_codes("common.json", &["event-number", "unknown-event-type"]);
    let places: Vec<(&Value, &Value)> = editor
        .diagnostics("common.json")
        .iter()
        .map(|found| (&found["range"]["start"], &found["range"]["end"]))
        .collect();
    let at = |line: usize, character: usize| json!({ "line": line, "character": character });
    assert_eq!(places, [(&at(10, 12), &at(10, 17)), (&at(22, 42), &at(22, 49))]);
    editor.edit("common.json", "\"mod_t\"", "");
    editor.expect_codes("common.json", &["invalid-json"]);
    editor.edit("common.json", "\"type\":  }", "\"type\": \"uint8_t\" }");
    editor.edit("common.json", "\"256\"", "\"1\"");
    editor.expect_codes("common.json", &[]);
}

#[test]
fn texts_describe_events_and_enums() {
    let mut editor = editor();
    let expected = [
        "`common::released`",
        "Released {1} at {2:.1m} {{3}",
        "Check the hook.",
        "- id: 1100",
        "| `2: height` | float | Height over the winch |",
        "| `3: side` | kite::side_t |",
    ];
    for place in ["\"11^00\"", "\"relea^sed\""] {
        let text = editor.hover("common.json", place).replace("&#123;", "{");
        for line in expected {
            assert!(text.contains(line), "{line} in {text}");
        }
    }
    for place in ["\"mode^_t\": {", "\"^mode_t\" }"] {
        let text = editor.hover("common.json", place);
        assert!(text.contains("`mode_t: uint8_t`") && text.contains("Mode of the winch"), "{text}");
        assert!(text.contains("| `tow` | 1 | Töw |"), "{text}");
    }
    assert_eq!(editor.hover("common.json", "\"flo^at\""), "");
}

#[test]
fn an_enum_is_found_in_all_files() {
    let mut editor = editor();
    let definition = editor.at("definition", "common.json", "kite::side^_t", json!({})).expect("an answer");
    assert_eq!(definition["uri"], json!(editor.uri("kite.json")));
    assert_eq!(definition["range"]["start"], json!({ "line": 6, "character": 9 }));
    let context = json!({ "context": { "includeDeclaration": true } });
    let found = editor.at("references", "common.json", "kite::side^_t", context).expect("an answer");
    assert_eq!(found.as_array().map(Vec::len), Some(2), "{found}");
    let name = json!({ "newName": "flank_t" });
    let renamed = editor.at("rename", "common.json", "\"mode^_t\": {", name.clone()).expect("renamed");
    let text = editor.apply("common.json", &renamed["documentChanges"][0]["edits"]);
    assert_eq!(text, COMMON.replace("mode_t", "flank_t"));
    let error = editor.at("rename", "common.json", "\"relea^sed\"", name).expect_err("refused");
    assert!(error.contains("id is derived from its name"), "{error}");
}

#[test]
fn an_outline_lists_components_enums_groups_and_events() {
    let mut editor = editor();
    let symbols = editor.about("documentSymbol", "common.json", json!({})).expect("an answer");
    let expected =
        ["/common", "/common/mode_t", "/common/mode_t/tow", "/common/default", "/common/default/released"];
    assert_eq!(names(&symbols, ""), expected);
    let group = &symbols[0]["children"][1];
    assert_eq!(group["range"]["end"], json!({ "line": 28, "character": 9 }));
    assert_eq!(group["selectionRange"]["start"], json!({ "line": 15, "character": 8 }));
    let found = editor.request("workspace/symbol", json!({ "query": "SIDE" })).expect("an answer");
    assert_eq!((&found[0]["name"], &found[0]["containerName"]), (&json!("side_t"), &json!("kite")));
}

#[test]
fn types_are_completed_between_quotes() {
    let mut editor = editor();
    let mut labels = |place: &str| -> Vec<String> {
        let items = editor.at("completion", "common.json", place, json!({})).expect("an answer");
        let labels = items.as_array().expect("a list").iter();
        labels.map(|item| item["label"].as_str().unwrap_or_default().to_owned()).collect()
    };
    let types = labels("\"mo^de_t\" }");
    assert_eq!(types.iter().filter(|name| name.ends_with("side_t") || name.ends_with("mode_t")).count(), 2);
    for name in ["mode_t", "kite::side_t", "float", "int64_t"] {
        assert!(types.iter().any(|known| known == name), "{name} in {types:?}");
    }
    let integers = labels("\"type\": \"^uint8_t\"");
    assert!(integers.len() == 8 && !integers.contains(&"float".to_owned()), "{integers:?}");
    assert!(labels("\"rel^eased\"").is_empty());
    editor.edit("common.json", "\"name\": \"released\"", "\"type\": \"\", \"name\": \"released\"");
    let items = editor.at("completion", "common.json", "\"type\": \"^\"", json!({})).expect("an answer");
    let text = editor.apply("common.json", &json!([items[0]["textEdit"]]));
    assert!(text.contains("\"type\": \"summary\", \"name\""), "{text}");
}

#[test]
fn json_is_left_to_other_formatters() {
    let mut editor = editor();
    let options = json!({ "options": { "tabSize": 4, "insertSpaces": true } });
    assert_eq!(editor.about("formatting", "common.json", options), Ok(Value::Null));
    let tokens = editor.about("semanticTokens/full", "common.json", json!({})).expect("an answer");
    let folds = editor.about("foldingRange", "common.json", json!({})).expect("an answer");
    assert_eq!((&tokens["data"], &folds), (&json!([]), &json!([])));
}

#[test]
fn incomplete_metadata_is_no_obstacle() {
    let mut editor = editor();
    let ends = COMMON.char_indices().map(|(at, _)| at).step_by(29);
    for text in
        ends.map(|end| &COMMON[..end]).chain(["{\"components\":{\"\":{\"enums\":{\"\":\"\"}}}}", "[]"])
    {
        editor.open_with("common.json", text);
        let end = json!({ "line": text.matches('\n').count(), "character": 99 });
        for method in ["hover", "completion", "documentSymbol", "references", "codeAction"] {
            let context = json!({ "diagnostics": [], "includeDeclaration": true });
            let params =
                json!({ "position": end, "range": { "start": end, "end": end }, "context": context });
            editor.about(method, "common.json", params).expect(method);
        }
    }
}
