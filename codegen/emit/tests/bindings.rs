//! Tests of the TypeScript and Python modules. These tests don't require TypeScript or Python to be installed; the
//! tests in `xtask` run the type checkers.

use std::collections::BTreeSet;

use uavspec_emit::{OutputFile, python, typescript};
use uavspec_schema::msg::Dialect;
use uavspec_schema::translation::{self, Translations};
use uavspec_schema::{Form, Schema, SourceMap, read};
use uavspec_test_definitions as support;

/// No translations.
const NONE: Translations = Translations { languages: Vec::new() };

const WIND: &str = "# Wind over ground: */ \"\"\" {@link x} \\\n\nuint8 KIND_STEADY=0 # Blows\nuint8 KIND_GUST=1\n\
                    uint64 GREATEST=18446744073709551615\nfloat32 NONE=nan\n\nuint64 timestamp # [us] Since start\n\
                    float32[2] speed # [m/s] [@range 0, 60] Along both axes\nuint8 kind # [@enum KIND] What it does\n\
                    char[8] name # Of the wind\nuint8 lambda # A keyword\n";

fn schema(form: Form, files: &[(&str, &str)]) -> Schema {
    let mut sources = SourceMap::default();
    let mut package = support::package("demo", form);
    for (path, text) in files {
        package.sources.push(sources.add(*path, text.as_bytes().to_vec()).expect("a text"));
    }
    let (schema, diagnostics) = read(&sources, &[package]);
    assert!(
        diagnostics.iter().all(|found| found.level() != uavspec_schema::diagnostic::Level::Error),
        "{diagnostics:?}"
    );
    schema
}

fn px4(files: &[(&str, &str)]) -> Schema {
    schema(Form::Msg(Dialect::Px4), files)
}

fn text<'f>(files: &'f [OutputFile], path: &str) -> &'f str {
    &files.iter().find(|file| file.path == path).unwrap_or_else(|| panic!("no {path}")).text
}

#[track_caller]
fn has(text: &str, expected: &str) {
    assert!(text.contains(expected), "{expected}\n--- not found in\n{text}");
}

fn emit_typescript(schema: &Schema, form: typescript::Form) -> Vec<OutputFile> {
    typescript::emit(schema, &NONE, &typescript::Options { form })
}

#[test]
fn declares_fields_with_their_json_types() {
    let schema = px4(&[("Wind.msg", WIND)]);
    let modules = emit_typescript(&schema, typescript::Form::Source);
    let module = text(&modules, "demo.ts");
    for line in [
        "timestamp: number;",
        "speed: (number | null)[];",
        "kind: WindKind;",
        "name: string;",
        "lambda: number;",
    ] {
        has(module, &format!("\n  {line}\n"));
    }
    has(
        module,
        "   * Type: float32\\[2\\]; unit: m/s (metres per second); range: 0 to 60; null represents NaN.\n",
    );
    has(module, "export type WindKind = (typeof WindKind)[keyof typeof WindKind] | (number & {});");
    has(module, "GREATEST: 18446744073709551615n,");
    has(module, "NONE: NaN,");
    let modules = python::emit(&schema, &NONE);
    let module = text(&modules, "demo.py");
    for line in [
        "\"speed\": list[Union[float, None]],",
        "\"kind\": Union[\"WindKind\", int],",
        "\"name\": str,",
        "\"lambda\": int,",
    ] {
        has(module, &format!("\n        {line}\n"));
    }
    has(module, "\n- kind: What it does\n  Type: uint8; values: WindKind.\n");
    has(module, "class WindKind(OpenIntEnum):");
    has(module, "GREATEST: Final = 18446744073709551615\n");
    has(module, "NONE: Final = float(\"nan\")\n");
}

#[test]
fn escapes_texts_in_comments_and_strings() {
    let schema = px4(&[("Wind.msg", WIND)]);
    let modules = emit_typescript(&schema, typescript::Form::Source);
    let module = text(&modules, "demo.ts");
    has(module, "Wind over ground: \\*&#47; \"\"\" {\\@link x} \\\\\n");
    assert_eq!(module.matches("/**").count(), module.matches("*/").count());
    has(text(&python::emit(&schema, &NONE), "demo.py"), "Wind over ground: */ \\\"\\\"\" {@link x} \\\\\n");
}

