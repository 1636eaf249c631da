//! Tests of conversions in `uavspec.toml`: the configuration, `codegen` and `lint`.

use support::{read, write};
use tempfile::TempDir;

use crate::support;

const PACKAGES: &str = "[output]\nrust = \"src\"\n\n\
    [[package]]\nname = \"old\"\ndialect = \"px4\"\ninclude = [\"old/*.msg\"]\n\n\
    [[package]]\nname = \"new\"\ndialect = \"px4\"\ninclude = [\"new/*.msg\"]\n\n\
    [[package]]\nname = \"pages\"\ndialect = \"table\"\ninclude = [\"pages/*.md\"]\n\n";

const CONVERSION: &str = "[[conversion]]\nfrom = \"old\"\nto = \"new\"\nhints = \"hints.toml\"\n";

const NARROW: &str = "[[hint]]\nmessage = \"Wind\"\nnarrow = { speed = \"nearest\" }\n";

fn workspace(conversion: &str, hints: &str) -> TempDir {
    support::workspace(&[
        ("uavspec.toml", &format!("{PACKAGES}{conversion}")),
        ("old/Wind.msg", "# Wind\n\nfloat64 speed  # [m/s] Speed\n"),
        ("new/Wind.msg", "# Wind\n\nfloat32 speed  # [m/s] Speed\n"),
        ("old/Calm.msg", "# Calm\n\nbool is_calm  # True if calm\n"),
        ("new/Calm.msg", "# Calm\n\nbool is_calm  # True if calm\n"),
        (
            "pages/page.md",
            "# Warnings (codes 64-127)\n\n| Code | Abbr | Description |\n|---|---|---|\n| 64 | A | First |\n",
        ),
        ("hints.toml", hints),
    ])
}

/// Runs a command. Returns its standard output, followed by its standard error.
#[track_caller]
fn run(folder: &TempDir, arguments: &[&str], status: i32) -> String {
    let (printed, errors) = support::run(folder, arguments, status);
    printed + &errors
}

#[test]
fn generates_conversions_only_for_decided_messages() {
    let folder = workspace(CONVERSION, "");
    run(&folder, &["codegen"], 0);
    let text = read(&folder, "src/conversions/old_to_new.rs");
    assert!(text.contains("From<&old::Calm> for new::Calm") && !text.contains("for new::Wind"), "{text}");
    assert!(text.contains("neither the definitions nor hints decide all parts: `Wind`."), "{text}");
    let back = read(&folder, "src/conversions/new_to_old.rs");
    assert!(back.contains("From<&new::Wind> for old::Wind"), "{back}");
    write(&folder, "hints.toml", NARROW);
    assert!(run(&folder, &["codegen", "--check"], 1).contains("old_to_new.rs"));
    run(&folder, &["codegen"], 0);
    let text = read(&folder, "src/conversions/old_to_new.rs");
    assert!(text.contains("- `speed` is converted to a type with fewer values"), "{text}");
}

#[test]
fn output_without_conversions_has_no_module_for_them() {
    let folder = workspace("", "");
    run(&folder, &["codegen"], 0);
    assert!(!folder.path().join("src/conversions.rs").exists());
    let root = read(&folder, "src/mod.rs");
    assert!(!root.contains("conversions"), "{root}");
}

#[test]
fn lint_reports_undecided_parts_and_unused_hints() {
    let folder = workspace(CONVERSION, "");
    let printed = run(&folder, &["lint"], 0);
    assert!(printed.contains("warning[conversion-undecided]: `Wind.speed` has a narrower type"), "{printed}");
    let ignore = "[[lint.ignore]]\nrule = \"conversion-undecided\"\npath = \"new/*\"\nreason = \"later\"\n";
    write(&folder, "uavspec.toml", &format!("{PACKAGES}{CONVERSION}{ignore}"));
    assert!(!run(&folder, &["lint"], 0).contains("[conversion-undecided]"));
    let folder = workspace(CONVERSION, &NARROW.replace("speed", "gust"));
    let printed = run(&folder, &["lint"], 0);
    let expected = "note[hint-unused]: neither message has a field or a constant `gust`";
    assert!(printed.contains(expected) && printed.contains("hints.toml:3:12"), "{printed}");
}

#[test]
fn mistakes_in_hints_are_errors() {
    let hints = "[[hint]]\nmesage = \"Wind\"\n";
    let folder = workspace(CONVERSION, hints);
    let printed = run(&folder, &["lint"], 1);
    assert!(printed.contains("error[hint-invalid]: unknown key `mesage` in a hint"), "{printed}");
    assert!(printed.contains("did you mean `message`?"), "{printed}");
    let printed = run(&folder, &["codegen"], 2);
    assert!(printed.contains("the hints contain errors") && printed.contains("hints.toml:2:1"), "{printed}");
    assert!(!folder.path().join("src").exists());
}

#[test]
fn mistakes_in_the_configuration_are_errors_with_locations() {
    for (conversion, expected) in [
        ("from = \"odl\"\nto = \"new\"", "no package `odl`; did you mean `old`?"),
        ("from = \"old\"\nto = \"other\"", "no package `other`"),
        ("from = \"old\"\nto = \"old\"", "`from` and `to` are the same package"),
        ("from = \"old\"\nto = \"pages\"", "packages of specification pages can't be converted"),
        ("from = \"old\"", "missing field `to`"),
        ("from = \"old\"\nto = \"new\"\nhint = \"x\"", "unknown field `hint`"),
        (
            "from = \"old\"\nto = \"new\"\n\n[[conversion]]\nfrom = \"new\"\nto = \"old\"",
            "the conversion between `new` and `old` is repeated",
        ),
        ("from = \"old\"\nto = \"new\"\nhints = \"absent.toml\"", "absent.toml: "),
    ] {
        let folder = workspace(&format!("[[conversion]]\n{conversion}\n"), "");
        for command in ["codegen", "lint"] {
            let printed = run(&folder, &[command], 2);
            assert!(printed.contains(expected), "{printed}");
        }
    }
}
