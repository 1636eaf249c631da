//! Tests of baselines, for `lint` and `breaking`.

use support::{CONFIG, read, run, write};
use tempfile::TempDir;

use crate::support;

const WIND: &str = "# Wind over ground\n\nuint64 timestamp  # [us] Since start\nfloat32 speed  # Speed\nfloat32 gust  # Strongest wind\n";

fn workspace() -> TempDir {
    support::workspace(&[("uavspec.toml", CONFIG), ("msg/Wind.msg", WIND)])
}

#[track_caller]
fn lint(folder: &TempDir, arguments: &[&str], status: i32) -> (String, String) {
    run(folder, &[&["lint", "--deny", "note"], arguments].concat(), status)
}

fn known(folder: &TempDir) -> String {
    read(folder, "known.toml")
}

#[test]
fn known_findings_stay_known_if_lines_move() {
    let folder = workspace();
    lint(&folder, &[], 1);
    let (results, _) = lint(&folder, &["--write-baseline", "known.toml"], 0);
    assert_eq!(results, "no new findings in 1 file; 2 known findings not shown\n");
    let moved = WIND.replace("\nuint64", "#\n# More about the wind\n\nuint64");
    write(
        &folder,
        "msg/Wind.msg",
        &moved.replace("float32 gust", "float32 lull  # Weakest wind\nfloat32 gust"),
    );
    let (results, messages) = lint(&folder, &["--baseline", "known.toml"], 1);
    assert!(results.contains("`lull` has no unit") && !results.contains("gust` has"), "{results}");
    assert!(results.ends_with("1 warning in 1 of 1 file; 2 known findings not shown\n"), "{results}");
    assert!(!messages.contains("out of date"), "{messages}");
}

#[test]
fn entries_without_findings_are_outdated() {
    let folder = workspace();
    lint(&folder, &["--write-baseline", "known.toml"], 0);
    let list = known(&folder);
    write(&folder, "msg/Wind.msg", &WIND.replace("# Speed", "# [m/s] Speed"));
    let (results, messages) = lint(&folder, &["--baseline", "known.toml"], 4);
    assert_eq!(results, "no new findings in 1 file; 1 known finding not shown\n");
    assert!(messages.contains("error[baseline-unmatched]"), "{messages}");
    assert!(messages.contains("error: a baseline is out of date\n"), "{messages}");
    assert!(
        messages.contains("subject = \"demo/Wind.speed\"") && messages.contains("--fix-baseline"),
        "{messages}"
    );
    // This run doesn't check the rule of the entry, so the entry isn't reported.
    lint(&folder, &["--baseline", "known.toml", "--rule", "unit-alias"], 0);
    let off = format!("{CONFIG}[lint.levels]\nunit-missing = \"off\"\n");
    write(&folder, "uavspec.toml", &off);
    lint(&folder, &["--baseline", "known.toml"], 0);
    write(&folder, "uavspec.toml", CONFIG);
    assert_eq!(known(&folder), list, "only --fix-baseline changes the list");
    lint(&folder, &["--baseline", "known.toml", "--fix-baseline"], 0);
    let fixed = known(&folder);
    assert!(!fixed.contains("Wind.speed") && fixed.contains("Wind.gust"), "{fixed}");
    // A finding at the denied level takes precedence over an outdated baseline.
    write(&folder, "msg/Wind.msg", &WIND.replace("gust", "lull"));
    lint(&folder, &["--baseline", "known.toml"], 1);
}

#[test]
fn fixing_a_list_adds_no_findings() {
    let folder = workspace();
    lint(&folder, &["--write-baseline", "known.toml"], 0);
    write(&folder, "msg/Wind.msg", &WIND.replace("gust", "lull"));
    let (results, _) = lint(&folder, &["--baseline", "known.toml", "--fix-baseline"], 1);
    assert!(results.contains("`lull` has no unit"), "{results}");
    assert!(!known(&folder).contains("gust") && !known(&folder).contains("lull"), "{}", known(&folder));
}

