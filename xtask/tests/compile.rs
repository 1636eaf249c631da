//! Tests that generated code compiles without warnings under the lints of this workspace, and that its JSON and CDR
//! match the results of other tools. The definitions include conflicting names and the whole corpus.

mod conversions;

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value as Json;
use uavspec_test_definitions::shared;

/// A crate with generated code, in a folder that persists between runs.
struct Crate {
    folder: PathBuf,
}

impl Crate {
    fn new(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = fs::remove_dir_all(&folder);
        let repository = repository();
        let workspace = fs::read_to_string(repository.join("Cargo.toml")).expect("the workspace");
        // Copy the lints of this workspace.
        let lints = workspace
            .split("[workspace.lints")
            .skip(1)
            .map(|table| table.split("\n[profile").next().unwrap_or(table));
        let lints: String = lints.map(|table| format!("[lints{table}")).collect();
        let runtime = repository.join("generated/runtime");
        let manifest = format!(
            "[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\nuavspec-runtime = \
             {{ path = \"{}\" }}\n\n[dev-dependencies]\nproptest = {{ version = \"1\", default-features = false }}\n\
             serde = \"1\"\nserde_json = {{ version = \"1\", features = [\"float_roundtrip\"] }}\n\n[workspace]\n\n{lints}",
            runtime.display()
        );
        let result = Self { folder };
        result.write("Cargo.toml", &manifest);
        fs::copy(repository.join("Cargo.lock"), result.folder.join("Cargo.lock")).expect("a lock file");
        result
    }

    fn write(&self, path: &str, text: &str) {
        let path = self.folder.join(path);
        fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        fs::write(path, text).expect("a file");
    }

    fn generate(&self, packages: &str) {
        let config = format!(
            "[output]\nrust = {{ path = \"src\", root = \"lib.rs\" }}\njson_schema = \"schemas\"\n{packages}"
        );
        self.write("uavspec.toml", &config);
        uavspec_codegen::generate(self.folder.join("uavspec.toml"))
            .unwrap_or_else(|failure| panic!("{failure}"));
    }

    fn cargo(&self, arguments: &[&str]) -> String {
        let output = Command::new(env!("CARGO"))
            .args(arguments)
            .current_dir(&self.folder)
            .env("CARGO_TARGET_DIR", Path::new(env!("CARGO_TARGET_TMPDIR")).join(".."))
            .env("CARGO_NET_OFFLINE", "true")
            .output()
            .expect("cargo runs");
        let errors = String::from_utf8_lossy(&output.stderr);
        let is_clean = output.status.success() && !errors.contains("warning:") && !errors.contains("error:");
        assert!(is_clean, "cargo {arguments:?}\n{errors}");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// Checks the crate without features and with all features of the runtime.
    fn compiles(&self) {
        self.cargo(&["clippy"]);
        self.cargo(&["clippy", "--features", FEATURES]);
        self.cargo(&["doc", "--no-deps", "--features", FEATURES]);
    }
}

const FEATURES: &str = "uavspec-runtime/defmt,uavspec-runtime/proptest,uavspec-runtime/schemars,\
    uavspec-runtime/serde,uavspec-runtime/views";

fn repository() -> PathBuf {
    fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).expect("the repository")
}

#[test]
fn messages_of_fixed_size_require_no_allocator() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bare-metal");
    let package = Crate { folder };
    let generated = repository().join("generated");
    let manifest = format!(
        "[package]\nname = \"bare-metal\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[lib]\npath = \"lib.rs\"\n\
         crate-type = [\"staticlib\"]\n\n[dependencies]\nuavspec-types = {{ path = {generated:?}, default-features = false, features = [\"views\"] }}\n\
         uavspec-runtime = {{ path = {:?}, default-features = false }}\n\n[profile.dev]\npanic = \"abort\"\n\n[workspace]\n",
        generated.join("runtime")
    );
    package.write("Cargo.toml", &manifest);
    package.write("lib.rs", include_str!("compile/bare_metal.rs"));
    fs::copy(repository().join("Cargo.lock"), package.folder.join("Cargo.lock")).expect("a lock file");
    package.cargo(&["build"]);
}

const PX4: &str = "\n[[package]]\nname = \"px4\"\ndialect = \"px4\"\n";