/// The names that a Python module exports.
fn python_names(module: &str) -> BTreeSet<String> {
    let list = module.split("__all__ = [").nth(1).and_then(|rest| rest.split(']').next()).expect("a list");
    list.lines()
        .filter_map(|line| line.trim().trim_end_matches(',').strip_prefix('"')?.strip_suffix('"'))
        .map(str::to_owned)
        .collect()
}

/// The names that directly follow one of the prefixes in `starts` at the beginning of a line.
fn names_after(module: &str, starts: &[&str]) -> BTreeSet<String> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let after = |line: &str| {
        let rest = starts.iter().find_map(|start| line.strip_prefix(start))?;
        Some(rest[..rest.find(|c| !is_part(c)).unwrap_or(rest.len())].to_owned())
    };
    module.lines().filter_map(after).collect()
}

#[test]
fn uses_the_same_names_in_both_languages() {
    let gliders = include_str!("../../schema/tests/fixtures/ok/type-tables/gliders.md");
    let odd = include_str!("../../schema/tests/fixtures/ok/type-tables-names/odd.md");
    let schemas = [
        schema(Form::Table, &[("gliders.md", gliders)]),
        schema(Form::Table, &[("odd.md", odd)]),
        px4(&[("Wind.msg", WIND), ("None.msg", "uint64 timestamp\n"), ("Message.msg", "Wind[2] wind\n")]),
    ];
    for schema in &schemas {
        let starts = ["export interface ", "export type ", "export const "];
        let modules = emit_typescript(schema, typescript::Form::Source);
        let mut typescript = names_after(text(&modules, "demo.ts"), &starts);
        let python = python_names(text(&python::emit(schema, &NONE), "demo.py"));
        // Ignore maps from message names to types, which Python doesn't need.
        for map in ["Messages", "Requests", "Responses", "Notifications"] {
            typescript.remove(map);
        }
        assert_eq!(typescript, python);
        assert!(typescript.len() > 5, "{typescript:?}");
    }
    let names = python_names(text(&python::emit(&schemas[2], &NONE), "demo.py"));
    for name in ["None_", "Message", "Message2", "WindConstants", "WindKind"] {
        assert!(names.contains(name), "{name} in {names:?}");
    }
}

#[test]
fn exports_the_same_names_from_both_kinds_of_modules() {
    let page = "# Errors\n\n## Warnings (64-127)\n\n| Code | Abbreviation | Description |\n|---|---|---|\n| 66 | WINCH | Rope slack |\n";
    for schema in [px4(&[("Wind.msg", WIND)]), schema(Form::Table, &[("errors.md", page)])] {
        let modules = emit_typescript(&schema, typescript::Form::Compiled);
        let paths: Vec<&str> = modules.iter().map(|file| file.path.as_str()).collect();
        assert_eq!(
            paths,
            [
                "demo.cjs",
                "demo.d.cts",
                "demo.d.ts",
                "demo.js",
                "index.cjs",
                "index.d.cts",
                "index.d.ts",
                "index.js"
            ]
        );
        let values = |path: &str, starts: &[&str]| names_after(text(&modules, path), starts);
        let declared = values("demo.d.cts", &["export declare const ", "export declare function "]);
        assert!(declared.len() > 1, "{declared:?}");
        assert_eq!(values("demo.js", &["export const ", "export function "]), declared);
        assert_eq!(values("demo.cjs", &["exports."]), declared);
        has(text(&modules, "index.js"), "export * as demo from \"./demo.js\";");
        has(text(&modules, "index.cjs"), "exports.demo = require(\"./demo.cjs\");");
        has(text(&modules, "demo.d.ts"), "export * from \"./demo.cjs\";");
    }
}

