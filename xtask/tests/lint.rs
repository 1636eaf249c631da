//! `lint` as a user meets it: levels, ignores, mending, and what happens to files.

use std::fs;
use std::path::Path;
use std::process::Command;

const CONFIG: &str = "[[package]]\nname = \"demo\"\ndialect = \"px4\"\ninclude = [\"msg/*.msg\"]\n";
const WIND: &str = "# Wind over ground\n\nuint64 timestamp  # [us] Since start \nfloat32 speed     # [m/s] (@range 0, 60) Speed\nfloat32 gust      # The strongest wind\n";

fn workspace(config: &str, wind: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::create_dir(folder.path().join("msg")).expect("a folder");
    fs::write(folder.path().join("uavspec.toml"), config).expect("a file");
    fs::write(folder.path().join("msg/Wind.msg"), wind).expect("a file");
    folder
}

#[track_caller]
fn lint(folder: &Path, arguments: &[&str], status: i32) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_xtask"))
        .arg("lint")
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("xtask runs");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said}");
    said
}

#[test]
fn fails_from_the_level_that_is_denied() {
    let folder = workspace(CONFIG, WIND);
    let said = lint(folder.path(), &[], 0);
    assert!(said.contains("warning[unit-missing]: `gust` has no unit"), "{said}");
    assert!(said.contains("note[trailing-white-space]"), "{said}");
    assert!(said.contains("2 warnings, 1 note"), "{said}");
    lint(folder.path(), &["--deny", "warning"], 1);
    let strict = format!("{CONFIG}[lint.levels]\nunit-missing = \"error\"\ntrailing-white-space = \"off\"\n");
    fs::write(folder.path().join("uavspec.toml"), strict).expect("a file");
    let said = lint(folder.path(), &[], 1);
    assert!(said.contains("error[unit-missing]") && !said.contains("trailing-white-space"), "{said}");
}

#[test]
fn mends_what_can_be_and_nothing_else() {
    let folder = workspace(CONFIG, WIND);
    let said = lint(folder.path(), &["--fix"], 0);
    assert!(said.contains("2 mended") && said.contains("unit-missing"), "{said}");
    let mended = fs::read_to_string(folder.path().join("msg/Wind.msg")).expect("a file");
    assert_eq!(mended, WIND.replace("start \n", "start\n").replace("(@range 0, 60)", "[@range 0, 60]"));
    lint(folder.path(), &["--fix"], 0);
    assert_eq!(fs::read_to_string(folder.path().join("msg/Wind.msg")).expect("a file"), mended);
    assert_eq!(
        fs::read_dir(folder.path().join("msg")).expect("a folder").count(),
        1,
        "nothing is left behind"
    );
}

#[test]
fn findings_are_let_stand_by_comments_and_by_the_configuration() {
    let ignored = WIND.replace("wind\n", "wind  # uavspec:ignore unit-missing not known\n");
    let folder = workspace(CONFIG, &ignored);
    let said = lint(folder.path(), &[], 0);
    assert!(!said.contains("unit-missing"), "{said}");
    let ignore = "[[lint.ignore]]\nrule = \"unit-missing\"\npath = \"msg/W*.msg\"\nreason = \"as it was\"\n";
    let folder = workspace(&format!("{CONFIG}{ignore}"), WIND);
    let said = lint(folder.path(), &[], 0);
    assert!(!said.contains("unit-missing"), "{said}");
    fs::write(folder.path().join("msg/Wind.msg"), WIND.replace("# The", "# [m/s] The")).expect("a file");
    let said = lint(folder.path(), &[], 0);
    assert!(said.contains("warning[unused-ignore]") && said.contains("uavspec.toml:5:1"), "{said}");
    lint(folder.path(), &["--fix"], 0);
    let config = fs::read_to_string(folder.path().join("uavspec.toml")).expect("a file");
    assert_eq!(config, format!("{CONFIG}{ignore}"), "the configuration file is left to its owner");
}

#[test]
fn what_cannot_be_carried_out_is_status_2_with_a_hint() {
    for (config, parts) in [
        ("[lint]\npreset = \"loose\"\n", ["uavspec.toml:6:10", "expected `px4` or `strict`"]),
        (
            "[lint.levels]\nunit-mising = \"off\"\n",
            ["no rule `unit-mising`", "help: `cargo xtask lint --rules`"],
        ),
        ("[lint.levels]\nunit-missing = \"fatal\"\n", ["uavspec.toml:6:16", "unknown variant `fatal`"]),
        ("[[lint.ignore]]\nrule = \"unit-missing\"\n", ["uavspec.toml:5:1", "missing field `reason`"]),
        ("[lint]\npresett = \"px4\"\n", ["uavspec.toml:6:1", "unknown field `presett`"]),
    ] {
        let folder = workspace(&format!("{CONFIG}{config}"), WIND);
        let said = lint(folder.path(), &[], 2);
        for part in parts {
            assert!(said.contains(part), "{config}: {said}");
        }
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let arguments = ["--package", "demo", "--dialect", "px4", "--input", "."];
    let said = lint(folder.path(), &arguments, 2);
    assert!(said.contains("no definitions below .") && said.contains("help: the dialect px4"), "{said}");
}
