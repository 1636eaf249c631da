//! Tests of `lint`: levels, exceptions, fixes and file changes.

use std::fs;

use support::{CONFIG, read, write};
use tempfile::TempDir;

use crate::support;

const WIND: &str = "# Wind over ground\n\nuint64 timestamp  # [us] Since start \nfloat32 speed     # [m/s] (@range 0, 60) Speed\nfloat32 gust      # The strongest wind\n";

fn workspace(config: &str, wind: &str) -> TempDir {
    support::workspace(&[("uavspec.toml", config), ("msg/Wind.msg", wind)])
}

/// Runs `lint` and returns standard output and standard error.
#[track_caller]
fn lint(folder: &TempDir, arguments: &[&str], status: i32) -> (String, String) {
    support::run(folder, &[&["lint"], arguments].concat(), status)
}

#[test]
fn fails_at_the_denied_level() {
    let folder = workspace(CONFIG, WIND);
    let (results, _) = lint(&folder, &[], 0);
    assert!(results.contains("warning[unit-missing]: `gust` has no unit"), "{results}");
    assert!(results.contains("note[trailing-white-space]"), "{results}");
    assert!(results.contains("2 warnings, 1 note"), "{results}");
    lint(&folder, &["--deny", "warning"], 1);
    let strict = format!("{CONFIG}[lint.levels]\nunit-missing = \"error\"\ntrailing-white-space = \"off\"\n");
    write(&folder, "uavspec.toml", &strict);
    let (results, _) = lint(&folder, &[], 1);
    assert!(
        results.contains("error[unit-missing]") && !results.contains("trailing-white-space"),
        "{results}"
    );
}

#[test]
fn patterns_may_start_with_a_wildcard() {
    let folder = workspace(&CONFIG.replace("msg/*.msg", "*/*.msg"), WIND);
    assert!(lint(&folder, &[], 0).0.contains("--> msg/Wind.msg:5"));
    let config = CONFIG.replace("msg/*.msg", "*.msg");
    write(&folder, "uavspec.toml", &config);
    let (_, messages) = lint(&folder, &["--config", "uavspec.toml"], 2);
    assert!(messages.contains("`*.msg` matches no file in ."), "{messages}");
}

#[test]
fn applies_only_automatic_fixes() {
    let folder = workspace(CONFIG, WIND);
    let (results, messages) = lint(&folder, &["--fix"], 0);
    assert!(messages.contains("2 fixed") && results.contains("unit-missing"), "{messages}{results}");
    let fixed = read(&folder, "msg/Wind.msg");
    assert_eq!(fixed, WIND.replace("start \n", "start\n").replace("(@range 0, 60)", "[@range 0, 60]"));
    lint(&folder, &["--fix"], 0);
    assert_eq!(read(&folder, "msg/Wind.msg"), fixed);
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
    let (results, _) = lint(&folder, &[], 0);
    assert!(!results.contains("unit-missing"), "{results}");
    let ignore = "[[lint.ignore]]\nrule = \"unit-missing\"\npath = \"msg/W*.msg\"\nreason = \"as it was\"\n";
    let folder = workspace(&format!("{CONFIG}{ignore}"), WIND);
    let (results, _) = lint(&folder, &[], 0);
    assert!(!results.contains("unit-missing"), "{results}");
    write(&folder, "msg/Wind.msg", &WIND.replace("# The", "# [m/s] The"));
    let (results, _) = lint(&folder, &[], 0);
    assert!(results.contains("warning[unused-ignore]") && results.contains("uavspec.toml:5:1"), "{results}");
    lint(&folder, &["--fix"], 0);
    let config = read(&folder, "uavspec.toml");
    assert_eq!(config, format!("{CONFIG}{ignore}"), "the configuration file is never changed");
}

