//! Tests of releases: definitions without comments keep their meaning.

use std::fs;
use std::path::Path;

use tempfile::TempDir;
use uavspec_dynamic::breaking::{Between, breaking};
use uavspec_lint::release::{self, fingerprints};
use uavspec_schema::diagnostic::has_errors;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Form, Schema, SourceMap, read, render};

use uavspec_test_definitions as support;

/// Writes a schema as a release and reads it again. The result must have the same meaning.
fn check(mut sources: SourceMap, schema: &Schema, dialect: Dialect) {
    let text = release::write(schema);
    let packages = release::packages(&text, dialect, "release/", &mut sources);
    let (read_again, diagnostics) = read(&sources, &packages);
    assert!(!has_errors(&diagnostics), "{}", render::render(&diagnostics, &sources, false));
    assert_eq!(differing_lines(&release::write(&read_again), &text), "");
    let (found, expected) = (fingerprints(&read_again), fingerprints(schema));
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!(found, expected);
    }
    assert_eq!(found.len(), expected.len());
    let findings = breaking(&sources, schema, &read_again, Between::Releases);
    let findings: Vec<String> = findings.iter().map(|found| format!("{found:?}")).collect();
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}

/// The first lines that differ.
fn differing_lines(found: &str, expected: &str) -> String {
    let mut lines = found.lines().zip(expected.lines()).filter(|(found, expected)| found != expected);
    lines.next().map(|(found, expected)| format!("{found}\n{expected}")).unwrap_or_default()
}

#[test]
fn facts_keep_the_meaning_of_definitions() {
    let text = "# Glider\n# TOPICS glider tow\n\nuint32 MESSAGE_VERSION = 2\nuint8 ORB_QUEUE_LENGTH = 4\n\n\
                # Air\nuint64 timestamp # [us] Since start\nfloat32[3] wind # [m/s] [@range -60, 60] [@invalid NaN \
                unknown] [@frame NED] Wind\nuint8 state # [@enum STATE] State\nuint8 STATE_TOW = 0 # Behind a plane\n\
                uint8 STATE_FREE=0x1\nuint16 faults # [@flags FAULT]\nuint16 FAULT_FLAP = 0\nuint8 num_marks\nMark[4] marks\n\
                uint16 CMD_LOITER = 17 # Loiter |[m] [@range 0, ] Radius|-|-|-|[@enum STATE] State|-|-|\nchar[9] name\n";
    let files = [
        ("Glider.msg", text),
        ("Mark.msg", "bool is_high\n"),
        ("Tow.srv", "uint8 HOOK = 1\n---\nMark mark\n"),
    ];
    let (sources, schema, _) = support::texts(Form::Msg(Dialect::Px4), &files);
    check(sources, &schema, Dialect::Px4);
    let text = release::write(&schema);
    assert!(!text.contains("Wind\n") && !text.contains("unknown") && !text.contains("Radius"), "{text}");
    let ros =
        "string<=5 name \"a # b\"\nfloat64[] speeds [1.5, -2]\nwstring[<=3] marks\nbyte B=1\nstring S='x'\n";
    let files = [("Glider.msg", ros), ("Fly.action", "Glider goal\n---\n---\nint8 part\n")];
    let (sources, schema, _) = support::texts(Form::Msg(Dialect::Ros2), &files);
    check(sources, &schema, Dialect::Ros2);
}

#[test]
fn facts_keep_the_meaning_of_all_releases() {
    let Some(folder) = support::shared("corpus/px4") else { return };
    for release in subfolders(&folder).iter().step_by(support::extent(1, 4)) {
        let (sources, schema, _) = support::px4(release);
        check(sources, &schema, Dialect::Px4);
    }
    let Some(folder) = support::shared("corpus/ros2-distros") else { return };
    for release in subfolders(&folder).into_iter().rev().step_by(support::extent(1, 3)) {
        let inputs = [release];
        let loaded = uavspec_codegen::load::read_package("ros2", Form::Msg(Dialect::Ros2), &inputs)
            .expect("definitions");
        let text = release::write(&loaded.schema);
        let mut sources = SourceMap::default();
        let packages = release::packages(&text, Dialect::Ros2, "", &mut sources);
        let (read_again, diagnostics) = read(&sources, &packages);
        assert!(!has_errors(&diagnostics), "{}", render::render(&diagnostics, &sources, false));
        assert_eq!(release::write(&read_again), text);
        assert_eq!(fingerprints(&read_again), fingerprints(&loaded.schema));
    }
}

fn subfolders(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut folders: Vec<_> = entries.filter(|path| path.is_dir()).collect();
    folders.sort();
    folders
}

/// A folder with a `uavspec.toml`, a definition, and the releases 1.9 and 1.10.
fn configured(dialect: &str, releases: &str) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |path: &str, text: &str| {
        let path = folder.path().join(path);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    };
    let include = if dialect == "table" { "*.md" } else { "*.msg" };
    write(
        "uavspec.toml",
        &format!(
            "[output]\ndocs = \"docs\"\n\n[[package]]\nname = \"sky\"\ndialect = \"{dialect}\"\ninclude = [\"{include}\"]\n\
             releases = \"{releases}\"\n"
        ),
    );
    write("Wind.msg", "# Wind\n\nuint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] Speed\n");
    write("empty/README.md", "Nothing yet\n");
    let heading = format!("{}\nMSG: sky/msg/Wind\nuint64 timestamp\n", "=".repeat(80));
    write("releases/1.9.msg", &heading);
    write("releases/1.10.msg", &format!("{heading}float32 speed\n"));
    write("releases/README.md", "Facts\n");
    folder
}

#[test]
fn releases_of_a_package_are_read_in_their_order() {
    let folder = configured("px4", "releases");
    let generated = uavspec_codegen::generate(folder.path().join("uavspec.toml")).expect("no errors");
    let page = fs::read_to_string(folder.path().join("docs/sky/Wind.md")).expect("a page");
    assert!(
        page.contains("\n| `1.9` | oldest known release |\n| `1.10` | `speed` (float32) was added |\n"),
        "{page}"
    );
    let releases =
        generated.inputs.iter().filter(|path| path.parent() == Some(&folder.path().join("releases")));
    assert_eq!(releases.count(), 2);
}

#[test]
fn releases_that_cannot_be_read_are_errors() {
    let failure = |dialect: &str, releases: &str| {
        let folder = configured(dialect, releases);
        let config = folder.path().join("uavspec.toml");
        uavspec_codegen::generate(config).expect_err("an error").to_string()
    };
    assert!(failure("px4", "none").contains("none: "), "{}", failure("px4", "none"));
    assert!(failure("px4", "empty").contains("no releases in "), "{}", failure("px4", "empty"));
    let table = failure("table", "releases");
    assert!(table.contains("a package of the `table` dialect has no `releases`"), "{table}");
    assert!(table.contains("8:12"), "{table}");
}