/// A crate generated from definitions whose names are keywords, or names of items in generated code.
fn conflicting_names(name: &str) -> Crate {
    let package = Crate::new(name);
    package.write(
        "a/Words.msg",
        "uint8 type # [@enum SELF]\nuint8 self\nuint8 super\nuint8 crate\nuint8 gen\nuint8 Abc\nuint8 aBC\nuint8 fn\n\
         uint8 SELF_SELF = 1\nuint8 SELF_super = 2\nuint8 SELF_3D = 3\nuint8 SELF_ALSO_1 = 1\nuint8 self = 4\n",
    );
    package.write(
        "a/Mode.msg",
        "uint8 mode # [@enum MODE]\nuint8 MODE_A = 0\nuint8 NAME = 1\nuint8 VERSION = 2\nuint8 SIZE = 3\n",
    );
    package.write("a/Option.msg", "Some some\nString string\nVec[2] vec\nDefault[40] default\n");
    for name in [
        "Some",
        "None",
        "String",
        "Vec",
        "Default",
        "Self",
        "Srv",
        "Box",
        "Result",
        "Message",
        "Definition",
        "Text",
        "Core",
        "UavspecRuntime",
        "Mod",
        "Lib",
        "Con_",
    ] {
        package.write(&format!("a/{name}.msg"), "uint64 timestamp\n");
    }
    // Enums that have the same names as imports, or as types in the runtime's macros.
    package.write(
        "a/Enums.msg",
        "uint8 a # [@enum OPTION]\nuint8 OPTION_A = 0\nuint8 b # [@enum SOME]\nuint8 SOME_A = 0\n\
         uint8 c # [@enum DEFINITION]\nuint8 DEFINITION_A = 0\nuint8 d # [@enum CONSTRAINT]\nuint8 CONSTRAINT_A = 0\n\
         Definition definition\nText text\nUavspecRuntime runtime\nbool yes\n",
    );
    package.write("b/msg/String.msg", "string text\n");
    package.write("b/msg/Vec.msg", "string[] texts [\"x\"]\n");
    package.write("b/msg/Strings.msg", "string text\nstring[] texts [\"x\"]\nString string\nVec[] vec\n");
    package.write("a/lower_case.msg", "Option option\nchar[7] text\nchar letter\nchar[300] long\n");
    package.write("a/Empty.msg", "");
    package.write(
        "a/Masks.msg",
        "int8 bits # [@flags BIT]\nint8 BIT_A = 0\nint8 BIT_B = 3\nint8 BIT_C = 6\nuint64[50] wide # [@flags WIDE]\n\
         uint64 WIDE_TOP = 9223372036854775808\nuint64 WIDE_NONE = 0\nint32[3] modes # [@enum KIND]\nint32 KIND_A = -1\n\
         float32 PI = 3.14159\nfloat64 NOT = nan\nfloat32 LESS = -inf\nbool YES = True\n",
    );
    package.write("a/Do.srv", "Option option\nuint8 mode # [@enum MODE]\nuint8 MODE_A = 0\n---\nuint8 mode # [@enum MODE]\nuint8 MODE_B = 0\n");
    package.write(
        "b/msg/Defaults.msg",
        "int32 a 42\nfloat64 b -1.5\nstring c \"x \\\"y\\\" # z\"\nint32[3] d [1, -2, 3]\nstring[] e [\"a\", 'b']\nbool f true\n\
         string<=5[<=3] g\nwstring h 'w'\nbyte[70] i\nfloat32[] j [1, 2.5]\nstring NAME=\"[`link`] *x*\"\n",
    );
    package.write("b/action/Go.action", "int32 a 1\n---\nb_msgs/Defaults b\n---\nDefaults[] c\n");
    package.write(
        "b/msg/Prose.msg",
        "# Title with [brackets], `code`, <b>html</b> and http://example.org/a_b.\n#\n#  - a list\n#    1. nested\n# # heading\n\
         #\n# ```\n# fence\n\n# A | group [x]\nuint8 a # [link](http://x.org) | <script> \\ `\nuint8 b # \n",
    );
    package.generate(&format!(
        "{PX4}include = [\"a/*\"]\n\n[[package]]\nname = \"b_msgs\"\ndialect = \"ros2\"\ninclude = [\"b/**/*\"]\n\n\
         [[package]]\nname = \"type\"\ndialect = \"px4\"\ninclude = [\"a/Empty.msg\"]\n\n[[package]]\nname = \"core\"\ndialect = \"px4\"\ninclude = [\"a/Some.msg\"]\n\n\
         [[package]]\nname = \"uavspec_runtime\"\ndialect = \"px4\"\ninclude = [\"a/Empty.msg\"]\n\n\
         [[package]]\nname = \"lib\"\ndialect = \"px4\"\ninclude = [\"a/Empty.msg\"]\n\n\
         [[package]]\nname = \"mod\"\ndialect = \"px4\"\ninclude = [\"a/Mod.msg\"]\n"
    ));
    package
}

