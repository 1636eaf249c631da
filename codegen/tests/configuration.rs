//! Tests of the JSON Schema of `uavspec.toml`.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::Value;
use uavspec_codegen::load::{Config, configuration_schema};
use uavspec_test_definitions::differs;

const PAGE: &str = "../xtask/site/guide/configuration.md";
const SCHEMA: &str = "../generated/schemas/uavspec/configuration.schema.json";

#[test]
fn the_published_schema_is_up_to_date() {
    let text = serde_json::to_string_pretty(&configuration_schema()).expect("JSON") + "\n";
    assert_eq!(differs(Path::new(SCHEMA), &text), None);
}

#[test]
fn the_guide_documents_each_key() {
    let schema = configuration_schema();
    let mut tables = String::new();
    for (name, table) in schema["properties"].as_object().expect("tables") {
        let header = if table.get("items").is_some() { format!("[[{name}]]") } else { format!("[{name}]") };
        let _ = write!(tables, "\n## {header}\n\n| Key | Meaning |\n|---|---|\n");
        list("", table, &mut tables);
    }
    let page = fs::read_to_string(PAGE).expect("the page");
    let (before, rest) = page.split_once("<!-- keys -->\n").expect("a mark");
    let (_, after) = rest.split_once("<!-- end of the keys -->").expect("a mark");
    let expected = format!("{before}<!-- keys -->\n{}\n<!-- end of the keys -->{after}", &tables[1..]);
    assert_eq!(differs(Path::new(PAGE), &expected), None);
}

/// Lists the keys of a table, of the elements of a list, or of an output with options.
fn list(prefix: &str, table: &Value, rows: &mut String) {
    let output = table.pointer("/anyOf/1");
    let table = table.get("items").or(output).unwrap_or(table);
    for (key, value) in table["properties"].as_object().into_iter().flatten() {
        if output.is_some() && key == "path" {
            continue;
        }
        let meaning = value["description"].as_str().expect(key);
        let _ = writeln!(rows, "| `{prefix}{key}` | {meaning} |");
        list(&format!("{prefix}{key}."), value, rows);
    }
}

#[test]
fn the_schema_accepts_what_the_reader_accepts() {
    let schema = configuration_schema();
    let validator = jsonschema::draft7::new(&schema).expect("a schema");
    let package = "[[package]]\nname = 'a'\ndialect = 'px4'\ninclude = ['*.msg']\n";
    for (text, is_valid) in [
        (package.to_owned(), true),
        (format!("{package}select = ['Wind']\nreleases = 'releases'\n"), true),
        (format!("{package}[output]\nrust = 'src'\ndocs = {{ path = 'docs', contents = ['a.md'] }}\n"), true),
        (format!("{package}[output]\ntypescript = {{ path = 'ts', form = 'compiled' }}\n"), true),
        (format!("{package}[lint]\npreset = 'strict'\nlevels = {{ unit-missing = 'off' }}\n"), true),
        (format!("{package}[[lint.ignore]]\nrule = 'unit-missing'\nreason = 'none'\n"), true),
        (format!("{package}[translations]\ninclude = ['i18n/*.po']\n"), true),
        (String::new(), false),
        (package.replace("px4", "px5"), false),
        (package.replace("include", "includes"), false),
        (format!("{package}[output]\nruts = 'src'\n"), false),
        (format!("{package}[output]\nrust = {{ root = 'lib.rs' }}\n"), false),
        (format!("{package}[output]\ndocs = {{ path = 'docs', titel = 'a' }}\n"), false),
        (format!("{package}[output]\ntypescript = {{ path = 'ts', form = 'wasm' }}\n"), false),
        (format!("{package}[lint]\npreset = 'stricter'\n"), false),
        (format!("{package}[lint]\nlevels = {{ unit-missing = 'fatal' }}\n"), false),
        (format!("{package}[[conversion]]\nfrom = 'a'\n"), false),
    ] {
        let value: Value = toml::from_str(&text).expect("TOML");
        assert_eq!(validator.is_valid(&value), is_valid, "{text}");
        let read = Config::parse(Path::new("uavspec.toml"), text.clone()).and_then(Config::plan);
        assert_eq!(read.is_ok(), is_valid, "{text}");
    }
}
