//! Tests that modules generated from arbitrary definitions pass type checkers. The declared types must accept exactly
//! the valid values, as far as types can express this.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use uavspec_test_definitions::shared;

use super::labels;
use super::tools::{node_tool, python_with_tools, repository, run, write, xtask};

/// Definitions whose names, texts and values have a special meaning in one of the languages.
const ODD: [(&str, &str); 3] = [
    (
        "None.msg",
        "# Ends here: */ or here: \"\"\" and has a tag: @param {x} y, a backslash: \\ and a quote: \"\n\
         uint8 KIND_None=0 # Nothing \"at all\"\nuint8 KIND_type=1 # */\nuint8 KIND_3D=2\nuint64 GREATEST=18446744073709551615 \
         # Beyond 2^53\nint64 LEAST=-9223372036854775808\nfloat32 HALF=0.5\nuint8 class=3\n\
         uint64 timestamp # [us] Time since system start\nuint8 int # [@enum KIND] Hides a type\nuint8 str # \"\nuint8 list # \\\n\
         float32[2] float # */\nuint8 class_ # Nearly a keyword\nuint8 type # Keyword\nuint8 lambda # Keyword\nuint8 import # Keyword\n\
         Union[3] NotRequired # Called like what typing has\nchar[8] Literal # Text\n",
    ),
    ("Union.msg", "# Holds nothing but the time\nuint64 timestamp # [us] Time since system start\n"),
    (
        "Message.msg",
        "# Called like the union of all\nint8 MASK_LOW=1\nint8 MASK_HIGH=2\nuint64 timestamp # [us] Time since system start\n\
         uint16 mask # [@flags MASK] What is set\nbool def # Keyword\n",
    ),
];

/// A Python program that uses the types of enums and flags. Type checkers report an unused `type: ignore`.
const USES_OF_ENUMS: &str = r#"import json
from typing import Union, cast, get_type_hints

from translated.gliders import Glider, GliderMark, GliderMode, Tow

glider: Glider = {"timestamp": 1, "mode": GliderMode.DIVE, "marks": GliderMark.FIRST | 8, "import": 0}
numbers = [1, 77]
tow: Tow = {"timestamp": 1, "mode": numbers}
wrong: Tow = {"timestamp": 1, "mode": ["dive"]}  # type: ignore

received = cast(Glider, json.loads(json.dumps(glider)))
assert received == glider and type(received["mode"]) is int
assert received["mode"] == GliderMode.DIVE and GliderMark(received["marks"]) & GliderMark.FIRST
assert [GliderMode(mode).name for mode in tow["mode"]] == ["SOAR", "UNKNOWN_77"]
assert get_type_hints(Glider)["marks"] == Union[GliderMark, int]
assert get_type_hints(Tow)["mode"] == list[Union[GliderMode, int]]
"#;

/// Folders with definitions: name, dialect and path.
fn definitions(own: &Path) -> Vec<(String, &'static str, PathBuf)> {
    for (name, text) in ODD {
        write(&own.join(name), text);
    }
    let mut found = vec![("odd".to_owned(), "px4", own.to_path_buf())];
    let fixtures = repository().join("codegen/schema/tests/fixtures/ok");
    for (name, dialect) in [
        ("action", "ros2"),
        ("service", "ros2"),
        ("empty", "px4"),
        ("px4-message", "px4"),
        ("type-tables", "table"),
        ("type-tables-names", "table"),
        ("type-tables-pages", "table"),
    ] {
        found.push((name.replace('-', "_"), dialect, fixtures.join(name)));
    }
    if let Some(corpus) = shared("corpus") {
        for (name, dialect, path) in
            [("px4_main", "px4", "px4/main"), ("px4_old", "px4", "px4/1.15"), ("ros", "ros2", "ros2")]
        {
            found.push((name.to_owned(), dialect, corpus.join(path)));
        }
    }
    found
}

/// Emits the modules for each set of definitions into a folder named after the set.
fn emit(kind: &str, into: &Path, own: &Path) -> usize {
    let definitions = definitions(own);
    for (name, dialect, path) in &definitions {
        let out = into.join("out");
        let (input, out_text) = (path.display().to_string(), out.display().to_string());
        xtask(&[
            "codegen",
            "--package",
            name,
            "--dialect",
            dialect,
            "--input",
            &input,
            "--out",
            &out_text,
            "--emit",
            kind,
        ]);
        fs::rename(out.join(kind), into.join(name)).expect("a separate folder");
    }
    let translated = own.with_file_name("translated");
    labels::emit(&translated, &format!("{kind} = \"out\""));
    fs::rename(translated.join("out"), into.join("translated")).expect("a separate folder");
    definitions.len() + 1
}