#[test]
fn conflicting_names_compile() {
    conflicting_names("fighting-names").cargo(&["check"]);
}

#[test]
#[ignore = "slow"]
fn conflicting_names_compile_with_any_features() {
    conflicting_names("fighting-names-linted").compiles();
}

#[test]
#[ignore = "slow"]
fn the_whole_corpus_compiles() {
    let Some(corpus) = shared("corpus") else { return };
    let corpus = fs::canonicalize(corpus).expect("a path");
    let package = Crate::new("whole-corpus");
    let mut packages = String::new();
    for (name, release) in [("px4", "main"), ("px4_16", "1.16"), ("px4_15", "1.15")] {
        let include = format!("{}/px4/{release}/**/*", corpus.display());
        let _ = write!(
            packages,
            "\n[[package]]\nname = \"{name}\"\ndialect = \"px4\"\ninclude = [{include:?}]\n"
        );
    }
    for name in ["std_msgs", "builtin_interfaces", "geometry_msgs", "sensor_msgs", "diagnostic_msgs"] {
        let include = format!("{}/ros2/{name}/**/*", corpus.display());
        let _ = write!(
            packages,
            "\n[[package]]\nname = \"{name}\"\ndialect = \"ros2\"\ninclude = [{include:?}]\n"
        );
    }
    package.generate(&packages);
    package.compiles();
    let Some(cases) = oracle_cases() else { return };
    let mut types: Vec<&str> = cases.iter().map(|case| text(case, "type")).collect();
    types.sort_unstable();
    types.dedup();
    let program = Program::build(&package, &types);
    instances_are_those_of_other_tools(&program, &cases);
    schemas_are_the_published_ones(&program, &types);
    program.run("strategies", "");
}

/// The JSON instances of the CDR oracle.
fn oracle_cases() -> Option<Vec<Json>> {
    let mut cases = Vec::new();
    for file in ["px4-main", "ros2"] {
        let text = fs::read_to_string(shared(&format!("oracle/cdr/{file}.json"))?).expect("an oracle");
        cases.extend(serde_json::from_str::<Vec<Json>>(&text).expect("cases"));
    }
    Some(cases)
}

fn text<'j>(value: &'j Json, member: &str) -> &'j str {
    value[member].as_str().expect("a text")
}

/// The program `compile/corpus.rs` with all types.
struct Program<'c> {
    package: &'c Crate,
    path: PathBuf,
}

impl<'c> Program<'c> {
    fn build(package: &'c Crate, types: &[&str]) -> Self {
        let rows: String = types.iter().fold(String::new(), |mut rows, name| {
            let path = name.replace("px4_msgs/", "px4/").replace("/msg/", "::");
            let row = if name.starts_with("px4_msgs") { "fixed_row" } else { "row" };
            let _ = writeln!(rows, "        {row}::<whole_corpus::{path}>({name:?}),");
            rows
        });
        let program = include_str!("compile/corpus.rs");
        let program = format!("{program}\nfn rows() -> Vec<Row> {{\n    vec![\n{rows}    ]\n}}\n");
        package.write("examples/corpus.rs", &program);
        // Exclude defmt, which would require its linker script.
        let features = FEATURES.trim_start_matches("uavspec-runtime/defmt,");
        package.cargo(&["build", "--features", features, "--example", "corpus"]);
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../debug/examples/corpus");
        Self { package, path }
    }

