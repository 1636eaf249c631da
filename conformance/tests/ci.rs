//! Tests of the files for CI systems. They run the examples of the guide, but without the CI systems.

mod expression;
mod github;
mod gitlab;
mod pre_commit;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use saphyr::{LoadableYamlNode as _, Scalar, Yaml};
use serde_json::Value;
use tempfile::TempDir;
use uavspec_test_support::{files_of_guide, padded, write};

const CONFIG: &str = "[output]\njson_schema = \"schemas\"\n\n[[package]]\nname = \"demo\"\ndialect = \"px4\"\n\
                      include = [\"msg/*.msg\"]\n";

const WIND: &str = "# Wind over ground\n\nuint64 timestamp  # [us] Time since system start\nfloat32 speed     # \
                    [m/s] Speed\n";

/// A message that contains another one, and has a field without a unit.
const GUST: &str = "# Gust\n\nuint64 timestamp  # [us] Time since system start\nWind peak         # Strongest wind\n\
                    float32 duration  # Duration\n";

/// A message that conforms, and one that lacks a member.
const MESSAGE: &str =
    r#"{"timestamp": 1, "name": "wind", "arming_check_id": 1, "mode_id": 1, "mode_executor_id": 1}"#;
const BAD_MESSAGE: &str = r#"{"timestamp": 1, "name": "wind", "mode_id": 1, "mode_executor_id": 1}"#;

/// A Git repository.
struct Project {
    folder: TempDir,
    /// The first commit.
    base: String,
}

impl Project {
    /// A repository without findings.
    fn clean() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path(), "uavspec.toml", CONFIG);
        write(folder.path(), "msg/Wind.msg", WIND);
        write(folder.path(), "logs/flight.jsonl", capture(MESSAGE));
        git(folder.path(), &["init", "--quiet", "--initial-branch", "main"]);
        commit(folder.path());
        let base = git(folder.path(), &["rev-parse", "HEAD"]);
        Self { folder, base }
    }

    /// A repository whose last commit adds four problems: a breaking change, a lint finding, a capture that violates a
    /// rule, and a truncated log.
    fn with_findings() -> Self {
        let project = Self::clean();
        let folder = project.path();
        write(folder, "msg/Wind.msg", WIND.replace("float32 speed ", "float64 speed "));
        write(folder, "msg/Gust.msg", GUST);
        write(folder, "logs/bad flight.jsonl", capture(BAD_MESSAGE));
        let mut log = padded(3);
        log.truncate(log.len() - 3);
        write(folder, "logs/cut.ulg", log);
        commit(folder);
        project
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// A line of a rosbridge log.
fn capture(message: &str) -> String {
    format!("{{\"op\": \"publish\", \"topic\": \"/fmu/in/unregister_ext_component\", \"msg\": {message}}}\n")
}

/// Runs Git, and returns its output.
fn git(folder: &Path, arguments: &[&str]) -> String {
    let identity =
        ["-c", "user.name=Tester", "-c", "user.email=tester@example.org", "-c", "commit.gpgsign=false"];
    let output = Command::new("git").arg("-C").arg(folder).args(identity).args(arguments).output();
    let output = output.expect("this test requires git");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8").trim().to_owned()
}

fn commit(folder: &Path) {
    git(folder, &["add", "."]);
    git(folder, &["commit", "--quiet", "--message", "Change"]);
}

fn repository() -> PathBuf {
    fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).expect("the repository")
}

/// A value of `PATH` that contains the program of this build.
fn path_with_uavspec() -> String {
    let program = Path::new(env!("CARGO_BIN_EXE_uavspec"));
    let folder = program.parent().expect("a folder").display();
    format!("{folder}:{}", std::env::var("PATH").expect("a path"))
}

/// The text of a file that the guide's chapter about CI contains.
fn example(path: &str) -> String {
    let files = files_of_guide("ci.md");
    let found = files.into_iter().find(|(name, _)| name == path);
    found.unwrap_or_else(|| panic!("the chapter shows no {path}")).1
}

/// A YAML document as JSON.
fn yaml(text: &str) -> Value {
    let documents = Yaml::load_from_str(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let [document] = &documents[..] else { panic!("one document\n{text}") };
    json(document)
}

fn json(node: &Yaml<'_>) -> Value {
    match node {
        Yaml::Value(Scalar::Null) => Value::Null,
        Yaml::Value(Scalar::Boolean(value)) => (*value).into(),
        Yaml::Value(Scalar::Integer(value)) => (*value).into(),
        Yaml::Value(Scalar::String(text)) => text.to_string().into(),
        Yaml::Sequence(items) => items.iter().map(json).collect(),
        Yaml::Mapping(members) => {
            members.iter().map(|(key, value)| (string(&json(key)), json(value))).collect()
        }
        other => panic!("unexpected {other:?}"),
    }
}

/// A scalar in the form to which CI systems convert it.
fn string(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// The members of an object. Empty if the value isn't an object.
fn members(value: &Value) -> impl Iterator<Item = (&String, &Value)> {
    value.as_object().into_iter().flatten()
}
