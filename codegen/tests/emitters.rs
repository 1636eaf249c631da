//! Tests of the list of emitters.

use std::fs;
use std::path::Path;

use uavspec_codegen::emit::{EMITTERS, Emitter};
use uavspec_codegen::generate;

/// The error message for a configuration with this `output` table.
fn error_of(output: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let config = folder.path().join("uavspec.toml");
    let package = "[[package]]\nname = \"demo\"\ndialect = \"px4\"\ninclude = [\"*.msg\"]\n";
    fs::write(&config, format!("{package}[output]\n{output}\n")).expect("a file");
    fs::write(folder.path().join("Wind.msg"), "uint64 timestamp\n").expect("a file");
    generate(&config).expect_err(output).to_string()
}

/// The rows in the guide for an emitter and its options.
fn documentation(emitter: &Emitter) -> Vec<String> {
    let mut rows = vec![format!("| `output.{}` | {} |", emitter.name, emitter.help)];
    for (key, meaning) in emitter.options {
        rows.push(format!("| `output.{}.{key}` | {meaning} |", emitter.name));
    }
    rows
}

#[test]
fn the_guide_documents_each_output() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../xtask/site/guide/your-build.md");
    let page = fs::read_to_string(path).expect("the page");
    let found: Vec<&str> = page.lines().filter(|line| line.starts_with("| `output.")).collect();
    let expected: Vec<String> = EMITTERS.iter().flat_map(documentation).collect();
    assert!(found == expected, "expected in xtask/site/guide/your-build.md:\n{}", expected.join("\n"));
}

#[test]
fn an_output_accepts_only_the_options_of_its_emitter() {
    for emitter in EMITTERS {
        let message = error_of(&format!("{} = {{ path = \"out\", bogus = 1 }}", emitter.name));
        let expected = match emitter.options {
            [] => "unknown field `bogus`, there are no fields".to_owned(),
            [(key, _)] => format!("unknown field `bogus`, expected `{key}`"),
            [(first, _), (second, _)] => format!("unknown field `bogus`, expected `{first}` or `{second}`"),
            options => {
                let keys: Vec<String> = options.iter().map(|(key, _)| format!("`{key}`")).collect();
                format!("unknown field `bogus`, expected one of {}", keys.join(", "))
            }
        };
        assert!(message.contains(&expected), "{}: {message}", emitter.name);
    }
}

#[test]
fn errors_in_outputs_are_shown_with_their_location() {
    for (output, expected) in [
        (
            "ruts = \"out\"",
            ["uavspec.toml:6:1", "unknown field `ruts`, expected one of `rust`, `json_schema`"],
        ),
        (
            "docs = 7",
            [
                "uavspec.toml:6:8",
                "expected a path, or a table with the keys `path`, `title`, `rules`, `contents`",
            ],
        ),
        ("docs = {}", ["uavspec.toml:6:8", "expected a path, or a table with the keys `path`, `title`"]),
        (
            "python = { path = 1 }",
            ["uavspec.toml:6:10", "expected a path, or a table with the keys `path`\n"],
        ),
        ("typescript = { path = \"o\", form = \"c\" }", ["uavspec.toml:6:14", "unknown variant `c`"]),
    ] {
        let message = error_of(output);
        assert!(expected.iter().all(|expected| message.contains(expected)), "{output}: {message}");
    }
}

/// Documentation comments start with `//` as well.
#[test]
fn constants_may_contain_slashes_before_any_character() {
    let folder = tempfile::tempdir().expect("a folder");
    let config = folder.path().join("uavspec.toml");
    let text = "[[package]]\nname = \"demo\"\ndialect = \"ros2\"\ninclude = [\"*.msg\"]\n[output]\nrust = { path = \"out\" }\n";
    fs::write(&config, text).expect("a file");
    let definition = "string A='//\u{e9}'\nstring B='//'\nstring C='https://example.org/\u{e9}'\n";
    fs::write(folder.path().join("Wind.msg"), definition).expect("a file");
    generate(&config).expect("output");
    let files = walkdir::WalkDir::new(folder.path().join("out"));
    let files = files.into_iter().filter_map(|entry| fs::read_to_string(entry.ok()?.path()).ok());
    let code: String = files.collect();
    for constant in ["\"//\u{e9}\"", "\"//\"", "\"https://example.org/\u{e9}\""] {
        assert!(code.contains(constant), "{constant} is missing:\n{code}");
    }
}
