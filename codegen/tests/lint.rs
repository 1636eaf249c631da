//! Each rule of `lint`: its examples, and definitions that break it, with all that is said of them.
//!
//! The bad example of a rule gives what `fixtures/lint/<rule>.txt` holds, and the good one nothing of that
//! rule. Where it is mended, the good one comes of it. `fixtures/lint/<rule>-<case>/` holds definitions of
//! one more case, and in `expected.txt` what the rule says of them. After a change that is meant:
//! `UAVSPEC_UPDATE_FIXTURES=1 cargo test --test lint`.

mod support;

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use uavspec_codegen::diagnostic::render;
use uavspec_codegen::finding::Finding;
use uavspec_codegen::lint::{Example, Preset, RULES, Rule, Settings, apply, lint};
use uavspec_codegen::msg::{Dialect, Kind};
use uavspec_codegen::schema::Form;
use uavspec_codegen::{PackageInput, SourceMap};

use support::{files_below, package};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/lint")
}

fn strict() -> Settings {
    Settings { preset: Preset::Strict, ..Settings::default() }
}

/// What all rules say of some files: paths and texts.
fn judge(files: &[(String, String)]) -> (SourceMap, Vec<Finding>) {
    let mut sources = SourceMap::default();
    let mut messages = package("demo", Form::Msg(Dialect::Px4));
    let mut ros2 = package("ros2", Form::Msg(Dialect::Ros2));
    let mut pages = package("pages", Form::Table);
    for (path, text) in files {
        let id = sources.add(path.as_str(), text.clone().into_bytes()).expect("a text");
        let package: &mut PackageInput = match Kind::of(path) {
            Some(_) if path.starts_with("ros2/") => &mut ros2,
            Some(_) => &mut messages,
            None => &mut pages,
        };
        package.sources.push(id);
    }
    let findings = lint(&sources, &[messages, pages, ros2], &strict());
    (sources, findings)
}

fn judge_example(example: Example) -> (SourceMap, Vec<Finding>) {
    judge(&[(example.path.to_owned(), example.text.to_owned())])
}

fn of_rule(findings: Vec<Finding>, rule: &str) -> Vec<Finding> {
    findings.into_iter().filter(|finding| finding.rule == rule).collect()
}

/// What is wrong with `found`; nothing, where the file at `path` holds it.
fn compare(path: &Path, found: &str) -> Option<String> {
    let expected = fs::read_to_string(path).unwrap_or_default();
    if found == expected {
        return None;
    }
    if std::env::var_os("UAVSPEC_UPDATE_FIXTURES").is_some() {
        fs::write(path, found).expect("a writable file");
        return None;
    }
    Some(format!("{}: found\n{found}and not\n{expected}", path.display()))
}

fn check_examples(rule: &Rule) -> Vec<String> {
    let mut failures = Vec::new();
    let (sources, findings) = judge_example(rule.bad);
    let findings = of_rule(findings, rule.id);
    if findings.is_empty() {
        failures.push(format!("{}: nothing is found in the bad example", rule.id));
    }
    let found = render::findings(&findings, &sources, false);
    failures.extend(compare(&fixtures().join(format!("{}.txt", rule.id)), &found));
    if findings.iter().any(|finding| !finding.fix.is_empty()) {
        let mended: Vec<String> = apply(&findings, &sources).into_values().collect();
        if mended != [rule.good.text] {
            failures.push(format!("{}: mended to\n{}", rule.id, mended.concat()));
        }
    }
    let (sources, findings) = judge_example(rule.good);
    let findings = of_rule(findings, rule.id);
    if !findings.is_empty() {
        failures.push(format!("{}, good: {}", rule.id, render::findings(&findings, &sources, false)));
    }
    failures
}

#[test]
fn each_rule_finds_its_bad_example_and_not_its_good_one() {
    let failures: Vec<String> = RULES.iter().flat_map(|rule| check_examples(rule)).collect();
    assert!(
        failures.is_empty(),
        "{}\nUAVSPEC_UPDATE_FIXTURES=1 takes what is said for expected",
        failures.join("\n")
    );
}

/// The rule that a folder is named after. Ids may start with other ids: the longest counts.
fn rule_of(case: &str) -> Option<&'static Rule> {
    let starts = |rule: &&&Rule| case.strip_prefix(rule.id).is_some_and(|rest| rest.starts_with('-'));
    RULES.iter().filter(starts).max_by_key(|rule| rule.id.len()).copied()
}

#[test]
fn each_further_case_says_what_is_expected() {
    let mut failures = String::new();
    for entry in fs::read_dir(fixtures()).expect("fixtures") {
        let folder = entry.expect("an entry").path();
        let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
        if !folder.is_dir() {
            assert!(RULES.iter().any(|rule| name == format!("{}.txt", rule.id)), "{name}: of no rule");
            continue;
        }
        let rule = rule_of(&name).unwrap_or_else(|| panic!("{name}: of no rule"));
        let files: Vec<(String, String)> = files_below(&folder, &["msg", "srv", "action", "md", "adoc"])
            .iter()
            .map(|file| {
                let path = file.strip_prefix(&folder).expect("below").to_string_lossy().replace('\\', "/");
                (path, fs::read_to_string(file).expect("a text"))
            })
            .collect();
        let (sources, findings) = judge(&files);
        let found = render::findings(&of_rule(findings, rule.id), &sources, false);
        if let Some(failure) = compare(&folder.join("expected.txt"), &found) {
            writeln!(failures, "{failure}").expect("a string");
        }
    }
    assert!(failures.is_empty(), "{failures}UAVSPEC_UPDATE_FIXTURES=1 takes what is said for expected");
}