#[test]
fn failures_have_status_2_and_a_hint() {
    for (config, parts) in [
        ("[lint]\npreset = \"loose\"\n", ["uavspec.toml:6:10", "expected `px4` or `strict`"]),
        ("[lint.levels]\nunit-mising = \"off\"\n", ["unknown rule `unit-mising`", "help: `lint --rules`"]),
        ("[lint.levels]\nunit-missing = \"fatal\"\n", ["uavspec.toml:6:16", "unknown variant `fatal`"]),
        ("[[lint.ignore]]\nrule = \"unit-missing\"\n", ["uavspec.toml:5:1", "missing field `reason`"]),
        ("[lint]\npresett = \"px4\"\n", ["uavspec.toml:6:1", "unknown field `presett`"]),
    ] {
        let folder = workspace(&format!("{CONFIG}{config}"), WIND);
        let (_, errors) = lint(&folder, &[], 2);
        for part in parts {
            assert!(errors.contains(part), "{config}: {errors}");
        }
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let arguments = ["--package", "demo", "--dialect", "px4", "--input", "."];
    let (_, errors) = lint(&folder, &arguments, 2);
    assert!(
        errors.contains("no definitions in .") && errors.contains("help: definitions of the px4 dialect"),
        "{errors}"
    );
}

#[test]
fn results_go_to_standard_output_and_progress_to_standard_error() {
    let folder = workspace(CONFIG, WIND);
    let (results, messages) = lint(&folder, &[], 0);
    assert!(results.ends_with("\n\n2 warnings, 1 note in 1 of 1 file\n"), "{results}");
    assert!(messages.starts_with("lint: 1 file read (") && messages.lines().count() == 1, "{messages}");
    assert!(messages.ends_with("; run with `--fix` to fix 2\n"), "{messages}");
}

#[test]
fn summaries_contain_only_totals() {
    let folder = workspace(CONFIG, WIND);
    let table = "\
level    rule                  count  fixable
warning  annotation-near-miss      1        1
warning  unit-missing              1        -
note     trailing-white-space      1        1

2 warnings, 1 note in 1 of 1 file
";
    assert_eq!(lint(&folder, &["--summary"], 0).0, table);
    lint(&folder, &["--summary", "--deny", "note"], 1);
    let json = lint(&folder, &["--summary", "--format", "json"], 0).0;
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!((&json["command"], &json["count"], &json["fixable"]), (&"lint".into(), &3.into(), &2.into()));
    assert_eq!(json["levels"], serde_json::json!({ "error": 0, "warning": 2, "note": 1 }));
    assert_eq!(
        json["rules"][0],
        serde_json::json!({ "rule": "annotation-near-miss", "level": "warning", "count": 1, "fixable": 1 })
    );
    let notice = lint(&folder, &["--summary", "--format", "github"], 0).0;
    assert!(notice.starts_with("::notice title=lint::level") && notice.lines().count() == 1, "{notice}");
    for format in ["sarif", "junit"] {
        let (results, messages) = lint(&folder, &["--summary", "--format", format], 2);
        assert!(results.is_empty() && messages.contains("help: use --summary with"), "{results}{messages}");
    }
    write(&folder, "msg/Wind.msg", &WIND.lines().take(2).collect::<Vec<_>>().join("\n"));
    assert_eq!(
        lint(&folder, &["--summary", "--rule", "unit-missing"], 0).0,
        "no findings in 1 file; 1 other finding hidden by options\n"
    );
}

#[test]
fn reports_only_selected_rules_and_levels() {
    let folder = workspace(CONFIG, WIND);
    let arguments = ["--rule", "unit-missing", "--rule", "trailing-white-space"];
    let (results, _) = lint(&folder, &arguments, 0);
    assert!(
        results.contains("warning[unit-missing]") && results.contains("note[trailing-white-space]"),
        "{results}"
    );
    assert!(!results.contains("near-miss"), "{results}");
    assert!(
        results.ends_with("1 warning, 1 note in 1 of 1 file; 1 other finding hidden by options\n"),
        "{results}"
    );
    let (results, _) = lint(&folder, &["--level", "warning", "--deny", "note"], 1);
    assert!(results.contains("unit-missing") && !results.contains("trailing"), "{results}");
    let (results, _) = lint(&folder, &["--level", "error", "--deny", "note"], 0);
    assert_eq!(results, "no findings in 1 file; 3 other findings hidden by options\n");
    // Parser errors make the other findings incomplete.
    write(&folder, "msg/Gust.msg", "flaot32 speed\n");
    assert!(lint(&folder, &["--rule", "unit-alias"], 1).0.contains("error[unknown-type]"));
}

#[test]
fn a_selected_rule_is_checked_even_if_it_is_off() {
    let wind = WIND.replace("float32 gust      # The", "uint16 height      # The");
    let folder = workspace(&format!("{CONFIG}[lint.levels]\nunit-missing = \"off\"\n"), &wind);
    assert!(!lint(&folder, &[], 0).0.contains("unit-missing"));
    let (results, _) = lint(&folder, &["--rule", "unit-missing-integer"], 0);
    assert!(results.contains("note[unit-missing-integer]: `height` has no unit"), "{results}");
}

#[test]
fn fixes_only_selected_rules() {
    let folder = workspace(CONFIG, WIND);
    lint(&folder, &["--fix", "--rule", "trailing-white-space"], 0);
    let fixed = read(&folder, "msg/Wind.msg");
    assert_eq!(fixed, WIND.replace("start \n", "start\n"));
}

#[test]
fn unknown_names_are_usage_errors_with_a_similar_name() {
    let folder = workspace(CONFIG, WIND);
    for (arguments, similar) in
        [(["--rule", "unit-mising"], "unit-missing"), (["--level", "warnin"], "warning")]
    {
        let (_, messages) = lint(&folder, &arguments, 2);
        assert!(messages.contains(&format!("a similar value exists: '{similar}'")), "{messages}");
        assert!(messages.contains("[possible values: "), "{messages}");
    }
}