#[test]
fn error_codes_are_integers_if_no_table_has_rows() {
    let page = "# Winch\n\n## Rope\n\n|Field|Required|Type|Description|\n|-|-|-|-|\n\
                |code|no|ErrorCode|A code|\n|codes|yes|ErrorList|Codes|\n";
    let empty = "# Codes\n\n## Warnings (64-127)\n\n| Code | Abbreviation | Description |\n|---|---|---|\n";
    let schema = schema(Form::Table, &[("winch.md", page), ("codes.md", empty)]);
    assert_eq!(schema.packages[0].error_tables.len(), 1);
    let typescript = emit_typescript(&schema, typescript::Form::Source);
    let python = python::emit(&schema, &NONE);
    let (typescript, python) = (text(&typescript, "demo.ts"), text(&python, "demo.py"));
    for line in ["\n  code?: number;\n", "\n  codes: number[];\n"] {
        has(typescript, line);
    }
    for line in ["\n    code: NotRequired[int]\n", "\n    codes: list[int]\n"] {
        has(python, line);
    }
    for module in [typescript, python] {
        assert!(!module.contains("ErrorCode"), "{module}");
    }
}

#[test]
fn flags_are_int_flags_only_if_all_values_are_positive() {
    let text_of_flags = |ty: &str| {
        let field = format!("{ty} FLAG_WET = 1\n{ty} FLAG_TORN = 4\n{ty} state # [@flags FLAG] State\n");
        let schema = px4(&[("Sail.msg", &field)]);
        text(&python::emit(&schema, &NONE), "demo.py").to_owned()
    };
    for ty in ["uint8", "uint64"] {
        has(&text_of_flags(ty), "class SailFlag(IntFlag):");
    }
    // Signed flags don't use `IntFlag`, which would turn -1 into the sum of all known flags.
    for ty in ["int8", "int64"] {
        has(&text_of_flags(ty), "class SailFlag(OpenIntEnum):");
    }
}

const GLIDER: &str = "# A glider\n\nuint8 MODE_SOAR=1 # Soaring\nuint8 MODE_GLIDE=1 # The same\nuint8 MODE_DIVE=2\n\n\
                      uint8 mode # [@enum MODE] What it does\n";

const TOW: &str = "uint8[2] mode # [@enum Glider.MODE] What both do\n";

/// Definitions, and their partial translation into Portuguese.
fn translated() -> (Schema, Translations) {
    let mut sources = SourceMap::default();
    let mut package = support::package("demo", Form::Msg(Dialect::Px4));
    for (path, text) in [("Glider.msg", GLIDER), ("Tow.msg", TOW)] {
        package.sources.push(sources.add(path, text.into()).expect("a text"));
    }
    let catalogue = "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n\n\
                     msgctxt \"demo/Glider.mode\"\nmsgid \"What it does\"\nmsgstr \"O que \\\"faz\\\"\u{202e}\"\n";
    let catalogue = sources.add("pt-BR.po", catalogue.into()).expect("a text");
    let (schema, _) = read(&sources, &[package]);
    let (translations, found) = translation::resolve(&sources, &schema, &[catalogue]);
    assert_eq!(translations.languages.len(), 1, "{found:?}");
    (schema, translations)
}