fn files(folder: &Path, ending: &str) -> Vec<String> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path.display().to_string().ends_with(ending) {
            found.push(path.display().to_string());
        }
    }
    found.sort();
    found
}

/// Copies the files with this ending to another folder.
fn copy(from: &Path, ending: &str, to: &Path) {
    for path in files(from, ending) {
        let below = Path::new(&path).strip_prefix(from).expect("a path below the folder");
        write(&to.join(below), &fs::read_to_string(&path).expect("a module"));
    }
}

/// Checks all files with the TypeScript compiler.
fn check_typescript(folder: &Path) {
    let compiler = node_tool("typescript/bin/tsc");
    let mut arguments =
        vec![compiler.as_str(), "--noEmit", "--strict", "--noUncheckedIndexedAccess", "--noUnusedLocals"];
    arguments.extend(["--exactOptionalPropertyTypes", "--target", "es2022", "--module", "nodenext"]);
    let files = files(folder, ".ts");
    arguments.extend(files.iter().map(String::as_str));
    run("node", &arguments, folder);
}

#[test]
#[ignore = "requires Node, npm and the network"]
fn typescript_of_any_definitions_type_checks() {
    let folder = tempfile::tempdir().expect("a folder");
    let into = folder.path().join("typescript");
    let count = emit("typescript", &into, &folder.path().join("odd"));
    assert!(files(&into, ".ts").len() >= 2 * count);
    check_typescript(&into);
}

/// Checks all modules below a folder with both type checkers, finds names that hide built-in names, and evaluates all
/// declarations.
pub(super) fn check_python(folder: &Path) {
    run(
        python_with_tools(),
        &["-m", "ruff", "check", "--isolated", "--no-cache", "--select", "A", "."],
        folder,
    );
    run(python_with_tools(), &["-m", "mypy", "--strict", "."], folder);
    run("node", &[&node_tool("pyright/index.js"), "--warnings", "."], folder);
    let script = repository().join("xtask/tests/packages/import_all.py").display().to_string();
    let code = "import sys; sys.path.insert(0, ''); exec(open(sys.argv[1]).read())";
    let resolved = run(python_with_tools(), &["-c", code, &script], folder);
    assert!(resolved.lines().count() > 30, "{resolved}");
}

#[test]
#[ignore = "requires Python, Node, npm and the network"]
fn python_of_any_definitions_type_checks_and_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let into = folder.path().join("python");
    emit("python", &into, &folder.path().join("odd"));
    write(&into.join("uses_of_enums.py"), USES_OF_ENUMS);
    check_python(&into);
    let odd = "from odd.odd import Message2, MessageMask, None_Kind, None_Constants\n\
               kinds = [None_Kind.NONE, None_Kind(1), None_Kind(77)]\n\
               print(*(kind.name for kind in kinds), int(kinds[2]), None_Constants.GREATEST, MessageMask(5))\n";
    let printed = run(python_with_tools(), &["-c", odd], &into);
    assert_eq!(printed, "NONE TYPE UNKNOWN_77 77 18446744073709551615 5\n");
}

/// A case of the vectors.
struct Case {
    /// The name of the type in both languages.
    ty: [String; 2],
    json: Value,
    /// `None` if types can't express it.
    is_accepted: Option<bool>,
    has_further_fields: bool,
}

/// The valid vectors of every message and type, and the invalid vectors that types can detect.
fn cases() -> Vec<Case> {
    let folder = repository().join("generated/vectors");
    let mut cases = Vec::new();
    for package in ["flockwave", "px4"] {
        for path in files(&folder.join(package), ".vectors.json") {
            let text = fs::read_to_string(&path).expect("vectors");
            let file: Value = serde_json::from_str(&text).expect("JSON");
            let name = file["type"].as_str().and_then(|ty| ty.split_once('/')).expect("a type").1;
            let ty = type_names(package, name);
            for case in file["cases"].as_array().expect("cases") {
                let Some(json) = case.get("json") else { continue };
                let id = case["id"].as_str().expect("an id");
                let ends = |endings: &[&str]| endings.iter().any(|ending| id.ends_with(ending));
                let is_accepted = match case["valid"].as_bool() {
                    Some(true) => Some(true),
                    _ if ends(&["-absent", "-missing", "-boolean"]) => Some(false),
                    _ => None,
                };
                let has_further_fields = ends(&["further-field"]);
                cases.push(Case { ty: ty.clone(), json: json.clone(), is_accepted, has_further_fields });
            }
        }
    }
    cases
}

