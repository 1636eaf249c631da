//! Comparison of the model with the results of the reference tools for the same files.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::{Value as Json, json};
use uavspec_emit::inspect;
use uavspec_schema::diagnostic::has_errors;
use uavspec_schema::{Form, Schema, render};
use uavspec_test_definitions as support;

fn oracle(path: &Path) -> Json {
    serde_json::from_str(&fs::read_to_string(path).expect("an oracle")).expect("JSON")
}

#[test]
fn px4_layouts_hashes_and_topics_match_the_generator_of_px4() {
    let releases = ["1.13", "1.14", "1.15", "1.16", "1.17", "1.18", "main"];
    for release in releases.into_iter().step_by(support::extent(1, 6)) {
        let Some(folder) = support::shared(&format!("corpus/px4/{release}")) else { return };
        let Some(expected) = support::shared(&format!("oracle/uorb/{release}.json")) else { return };
        let (sources, schema, diagnostics) = support::px4(&folder);
        assert!(!has_errors(&diagnostics), "{}", render::render(&diagnostics, &sources, false));
        let model = inspect::schema(&schema);
        let messages = &model["packages"]["px4"]["messages"];
        let expected = oracle(&expected);
        let expected = expected.as_object().expect("messages");
        assert_eq!(messages.as_object().expect("messages").len(), expected.len());
        for (name, message) in expected {
            let found = &messages[name];
            let slots: Vec<Json> = found["uorb"]["fields"]
                .as_array()
                .expect("a layout")
                .iter()
                .map(|slot| json!([slot["type"], slot["name"], slot["offset"]]))
                .collect();
            let found = json!({
                "struct_size": found["uorb"]["size"],
                "size_no_padding": found["uorb"]["size_no_padding"],
                "hash": found["hash"],
                "topics": found["topics"],
                "fields": slots,
                "queue_length": found["queue_length"],
                "version": found["version"],
            });
            assert_eq!(&found, message, "{release} {name}");
        }
    }
}

fn type_hashes(schema: &Schema, with_package: bool) -> Vec<(String, String)> {
    let mut hashes = Vec::new();
    for package in &schema.packages {
        let name = |kind: &str, name: &str| {
            if with_package { format!("{}/{kind}/{name}", package.ros_package) } else { name.to_owned() }
        };
        for id in &package.messages {
            let message = schema.message(*id);
            hashes.push((name("msg", &message.name), message.type_hash.clone()));
        }
        for interface in &package.interfaces {
            let kind = interface.kind.name();
            hashes.push((name(kind, &interface.name), interface.type_hash.clone().expect("a hash")));
            for id in &interface.parts {
                let part = schema.message(*id);
                hashes.push((name(kind, &part.name), part.type_hash.clone()));
            }
        }
    }
    hashes
}

#[test]
fn ros_type_hashes_match_rosidl() {
    for release in ["1.13", "1.14", "1.15", "1.16", "1.17", "1.18", "main"] {
        let Some(folder) = support::shared(&format!("corpus/px4/{release}/msg")) else { return };
        let Some(expected) = support::shared(&format!("oracle/rihs01/{release}.json")) else { return };
        let (_, schema, _) = support::px4(&folder);
        let expected = oracle(&expected);
        let hashes = type_hashes(&schema, false);
        assert_eq!(hashes.len(), expected.as_object().expect("hashes").len());
        for (name, hash) in hashes {
            assert_eq!(expected[&name], hash, "{release} {name}");
        }
    }
    let Some(folder) = support::shared("corpus/ros2") else { return };
    let Some(expected) = support::shared("oracle/rihs01/ros2.json") else { return };
    let (sources, schema, diagnostics) = support::ros2(&folder);
    assert!(!has_errors(&diagnostics), "{}", render::render(&diagnostics, &sources, false));
    let expected = oracle(&expected);
    let hashes = type_hashes(&schema, true);
    let is_event = |name: &String| name.ends_with("_Event");
    let count = expected.as_object().expect("hashes").keys().filter(|name| !is_event(name)).count();
    assert_eq!(hashes.len(), count, "events are not files, and have no separate hash");
    for (name, hash) in hashes {
        assert_eq!(expected[&name], hash, "{name}");
    }
}