    fn run(&self, task: &str, input: &str) -> String {
        self.package.write("input.txt", input);
        let output = Command::new(&self.path)
            .arg(task)
            .stdin(fs::File::open(self.package.folder.join("input.txt")).expect("the input"))
            .output()
            .expect("the program runs");
        assert!(output.status.success(), "{task}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("UTF-8")
    }
}

/// Reads and writes each instance of the CDR oracle, as JSON and as CDR in both byte orders. PX4 messages are also
/// tested as views and in their memory layout, for which there is no oracle.
fn instances_are_those_of_other_tools(program: &Program<'_>, cases: &[Json]) {
    let input: String = cases.iter().fold(String::new(), |mut input, case| {
        let [name, little, big] = ["type", "cdr_le_hex", "cdr_be_hex"].map(|member| text(case, member));
        let _ = writeln!(input, "{name} {little} {big} {}", case["json"]);
        input
    });
    let written = program.run("convert", &input);
    assert_eq!(written.lines().count(), cases.len());
    for (case, line) in cases.iter().zip(written.lines()) {
        let found: Json = serde_json::from_str(line).expect("JSON");
        assert!(same(&found, &case["json"]), "{} {}\n{found}\n{}", case["type"], case["case"], case["json"]);
    }
}

/// Compares the schemas that schemars derives with the published schemas, keyword by keyword.
fn schemas_are_the_published_ones(program: &Program<'_>, types: &[&str]) {
    let written = program.run("schemas", "");
    assert_eq!(written.lines().count(), types.len());
    for line in written.lines() {
        let (name, schema) = line.split_once(' ').expect("two words");
        let found: Json = serde_json::from_str(schema).expect("JSON");
        let path = name.replace("px4_msgs/", "px4/").replace("/msg/", "/");
        let path = program.package.folder.join(format!("schemas/{path}.schema.json"));
        let published = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
        let published: Json = serde_json::from_str(&published).expect("JSON");
        assert_eq!(assertions(&found), assertions(&published), "{name}");
    }
}

/// Removes descriptive keywords. Replaces references with message names, and converts floats that have integer values
/// to integers.
fn assertions(schema: &Json) -> Json {
    match schema {
        Json::Object(members) => members
            .iter()
            .filter(|(keyword, value)| {
                let describes = matches!(
                    keyword.as_str(),
                    "$schema" | "$id" | "$comment" | "$defs" | "title" | "description" | "default"
                );
                // Keep a field that has the name of a keyword. Its value is a schema.
                !describes || keyword.as_str() != "$defs" && value.is_object()
            })
            .map(|(keyword, value)| match value {
                Json::String(address) if keyword == "$ref" => {
                    let name = address.rsplit('/').next().unwrap_or_default();
                    (keyword.clone(), name.trim_end_matches(".schema.json").into())
                }
                value => (keyword.clone(), assertions(value)),
            })
            .collect(),
        Json::Array(parts) => parts.iter().map(assertions).collect(),
        Json::Number(number) => match number.as_f64() {
            #[allow(clippy::cast_possible_truncation)] // an integer below 2^53
            Some(value) if number.is_f64() && value % 1.0 == 0.0 && value.abs() < 9e15 => {
                (value as i64).into()
            }
            _ => schema.clone(),
        },
        other => other.clone(),
    }
}

/// True if the values are equal. Floats that round to the same 32-bit float are equal.
fn same(left: &Json, right: &Json) -> bool {
    match (left, right) {
        (Json::Array(left), Json::Array(right)) => {
            left.len() == right.len() && left.iter().zip(right).all(|(l, r)| same(l, r))
        }
        (Json::Object(left), Json::Object(right)) => {
            left.keys().eq(right.keys()) && left.iter().all(|(key, value)| same(value, &right[key]))
        }
        (Json::Number(l), Json::Number(r)) if l.is_f64() || r.is_f64() => {
            let (l, r) = (l.as_f64().unwrap_or(f64::NAN), r.as_f64().unwrap_or(f64::NAN));
            #[allow(clippy::cast_possible_truncation)]
            let as_f32 = (l as f32).to_bits() == (r as f32).to_bits();
            l.to_bits() == r.to_bits() || as_f32
        }
        _ => left == right,
    }
}
