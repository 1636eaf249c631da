//! Tests of translation catalogues on the command line.

use std::fs;
use std::path::Path;
use std::process::Command;

use support::{read, write};
use tempfile::TempDir;

use crate::support;

const CONFIG: &str = r#"
[output]
docs = "out"

[[package]]
name = "demo"
dialect = "px4"
include = ["msg/*.msg"]

[translations]
include = ["i18n/*.po"]
"#;

const WIND: &str =
    "# Wind over ground\n\nuint64 timestamp  # [us] Since start\nfloat32 speed  # [m/s] Speed\n";
const GUST: &str = "# A gust\n\nuint64 timestamp  # [us] Since start\n";

fn workspace() -> TempDir {
    support::workspace(&[("uavspec.toml", CONFIG), ("msg/Wind.msg", WIND), ("msg/Gust.msg", GUST)])
}

/// Runs a command and returns the messages on standard error.
#[track_caller]
fn run(folder: &TempDir, arguments: &[&str], status: i32) -> String {
    support::run(folder, arguments, status).1
}

#[test]
fn creates_and_updates_a_catalogue() {
    let folder = workspace();
    let errors = run(&folder, &["translate", "uk", "--select", "demo/Wind"], 0);
    assert!(errors.contains("i18n/uk.po: updated, 3 untranslated"), "{errors}");
    let created = read(&folder, "i18n/uk.po");
    assert!(
        created.contains("\"X-Language-Name: Українська\\n\"") && !created.contains("demo/Gust"),
        "{created}"
    );
    let translated =
        created.replace("msgid \"Speed\"\nmsgstr \"\"", "msgid \"Speed\"\nmsgstr \"Швидкість\"").replace(
            "msgid \"Wind over ground\"\nmsgstr \"\"",
            "msgid \"Wind over ground\"\nmsgstr \"Вітер над землею\"",
        );
    write(&folder, "i18n/uk.po", &translated);
    run(&folder, &["translate", "--check"], 0);
    let errors = run(&folder, &["translate", "--check", "UK"], 0);
    assert!(errors.contains("i18n/uk.po: up to date"), "{errors}");

    let errors = run(&folder, &["codegen"], 0);
    assert!(errors.contains("warning[translation-missing]: 1 of 3 texts of `demo/Wind`"), "{errors}");
    let page = read(&folder, "out/demo/Wind.uk.md");
    assert!(
        page.contains("| Швидкість |") && page.contains("<span lang=\"en\">Since start</span>"),
        "{page}"
    );

    write(
        &folder,
        "msg/Wind.msg",
        &WIND.replace("Speed", "Speed over ground").replace("# Wind over ground\n\n", ""),
    );
    let (results, _) = support::run(&folder, &["lint"], 0);
    assert!(
        results.contains("warning[translation-stale]") && results.contains("warning[unknown-translation]"),
        "{results}"
    );
    let errors = run(&folder, &["translate", "--check"], 1);
    assert!(errors.contains("i18n/uk.po: outdated") && errors.contains("run `translate`"), "{errors}");
    assert_eq!(read(&folder, "i18n/uk.po"), translated, "--check writes nothing");
    let errors = run(&folder, &["translate"], 0);
    assert!(errors.contains("updated, 1 fuzzy, 1 untranslated, 1 obsolete"), "{errors}");
    let updated = read(&folder, "i18n/uk.po");
    for expected in [
        "#, fuzzy\n#| msgid \"Speed\"\nmsgctxt \"demo/Wind.speed\"\nmsgid \"Speed over ground\"\nmsgstr \"Швидкість\"\n",
        "#~ msgctxt \"demo/Wind\"\n#~ msgid \"Wind over ground\"\n#~ msgstr \"Вітер над землею\"\n",
    ] {
        assert!(updated.contains(expected), "{expected}\nis not in\n{updated}");
    }
    run(&folder, &["translate"], 0);
    assert_eq!(read(&folder, "i18n/uk.po"), updated);
}