#[test]
fn cdr_sizes_match_encoded_messages() {
    for (folder, cases, is_px4) in [
        ("corpus/px4/main", "oracle/cdr/px4-main.json", true),
        ("corpus/ros2", "oracle/cdr/ros2.json", false),
    ] {
        let (Some(folder), Some(cases)) = (support::shared(folder), support::shared(cases)) else { return };
        let (_, schema, _) = if is_px4 { support::px4(&folder) } else { support::ros2(&folder) };
        for case in oracle(&cases).as_array().expect("cases") {
            let ros_name = case["type"].as_str().expect("a type");
            let size = case["cdr_le_hex"].as_str().expect("bytes").len() as u64 / 2;
            let message = schema
                .messages
                .iter()
                .find(|message| uavspec_schema::fingerprint::ros_name(&schema, message) == ros_name)
                .expect("the type");
            let is_zero = case["case"] == "zero";
            if message.cdr.is_fixed || is_zero {
                assert_eq!(message.cdr.min, size, "{ros_name} {}", case["case"]);
            } else {
                assert!(message.cdr.min <= size, "{ros_name} {}", case["case"]);
            }
        }
    }
}

/// The code, its abbreviation, and the codes that it refers to.
type Codes = Vec<(u32, Option<String>, Vec<u32>)>;

fn error_codes(path: &str, text: &str) -> Codes {
    let (sources, schema, diagnostics) = support::texts(Form::Table, &[(path, text)]);
    assert!(!has_errors(&diagnostics), "{}", render::render(&diagnostics, &sources, false));
    let codes = schema.packages[0].error_tables.iter().flat_map(|table| &table.codes);
    codes.map(|code| (code.code, code.abbreviation.clone(), code.see_also.clone())).collect()
}

#[test]
fn error_codes_match_the_specification_in_all_forms() {
    let Some(page) = support::shared("spec/flockwave-error-codes.txt") else { return };
    let page = fs::read_to_string(page).expect("the page");
    let given = error_codes("page.txt", &page);
    assert_eq!(given.len(), 62);
    let (_, schema, _) = support::texts(Form::Table, &[("page.txt", &page)]);
    let (mut markdown, mut bare, mut asciidoc) = (String::new(), String::new(), String::new());
    for table in &schema.packages[0].error_tables {
        let range = format!("{} (codes {}-{})", table.title, table.range.start(), table.range.end());
        let _ = write!(markdown, "\n## {range}\n\n| Code | Abbr | Description |\n|--:|---|---|\n");
        let _ = write!(bare, "\n## {range}\n\nCode | Abbr | Description\n--- | --- | ---\n");
        let _ = write!(asciidoc, "\n== {range}\n\n|===\n|Code |Abbr |Description\n\n");
        for code in &table.codes {
            let (number, abbreviation) = (code.code, code.abbreviation.as_deref().unwrap_or_default());
            let _ = writeln!(markdown, "| {number} | {abbreviation} | {} |", code.description);
            let _ = writeln!(bare, "{number} | {abbreviation} | {}", code.description);
            let _ = writeln!(asciidoc, "|{number}\n|{abbreviation}\n|{}\n", code.description);
        }
        asciidoc.push_str("|===\n");
    }
    assert_eq!(error_codes("page.md", &markdown), given);
    assert_eq!(error_codes("page.md", &bare), given);
    assert_eq!(error_codes("page.adoc", &asciidoc), given);
    // Our page has one additional code. The references are the same, except where the specification has errors.
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../definitions/flockwave/error-codes.md");
    let own = error_codes("page.md", &fs::read_to_string(own).expect("the definitions"));
    let of = |codes: &Codes| -> Codes {
        codes.iter().filter(|code| ![65, 72, 139, 142].contains(&code.0)).cloned().collect()
    };
    assert_eq!(of(&own), of(&given));
    assert!(own.iter().any(|code| code.0 == 142));
}