#[test]
fn creates_a_module_per_language_with_all_texts_in_english() {
    let (schema, translations) = translated();
    let source = typescript::emit(&schema, &translations, &typescript::Options::default());
    let paths: Vec<&str> = source.iter().map(|file| file.path.as_str()).collect();
    let labels =
        ["labels.ts", "labels/_enumerations.ts", "labels/_lookup.ts", "labels/en.ts", "labels/pt-BR.ts"];
    assert_eq!(paths, [&["demo.ts", "index.ts"], &labels[..]].concat());
    for line in [
        "{ tag: \"en\", name: \"English\", isRightToLeft: false },",
        "{ tag: \"pt-BR\", name: \"Português (Brasil)\", isRightToLeft: false },",
        "case \"pt-BR\":",
    ] {
        has(text(&source, "labels.ts"), line);
    }
    let python = python::emit(&schema, &translations);
    let paths: Vec<&str> = python.iter().map(|file| file.path.as_str()).collect();
    let labels = ["labels/__init__.py", "labels/_en.py", "labels/_enumerations.py", "labels/_pt_br.py"];
    assert_eq!(paths, [&["__init__.py", "_open_enum.py", "demo.py"], &labels[..], &["py.typed"]].concat());
    for (english, portuguese) in [
        (text(&source, "labels/en.ts"), text(&source, "labels/pt-BR.ts")),
        (text(&python, "labels/_en.py"), text(&python, "labels/_pt_br.py")),
    ] {
        for entry in [
            "\"demo/Glider\": \"A glider\",",
            "\"demo/Glider.mode\": \"What it does\",",
            "\"demo/Glider::MODE_GLIDE\": \"The same\",",
            "\"demo/Tow.mode\": \"What both do\",",
        ] {
            has(english, entry);
        }
        has(portuguese, r#""demo/Glider.mode": "O que \"faz\"\u202e","#);
        assert_eq!(portuguese.matches("\"demo/").count(), 1, "{portuguese}");
    }
}

#[test]
fn shares_labels_of_values_between_messages() {
    let (schema, translations) = translated();
    let source = typescript::emit(&schema, &translations, &typescript::Options::default());
    let values = text(&source, "labels/_enumerations.ts");
    has(
        values,
        "  [\n    [\"1\", \"demo/Glider::MODE_SOAR\"],\n    [\"2\", \"demo/Glider::MODE_DIVE\"],\n  ],\n];",
    );
    has(values, "  \"demo/Glider.mode\": 0,\n  \"demo/Tow.mode\": 0,\n};");
    let python = python::emit(&schema, &translations);
    let values = text(&python, "labels/_enumerations.py");
    has(
        values,
        "    {\n        1: \"demo/Glider::MODE_SOAR\",\n        2: \"demo/Glider::MODE_DIVE\",\n    },\n]",
    );
    has(values, "    \"demo/Glider.mode\": 0,\n    \"demo/Tow.mode\": 0,\n}");
}

#[test]
fn creates_label_modules_of_both_kinds_with_public_types() {
    let (schema, translations) = translated();
    let options = typescript::Options { form: typescript::Form::Compiled };
    let modules = typescript::emit(&schema, &translations, &options);
    for name in ["labels", "labels/en", "labels/pt-BR"] {
        let values =
            |ending: &str, starts: &[&str]| names_after(text(&modules, &format!("{name}.{ending}")), starts);
        let declared = values("d.cts", &["export declare const ", "export declare function "]);
        assert!(!declared.is_empty());
        assert_eq!(values("js", &["export const ", "export async function "]), declared);
        assert_eq!(values("cjs", &["exports."]), declared);
    }
    has(text(&modules, "labels/pt-BR.d.ts"), "export * from \"./pt-BR.cjs\";");
    assert!(modules.iter().any(|file| file.path == "labels/_lookup.cjs"));
    assert!(!modules.iter().any(|file| file.path.starts_with("labels/_") && file.path.contains(".d.")));
}

#[test]
fn reserves_the_module_name_of_the_labels() {
    let mut sources = SourceMap::default();
    let mut package = support::package("labels", Form::Msg(Dialect::Px4));
    package.sources.push(sources.add("Glider.msg", GLIDER.into()).expect("a text"));
    let (schema, _) = read(&sources, &[package]);
    let paths: Vec<String> = python::emit(&schema, &NONE).into_iter().map(|file| file.path).collect();
    assert_eq!(paths, ["__init__.py", "_open_enum.py", "labels_2.py", "py.typed"]);
}

#[test]
fn creates_unique_names_for_real_definitions() {
    let Some(folder) = support::shared("corpus/px4/main/msg") else { return };
    let mut sources = SourceMap::default();
    let mut package = support::package("px4", Form::Msg(Dialect::Px4));
    for path in support::files_below(&folder, &["msg"]) {
        let text = std::fs::read(&path).expect("a definition");
        package.sources.push(sources.add(path.display().to_string(), text).expect("a text"));
    }
    let (schema, _) = read(&sources, &[package]);
    let modules = emit_typescript(&schema, typescript::Form::Source);
    let module = text(&modules, "px4.ts");
    let declared = module.lines().filter(|line| line.starts_with("export interface ")).count();
    assert_eq!(declared, names_after(module, &["export interface "]).len());
    assert!(declared > 250, "{declared}");
    let python = python::emit(&schema, &NONE);
    let classes = text(&python, "px4.py").lines().filter(|line| line.starts_with("class ")).count();
    assert_eq!(classes, names_after(text(&python, "px4.py"), &["class "]).len());
}
