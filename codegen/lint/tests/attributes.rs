//! Tests that each attribute reaches all outputs. Adding a row to the list of attributes must be enough to support a
//! new attribute.

use uavspec_emit::{docs, inspect, json_schema, python, rust, typescript};
use uavspec_schema::msg::Dialect;
use uavspec_schema::msg::attribute::{ATTRIBUTES, Attribute};
use uavspec_schema::translation::{self, Translations, texts};
use uavspec_schema::{Form, PackageInput, Schema, SourceMap, read};

use crate::layout::laid_out;

const WORD: &str = "zenith";

fn definition(attribute: &Attribute) -> String {
    format!(
        "# Wind\n\nuint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@{} {WORD}] Speed\n",
        attribute.name
    )
}

/// The schema of a message with the attribute, and its Ukrainian translation.
fn schema(attribute: &Attribute) -> (SourceMap, Schema, Translations) {
    let mut sources = SourceMap::default();
    let id = sources.add("Wind.msg", definition(attribute).into()).expect("a text");
    let (schema, diagnostics) =
        read(&sources, &[PackageInput::new("demo", Form::Msg(Dialect::Px4), vec![id])]);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    let head =
        "msgid \"\"\nmsgstr \"\"\n\"Language: uk\\n\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n";
    let entries = texts(&schema).into_iter();
    let entries = entries.filter(|text| text.text == WORD);
    let entries: String = entries
        .map(|text| format!("\nmsgctxt \"{}\"\nmsgid \"{WORD}\"\nmsgstr \"зеніт\"\n", text.key))
        .collect();
    let id = sources.add("uk.po", format!("{head}{entries}").into()).expect("a text");
    let (translations, diagnostics) = translation::resolve(&sources, &schema, &[id]);
    let missing = |code: &str| code == "translation-missing";
    assert!(diagnostics.iter().all(|found| missing(found.problem.code())), "{diagnostics:?}");
    (sources, schema, translations)
}

#[test]
fn every_attribute_reaches_every_output() {
    for attribute in ATTRIBUTES {
        let (sources, schema, translations) = schema(attribute);
        let fact = format!("{}: {WORD}", attribute.words.split(':').next().expect("a label"));
        let capital = fact[..1].to_uppercase() + &fact[1..];
        let page = docs::emit(&schema, &translations, &sources, &docs::Options::default());
        let rust = rust::emit(&schema, &sources, &rust::Options::default());
        let typescript = typescript::emit(&schema, &translations, &typescript::Options::default());
        for (path, files, expected) in [
            ("Wind.md", &page, fact.as_str()),
            ("Wind.uk.md", &page, "зеніт"),
            (
                "Wind.schema.json",
                &json_schema::emit(&schema, &json_schema::Options::default()),
                attribute.keyword,
            ),
            ("wind.rs", &rust, &fact),
            ("demo.ts", &typescript, &fact),
            ("demo.py", &python::emit(&schema, &translations), &fact),
        ] {
            let file = files.iter().find(|file| file.path.ends_with(path));
            let text = &file.unwrap_or_else(|| panic!("{path}")).text;
            assert!(
                text.contains(expected) || text.contains(&capital),
                "{path}: expected `{expected}` in\n{text}"
            );
        }
        let model = inspect::schema(&schema).to_string();
        assert!(model.contains(&format!("\"{}\":\"{WORD}\"", attribute.name)), "{model}");
    }
}

#[test]
fn fmt_orders_every_attribute() {
    for attribute in ATTRIBUTES {
        let text = format!(
            "uint64 timestamp # [us] Time\nfloat32 speed # [@{} {WORD}] [m/s] Speed\n",
            attribute.name
        );
        let found = laid_out("Wind.msg", &text, Form::Msg(Dialect::Px4)).expect("a layout").text;
        assert!(found.contains(&format!("# [m/s] [@{} {WORD}] Speed", attribute.name)), "{found}");
    }
}
