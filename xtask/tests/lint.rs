//! Tests of `lint`: levels, exceptions, fixes and file changes.

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
    let errors = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {errors}");
    errors
}

#[test]
fn fails_at_the_denied_level() {
    let folder = workspace(CONFIG, WIND);
    let errors = lint(folder.path(), &[], 0);
    assert!(errors.contains("warning[unit-missing]: `gust` has no unit"), "{errors}");
    assert!(errors.contains("note[trailing-white-space]"), "{errors}");
    assert!(errors.contains("2 warnings, 1 note"), "{errors}");
    lint(folder.path(), &["--deny", "warning"], 1);
    let strict = format!("{CONFIG}[lint.levels]\nunit-missing = \"error\"\ntrailing-white-space = \"off\"\n");
    fs::write(folder.path().join("uavspec.toml"), strict).expect("a file");
    let errors = lint(folder.path(), &[], 1);
    assert!(errors.contains("error[unit-missing]") && !errors.contains("trailing-white-space"), "{errors}");
}

#[test]
fn applies_only_automatic_fixes() {
    let folder = workspace(CONFIG, WIND);
    let errors = lint(folder.path(), &["--fix"], 0);
    assert!(errors.contains("2 fixed") && errors.contains("unit-missing"), "{errors}");
    let fixed = fs::read_to_string(folder.path().join("msg/Wind.msg")).expect("a file");
    assert_eq!(fixed, WIND.replace("start \n", "start\n").replace("(@range 0, 60)", "[@range 0, 60]"));
    lint(folder.path(), &["--fix"], 0);
    assert_eq!(fs::read_to_string(folder.path().join("msg/Wind.msg")).expect("a file"), fixed);
    assert_eq!(
        fs::read_dir(folder.path().join("msg")).expect("a folder").count(),
        1,
        "no temporary files remain"
    );
}

#[test]
fn comments_and_the_configuration_can_ignore_findings() {
    let ignored = WIND.replace("wind\n", "wind  # uavspec:ignore unit-missing not known\n");
    let folder = workspace(CONFIG, &ignored);
    let errors = lint(folder.path(), &[], 0);
    assert!(!errors.contains("unit-missing"), "{errors}");
    let ignore = "[[lint.ignore]]\nrule = \"unit-missing\"\npath = \"msg/W*.msg\"\nreason = \"as it was\"\n";
    let folder = workspace(&format!("{CONFIG}{ignore}"), WIND);
    let errors = lint(folder.path(), &[], 0);
    assert!(!errors.contains("unit-missing"), "{errors}");
    fs::write(folder.path().join("msg/Wind.msg"), WIND.replace("# The", "# [m/s] The")).expect("a file");
    let errors = lint(folder.path(), &[], 0);
    assert!(errors.contains("warning[unused-ignore]") && errors.contains("uavspec.toml:5:1"), "{errors}");
    lint(folder.path(), &["--fix"], 0);
    let config = fs::read_to_string(folder.path().join("uavspec.toml")).expect("a file");
    assert_eq!(config, format!("{CONFIG}{ignore}"), "the configuration file is never changed");
}

#[test]
fn failures_have_status_2_and_a_hint() {
    for (config, parts) in [
        ("[lint]\npreset = \"loose\"\n", ["uavspec.toml:6:10", "expected `px4` or `strict`"]),
        (
            "[lint.levels]\nunit-mising = \"off\"\n",
            ["unknown rule `unit-mising`", "help: `cargo xtask lint --rules`"],
        ),
        ("[lint.levels]\nunit-missing = \"fatal\"\n", ["uavspec.toml:6:16", "unknown variant `fatal`"]),
        ("[[lint.ignore]]\nrule = \"unit-missing\"\n", ["uavspec.toml:5:1", "missing field `reason`"]),
        ("[lint]\npresett = \"px4\"\n", ["uavspec.toml:6:1", "unknown field `presett`"]),
    ] {
        let folder = workspace(&format!("{CONFIG}{config}"), WIND);
        let errors = lint(folder.path(), &[], 2);
        for part in parts {
            assert!(errors.contains(part), "{config}: {errors}");
        }
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let arguments = ["--package", "demo", "--dialect", "px4", "--input", "."];
    let errors = lint(folder.path(), &arguments, 2);
    assert!(
        errors.contains("no definitions in .") && errors.contains("help: definitions of the px4 dialect"),
        "{errors}"
    );
}