#[test]
fn a_subject_with_more_findings_than_its_count_is_reported() {
    let folder = workspace();
    let spaces =
        |count: usize| format!("# Wind over ground\n#\n{}{}", "# A line \n".repeat(count), &WIND[19..]);
    write(&folder, "msg/Wind.msg", &spaces(2));
    lint(&folder, &["--write-baseline", "known.toml"], 0);
    lint(&folder, &["--baseline", "known.toml"], 0);
    write(&folder, "msg/Wind.msg", &spaces(3));
    let (results, messages) = lint(&folder, &["--baseline", "known.toml"], 1);
    assert_eq!(results.matches("note[trailing-white-space]").count(), 3, "{results}");
    assert!(
        messages.contains("note[baseline-count]") && messages.contains("has 3 findings instead of 2"),
        "{messages}"
    );
    write(&folder, "msg/Wind.msg", &spaces(1));
    let (_, messages) = lint(&folder, &["--baseline", "known.toml"], 4);
    assert!(messages.contains("error[baseline-count]"), "{messages}");
    lint(&folder, &["--baseline", "known.toml", "--fix-baseline"], 0);
    lint(&folder, &["--baseline", "known.toml"], 0);
    write(&folder, "msg/Wind.msg", &spaces(4));
    lint(&folder, &["--write-baseline", "known.toml"], 0);
    assert!(known(&folder).contains("count = 4"), "{}", known(&folder));
}

#[test]
fn writing_a_list_keeps_comments_and_reasons() {
    let folder = workspace();
    let head = "# Findings of the wind team.\n\n";
    let entry = "# Ask the sensor team.\n[[known]]\nrule = \"unit-missing\"\nsubject = \"demo/*.speed\"\n\
                 reason = \"the sensor has no unit\"\nlink = \"https://example.org/issues/7\"\n";
    let expired = "\n# This one is over.\n[[known]]\nrule = \"unit-missing\"\nsubject = \"demo/Calm.x\"\n\
                   reason = \"old\"\nexpires = 2020-01-01\n";
    write(&folder, "known.toml", &format!("{head}{entry}{expired}"));
    let (_, messages) = lint(&folder, &["--baseline", "known.toml"], 1);
    assert!(messages.contains("error[baseline-expired]: the entry expired on 2020-01-01"), "{messages}");
    lint(&folder, &["--write-baseline", "known.toml"], 0);
    let list = known(&folder);
    assert!(list.starts_with(&format!("{head}{entry}")), "{list}");
    assert!(!list.contains("over") && list.contains("subject = \"demo/Wind.gust\"\ncount = 1\n"), "{list}");
    lint(&folder, &["--baseline", "known.toml"], 0);
}

#[test]
fn parser_errors_are_never_known() {
    let folder = workspace();
    write(&folder, "msg/Gust.msg", "flaot32 speed\n");
    let (results, _) = lint(&folder, &["--write-baseline", "known.toml"], 1);
    assert!(results.contains("error[unknown-type]") && !results.contains("unit-missing"), "{results}");
    assert!(!known(&folder).contains("unknown-type"));
}

#[test]
fn invalid_lists_have_status_2_and_a_location() {
    let folder = workspace();
    let text = "[[known]]\nrule = \"unit-mising\"\nsubject = \"demo/[Wind\"\nraison = \"old\"\n";
    write(&folder, "known.toml", text);
    for option in ["--baseline", "--write-baseline"] {
        let (_, messages) = lint(&folder, &[option, "known.toml"], 2);
        for part in ["did you mean `unit-missing`?", "known.toml:3:11", "unknown key `raison`"] {
            assert!(messages.contains(part), "{part}: {messages}");
        }
    }
    assert_eq!(known(&folder), text);
    let (_, messages) = lint(&folder, &["--baseline", "absent.toml"], 2);
    assert!(messages.contains("absent.toml") && messages.contains("--write-baseline FILE"), "{messages}");
}

