//! Tests that each constraint reaches all outputs. Adding a row to the list of constraints must be enough to support a
//! new constraint.

use uavspec_dynamic::breaking::{Between, breaking};
use uavspec_emit::{docs, inspect, json_schema, python, rust, typescript, vectors};
use uavspec_schema::msg::Dialect;
use uavspec_schema::msg::constraint::{CONSTRAINTS, ConstraintKind};
use uavspec_schema::translation::Translations;
use uavspec_schema::{Form, PackageInput, Schema, SourceMap, read};

use crate::layout::laid_out;

/// Two sample arguments of a constraint, and the words that outputs use for the first argument.
fn arguments(kind: &ConstraintKind) -> (&'static str, &'static str, &'static str) {
    match kind.name {
        "range" => ("0, 60", "0, 50", "0 to 60"),
        "invalid" => ("-1", "-2", "no data: -1"),
        "uncontrolled" => ("-1", "-2", "not controlled: -1"),
        name => panic!("add arguments of `@{name}`"),
    }
}

fn definition(kind: &ConstraintKind, argument: &str) -> String {
    format!(
        "# Wind\n\nuint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@{} {argument}] Speed\n",
        kind.name
    )
}

fn schema(sources: &mut SourceMap, text: String) -> Schema {
    let id = sources.add("Wind.msg", text.into()).expect("a text");
    let (schema, diagnostics) =
        read(sources, &[PackageInput::new("demo", Form::Msg(Dialect::Px4), vec![id])]);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    schema
}

#[test]
fn every_constraint_reaches_every_output() {
    for kind in CONSTRAINTS {
        let (argument, _, words) = arguments(kind);
        let mut sources = SourceMap::default();
        let schema = schema(&mut sources, definition(kind, argument));
        let translations = Translations::default();
        let plain = |text: &str| text.replace("&nbsp;", " ").replace('`', "").to_lowercase();
        let in_docs =
            words.split_once(": ").map_or(words.to_owned(), |(label, value)| format!("{value}: {label}"));
        for (path, files, expected) in [
            (
                "Wind.md",
                docs::emit(&schema, &translations, &sources, &docs::Options::default()),
                in_docs.as_str(),
            ),
            ("Wind.schema.json", json_schema::emit(&schema, &json_schema::Options::default()), kind.keyword),
            ("wind.rs", rust::emit(&schema, &sources, &rust::Options::default()), words),
            ("demo.ts", typescript::emit(&schema, &translations, &typescript::Options::default()), words),
            ("demo.py", python::emit(&schema, &translations), words),
        ] {
            let file = files.iter().find(|file| file.path.ends_with(path));
            let text = plain(&file.unwrap_or_else(|| panic!("{path}")).text);
            assert!(text.contains(expected), "{path}: expected `{expected}` in\n{text}");
        }
        let field = &inspect::schema(&schema)["packages"]["demo"]["messages"]["Wind"]["fields"][1];
        assert!(!field[kind.name].is_null(), "{field}");
        let count = |schema: &Schema| {
            let files = vectors::emit(schema, &vectors::Options::default());
            files.iter().map(|file| file.text.matches("\"id\": \"speed").count()).sum::<usize>()
        };
        let without = "# Wind\n\nuint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] Speed\n".to_owned();
        let fewer = count(&self::schema(&mut SourceMap::default(), without));
        assert!(count(&schema) > fewer, "{} must add test vectors", kind.name);
    }
}

#[test]
fn a_changed_constraint_is_reported() {
    for kind in CONSTRAINTS {
        let (before, now, _) = arguments(kind);
        let mut sources = SourceMap::default();
        let [old, new] = [before, now].map(|argument| schema(&mut sources, definition(kind, argument)));
        let findings = breaking(&sources, &old, &new, Between::Commits);
        assert_eq!(findings.len(), 1, "{}: {findings:?}", kind.name);
        assert!(findings[0].rule.starts_with("field-"), "{findings:?}");
    }
}

#[test]
fn fmt_orders_every_constraint() {
    for kind in CONSTRAINTS {
        let (argument, ..) = arguments(kind);
        let (name, spaced) = (kind.name, argument.replace(", ", " ,  "));
        let text =
            format!("uint64 timestamp # [us] Time\nfloat32 speed # [@{name}  {spaced} ] [m/s] Speed\n");
        let found = laid_out("Wind.msg", &text, Form::Msg(Dialect::Px4)).expect("a layout").text;
        assert!(found.contains(&format!("# [m/s] [@{name} {argument}] Speed")), "{found}");
    }
}