/// The name of a type in TypeScript and in Python.
fn type_names(package: &str, name: &str) -> [String; 2] {
    if name == "ErrorList" {
        return ["flockwave.ErrorCode[]".to_owned(), "list[flockwave.ErrorCode | int]".to_owned()];
    }
    if name == "ErrorCode" {
        return ["flockwave.ErrorCode".to_owned(), "flockwave.ErrorCode | int".to_owned()];
    }
    let Some((message, direction)) = name.split_once('.') else {
        let same = format!("{package}.{name}");
        return [same.clone(), same];
    };
    let title = |word: &str| word[..1].to_uppercase() + &word[1..].to_lowercase();
    let direction = title(direction);
    let pascal: String = message.split(['-', '/']).map(title).collect();
    [format!("{package}.{direction}s[\"{message}\"]"), format!("{package}.{pascal}{direction}")]
}

#[test]
#[ignore = "requires Node, npm and the network"]
fn typescript_types_accept_valid_values() {
    let folder = tempfile::tempdir().expect("a folder");
    let generated = repository().join("generated/typescript");
    copy(&generated, ".ts", folder.path());
    let cases = cases();
    // With a type parameter for the value, TypeScript allows further fields.
    let mut text = "import type { flockwave, px4 } from \"./index.js\";\n\
                    declare function is<T>(): <V extends T>(value: V) => void;\n"
        .to_owned();
    for case in &cases {
        let line = format!("is<{}>()({});\n", case.ty[0], case.json);
        match case.is_accepted {
            Some(true) => text.push_str(&line),
            Some(false) => text.extend(["// @ts-expect-error\n", &line]),
            None => {}
        }
    }
    let count = |accepted| cases.iter().filter(|case| case.is_accepted == Some(accepted)).count();
    assert!(count(true) > 2_000 && count(false) > 1_000, "{} and {}", count(true), count(false));
    write(&folder.path().join("values.ts"), &text);
    check_typescript(folder.path());
}

#[test]
#[ignore = "requires Python and the network"]
fn python_types_accept_valid_values() {
    let folder = tempfile::tempdir().expect("a folder");
    let package = folder.path().join("uavspec");
    copy(&repository().join("generated/python"), ".py", &package);
    let mut text = "from uavspec import flockwave, px4\n\n".to_owned();
    let mut counts = [0, 0];
    // Further fields are valid in JSON, but type checkers report them.
    for (index, case) in cases().iter().filter(|case| !case.has_further_fields).enumerate() {
        let Some(is_accepted) = case.is_accepted else { continue };
        // Skip these cases, because a `bool` is an `int` in Python.
        if !is_accepted && contains_boolean(&case.json) {
            continue;
        }
        let ignored = if is_accepted { "" } else { "  # type: ignore" };
        let line = format!("value_{index}: {} = {}{ignored}\n", case.ty[1], literal(&case.json));
        text.push_str(&line);
        counts[usize::from(is_accepted)] += 1;
    }
    assert!(counts[0] > 200 && counts[1] > 2_000, "numbers of invalid and valid cases: {counts:?}");
    write(&folder.path().join("values.py"), &text);
    run(python_with_tools(), &["-m", "mypy", "--strict", "values.py"], folder.path());
}

fn contains_boolean(json: &Value) -> bool {
    match json {
        Value::Bool(_) => true,
        Value::Array(elements) => elements.iter().any(contains_boolean),
        Value::Object(members) => members.values().any(contains_boolean),
        _ => false,
    }
}

/// A value in Python syntax.
fn literal(json: &Value) -> String {
    match json {
        Value::Null => "None".to_owned(),
        Value::Bool(true) => "True".to_owned(),
        Value::Bool(false) => "False".to_owned(),
        Value::Number(_) | Value::String(_) => json.to_string(),
        Value::Array(elements) => {
            format!("[{}]", elements.iter().map(literal).collect::<Vec<_>>().join(", "))
        }
        Value::Object(members) => {
            let members = members
                .iter()
                .map(|(key, value)| format!("{}: {}", Value::from(key.as_str()), literal(value)));
            format!("{{{}}}", members.collect::<Vec<_>>().join(", "))
        }
    }
}