#[test]
fn findings_in_other_lists_are_not_written() {
    let folder = workspace();
    let entry = "[[known]]\nrule = \"unit-missing\"\nsubject = \"demo/Wind.speed\"\nreason = \"old\"\n";
    write(&folder, "speed.toml", entry);
    lint(&folder, &["--baseline", "speed.toml", "--write-baseline", "known.toml"], 0);
    assert!(!known(&folder).contains("speed") && known(&folder).contains("gust"), "{}", known(&folder));
    lint(&folder, &["--baseline", "speed.toml", "--baseline", "known.toml"], 0);
    // Entries of the other list are kept, even if they no longer apply.
    write(&folder, "msg/Wind.msg", &WIND.replace("speed", "calm"));
    let (_, messages) = lint(&folder, &["--baseline", "speed.toml", "--write-baseline", "known.toml"], 4);
    assert!(messages.contains("speed.toml:3:11") && known(&folder).contains("demo/Wind.calm"), "{messages}");
    assert_eq!(read(&folder, "speed.toml"), entry);
}

#[test]
fn entries_of_lint_may_name_files_and_messages() {
    let folder = workspace();
    let entry = |key: &str| format!("[[known]]\nrule = \"unit-missing\"\nreason = \"old\"\n{key}\n");
    for (key, status) in [
        ("file = \"msg/*.msg\"", 0),
        ("file = \"other/*\"", 1),
        ("message = \"`\"", 0),
        ("message = \"`gust` has\"", 1),
        ("subject = \"demo/Wind.{speed,gust}\"\ncount = 2", 0),
        ("count = 1", 1),
        ("expires = 2020-01-01", 4),
    ] {
        write(&folder, "known.toml", &entry(key));
        lint(&folder, &["--baseline", "known.toml"], status);
    }
}

#[test]
fn one_list_serves_both_commands() {
    let folder = workspace();
    write(&folder, "old/Wind.msg", &WIND.replace("gust", "lull"));
    write(&folder, "old/uavspec.toml", &CONFIG.replace("msg/", ""));
    let breaking = |arguments: &[&str], status| {
        run(&folder, &[&["breaking", "--against", "old"], arguments].concat(), status)
    };
    let (results, _) = breaking(&[], 1);
    lint(&folder, &["--write-baseline", "known.toml"], 0);
    let (unknown, _) = breaking(&["--baseline", "known.toml"], 1);
    assert_eq!(unknown, results, "the list contains no changes, and entries of lint are not outdated");
    breaking(&["--write-baseline", "known.toml"], 0);
    let (results, _) = breaking(&["--baseline", "known.toml"], 0);
    assert!(results.starts_with("no new changes; "), "{results}");
    lint(&folder, &["--baseline", "known.toml"], 0);
    write(&folder, "msg/Wind.msg", &WIND.replace("float32 speed", "float64 speed"));
    let (results, _) = breaking(&["--baseline", "known.toml"], 1);
    assert!(results.contains("field-type-changed") && !results.contains("lull"), "{results}");
}

#[test]
fn services_pages_and_translations_have_subjects() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let trail = |text: &str| text.replace(';', " ");
    write(
        &folder,
        "msg/Trim.srv",
        &trail("# Trims the sails;\n\nuint8 sail # Sail;\n---\nuint8 sail # Sail;\n"),
    );
    write(
        &folder,
        "pages/errors.md",
        &trail(
            "# Errors of a vendor (codes 512-767)\n\nText;\n\n|Code|Abbr|Description|\n|-|-|-|\n| 512 | | Warning: x |;\n",
        ),
    );
    let table = "[[package]]\nname = \"pages\"\ndialect = \"table\"\ninclude = [\"pages/*.md\"]\n";
    write(&folder, "uavspec.toml", &format!("{}{table}", CONFIG.replace("*.msg", "*.srv")));
    run(&folder, &["lint", "--preset", "strict", "--write-baseline", "known.toml"], 0);
    let list = known(&folder);
    for subject in ["demo/Trim_Request", "demo/Trim_Request.sail", "demo/Trim_Response.sail"] {
        assert!(list.contains(&format!("subject = \"{subject}\"")), "{subject}: {list}");
    }
    assert!(list.contains("pages/errors: Errors of a vendor (codes 512-767).512"), "{list}");
}