#[test]
fn keeps_line_breaks_of_other_tools() {
    let folder = workspace();
    run(&folder, &["translate", "uk"], 0);
    let wrapped =
        read(&folder, "i18n/uk.po").replace("msgid \"Since start\"", "msgid \"\"\n\"Since \"\n\"start\"");
    write(&folder, "i18n/uk.po", &wrapped);
    run(&folder, &["translate"], 0);
    assert_eq!(read(&folder, "i18n/uk.po"), wrapped);
}

#[test]
fn levels_of_translation_rules_are_configurable() {
    let folder = workspace();
    run(&folder, &["translate", "uk"], 0);
    let catalogue = read(&folder, "i18n/uk.po")
        .replace("msgid \"A gust\"\nmsgstr \"\"", "msgid \"A puff\"\nmsgstr \"Порив\"");
    write(&folder, "i18n/uk.po", &catalogue);
    let lint = |more: &str, status| {
        write(
            &folder,
            "uavspec.toml",
            &format!("{CONFIG}\n[lint.levels]\ntranslation-missing = \"off\"\n{more}"),
        );
        support::run(&folder, &["lint"], status).0
    };
    let errors = lint("translation-stale = \"error\"\n", 1);
    assert!(
        errors.contains("error[translation-stale]") && !errors.contains("translation-missing"),
        "{errors}"
    );
    let ignore =
        "[[lint.ignore]]\nrule = \"translation-stale\"\npath = \"i18n/uk.po\"\nreason = \"in progress\"\n";
    let errors = lint(ignore, 0);
    assert!(!errors.contains("translation-stale"), "{errors}");
}

#[test]
fn failures_have_a_hint() {
    let folder = workspace();
    for (arguments, message, hint) in [
        (&["translate"][..], "no catalogue exists", "to create one: `translate uk`"),
        (&["translate", "ukrainian"], "`ukrainian` is not a valid language tag", "BCP 47"),
        (&["translate", "../uk"], "`../uk` is not a valid language tag", "BCP 47"),
        (&["translate", "en"], "`en` is not a valid language tag", "definitions are in English"),
        (
            &["translate", "uk", "--select", "demo/Wnd"],
            "`demo/Wnd` does not match any message",
            "did you mean `demo/Wind`?",
        ),
    ] {
        let errors = run(&folder, arguments, 2);
        assert!(errors.contains(message) && errors.contains(hint), "{errors}");
    }
    assert!(!folder.path().join("i18n").exists());
    write(&folder, "i18n/uk.po", "msgid \"Speed\n");
    let errors = run(&folder, &["translate"], 1);
    assert!(
        errors.contains("error[malformed-catalogue]") && errors.contains("--> i18n/uk.po:1:7"),
        "{errors}"
    );
    assert_eq!(read(&folder, "i18n/uk.po"), "msgid \"Speed\n", "the file stays unchanged");
    write(&folder, "uavspec.toml", &CONFIG.replace("[translations]\ninclude = [\"i18n/*.po\"]", ""));
    let errors = run(&folder, &["translate", "uk"], 2);
    assert!(errors.contains("add `[translations]`"), "{errors}");
}

/// Checks a catalogue with gettext.
#[track_caller]
fn check(path: &Path) {
    let output = Command::new("msgfmt").args(["--check", "--output-file", "/dev/null"]).arg(path).output();
    let output = output.expect("this test requires msgfmt of gettext");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}: {errors}", path.display());
}

#[test]
#[ignore = "requires gettext"]
fn gettext_accepts_catalogues() {
    let folder = workspace();
    run(&folder, &["translate", "uk"], 0);
    let translated = read(&folder, "i18n/uk.po")
        .replace("msgid \"Speed\"\nmsgstr \"\"", "msgid \"Speed\"\nmsgstr \"Швидкість\"");
    for wind in [WIND.replace("Speed", "Speed \\\"over ground\\\""), WIND.replace("speed", "velocity")] {
        write(&folder, "i18n/uk.po", &translated);
        write(&folder, "msg/Wind.msg", &wind);
        run(&folder, &["translate"], 0);
        check(&folder.path().join("i18n/uk.po"));
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for catalogues in ["definitions/i18n", "codegen/emit/src/docs/words"] {
        for entry in fs::read_dir(root.join(catalogues)).expect("a folder") {
            check(&entry.expect("an entry").path());
        }
    }
}
