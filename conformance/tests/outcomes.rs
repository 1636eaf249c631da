//! Tests that all formats report the same outcome for each file.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use quick_junit::{NonSuccessKind, Report as Junit, TestCaseStatus};
use serde_json::{Value, json};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::sample::Session;
use uavspec_rules::mutants;
use uavspec_rules::sample::Flight;
use uavspec_test_support::extent;

/// The outcome of each file, by file name.
type Outcomes = BTreeMap<String, String>;

/// Writes a folder with captures, files that aren't captures, and a note. Returns the expected outcomes.
fn write_files(folder: &Path) -> Outcomes {
    let definitions = Definitions::built_in();
    let flight = Flight::new(&definitions);
    let log = flight.log().to_bytes();
    let truncated = log[..log.len() - 3].to_vec();
    let (start, end) = log.split_at(log.len() / 2);
    let gap = [start, &vec![0; 200_000], end].concat();
    let lines = flight.lines().to_bytes();
    let session = Session::new();
    let with_unknown_type =
        Session::new().then(|session| session.exchange(json!({ "type": "SOAR-LIST" }), json!({ "ids": [] })));
    let mut violated = mutants().filter(|mutant| mutant.rule.id == "PX-JSON-02");
    let violated = violated.find_map(|mutant| mutant.captures(&flight).pop()).expect("a mutant").1;
    let corrupt = [&violated[..], b"not JSON\n"].concat();
    let files: [(&str, &[u8], &str); 14] = [
        ("bag.mcap", &flight.bag().to_bytes(), "conforms"),
        ("bytes.mcap", &[0x7f, b'E', b'L', b'F', 2, 1, 1, 0, 0], "incomplete"),
        ("corrupt.jsonl", &corrupt, "does not conform"),
        ("empty.ulg", b"", "incomplete"),
        ("encrypted.ulge", b"ULogEnc\x01\0\0\0\0\0\0\0\0\x04", "incomplete"),
        ("gap.ulg", &gap, "incomplete"),
        ("good.ulg", &log, "conforms"),
        ("lines.jsonl", &lines, "conforms"),
        ("notes.ulg", b"The wind was calm.\n", "incomplete"),
        ("partial.jsonl", &with_unknown_type.to_bytes(), "partial coverage"),
        ("session.jsonl", &session.to_bytes(), "conforms"),
        ("truncated.ulg", &truncated, "incomplete"),
        ("violated.jsonl", &violated, "does not conform"),
        ("README.md", b"# Flights\n", "not checked"),
    ];
    for (name, bytes, _) in &files {
        fs::write(folder.join(name), bytes).expect("a file");
    }
    files.iter().map(|(name, _, outcome)| ((*name).to_owned(), (*outcome).to_owned())).collect()
}

/// The file name at the end of a path.
fn name(path: &str) -> String {
    path.rsplit('/').next().unwrap_or(path).to_owned()
}

/// The kind of outcome that a sentence describes.
fn kind(sentence: &str) -> String {
    let sentence = sentence.to_lowercase();
    let known = ["does not conform", "incomplete", "partial coverage", "conforms"];
    known.into_iter().find(|kind| sentence.contains(kind)).expect("an outcome").to_owned()
}

fn of_json(report: &Value) -> Outcomes {
    let text = |value: &Value| value.as_str().expect("text").to_owned();
    let subjects = report["subjects"].as_array().expect("a list").iter();
    let mut outcomes: Outcomes =
        subjects.map(|subject| (name(&text(&subject["path"])), text(&subject["outcome"]["kind"]))).collect();
    for file in report["not_checked"].as_array().expect("a list") {
        outcomes.insert(name(&text(&file["path"])), "not checked".to_owned());
    }
    outcomes
}

fn of_text(report: &str, folder: &str) -> Outcomes {
    let (sections, end) = report.rsplit_once("\nnot checked  ").expect("a list of other files");
    let mut outcomes = Outcomes::new();
    for section in sections.split(&format!("\n{folder}/")) {
        let section = section.strip_prefix(&format!("{folder}/")).unwrap_or(section);
        let name = section.split_whitespace().next().expect("a file").to_owned();
        let outcome = section.split_once("\noutcome ").expect("an outcome").1;
        outcomes.insert(name, kind(outcome.split_once("\nchecked ").map_or(outcome, |(outcome, _)| outcome)));
    }
    let listed = end.split_whitespace().next().expect("a file");
    outcomes.insert(name(listed), "not checked".to_owned());
    outcomes
}

fn of_junit(junit: &Junit) -> Outcomes {
    let mut outcomes = Outcomes::new();
    for suite in &junit.test_suites {
        let case = &suite.test_cases[0];
        let is_failed = suite.test_cases.iter().any(|case| {
            matches!(case.status, TestCaseStatus::NonSuccess { kind: NonSuccessKind::Failure, .. })
        });
        let outcome = match &case.status {
            TestCaseStatus::Skipped { .. } => "not checked".to_owned(),
            status => {
                let output = case.system_out.as_ref().expect("an output").as_str();
                let outcome = kind(output.lines().next().expect("an outcome"));
                let is_error =
                    matches!(status, TestCaseStatus::NonSuccess { kind: NonSuccessKind::Error, .. });
                assert!(is_error || outcome != "incomplete", "{outcome}: {case:?}");
                assert_eq!(is_failed, outcome == "does not conform", "{suite:?}");
                outcome
            }
        };
        outcomes.insert(name(suite.name.as_str()), outcome);
    }
    outcomes
}

/// The outcomes in a SARIF report, which contains only results. A file without results conforms.
fn of_sarif(report: &str, files: impl Iterator<Item = String>) -> Outcomes {
    let log: Value = serde_json::from_str(report).expect("JSON");
    let mut outcomes: Outcomes = files.map(|name| (name, "conforms".to_owned())).collect();
    for result in log["runs"][0]["results"].as_array().expect("a list") {
        let path = &result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"];
        let message = result["message"]["text"].as_str().expect("a message");
        let outcome = match (result["ruleId"].as_str().expect("an id"), &result["level"]) {
            ("corruption", _) => continue,
            ("incomplete", level) => {
                assert_eq!(level, "error");
                "incomplete"
            }
            ("coverage", level) => {
                assert_eq!(level, "note");
                if message.starts_with("not checked") { "not checked" } else { "partial coverage" }
            }
            (_, level) if level == "error" => "does not conform",
            _ => continue,
        };
        let known = outcomes.entry(name(path.as_str().expect("a path"))).or_default();
        if known != "does not conform" {
            outcome.clone_into(known);
        }
    }
    outcomes
}

fn of_html(report: &str) -> Outcomes {
    let table = report.split("table class=\"files\"").nth(1).expect("a table").split("</table>").next();
    let rows = table.expect("a table").split("<tr role=\"row\">").skip(2);
    let row = |row: &str| {
        let after =
            |mark: &str| row.split(mark).nth(1).and_then(|rest| rest.split_once('>')).expect("a cell").1;
        let text = |rest: &str| rest.split('<').next().expect("text").to_owned();
        (name(&text(after("<code class=\"path\""))), text(after("<span class=\"badge")))
    };
    rows.map(row).collect()
}

fn of_markdown(report: &str) -> Outcomes {
    let mut outcomes = Outcomes::new();
    for section in report.split("\n## ") {
        let (title, rest) = section.split_once("\n\n").expect("a section");
        if let Some(path) = title.strip_prefix('`') {
            outcomes.insert(name(path.trim_end_matches('`')), kind(rest.lines().next().expect("a line")));
        } else if title == "Not checked" {
            let path = rest.split('`').nth(1).expect("a path");
            outcomes.insert(name(path), "not checked".to_owned());
        }
    }
    outcomes
}

/// The reports of a run, by kind, and its exit status.
struct Run {
    reports: BTreeMap<&'static str, String>,
    status: i32,
}

impl Run {
    fn json(&self) -> Value {
        serde_json::from_str(&self.reports["json"]).expect("JSON")
    }

    fn junit(&self) -> Junit {
        Junit::deserialize_from_str(&self.reports["junit"]).expect("JUnit")
    }

    /// The exit status, and the sentence that describes the outcome.
    fn outcome(&self) -> (i32, String) {
        (self.status, self.json()["outcome"]["text"].as_str().expect("a text").to_owned())
    }
}

/// Runs `uavspec check`.
fn check(arguments: &[&str]) -> Run {
    let folder = tempfile::tempdir().expect("a folder");
    let kinds = ["text", "json", "junit", "sarif", "html", "markdown"];
    let targets = kinds.map(|kind| format!("{kind}={}", folder.path().join(kind).display()));
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    let run = command.args(["check", "--report", &targets.join(",")]).args(arguments).output();
    let status = run.expect("uavspec runs").status.code().expect("an exit status");
    let read = |kind| (kind, fs::read_to_string(folder.path().join(kind)).expect("a report"));
    Run { reports: kinds.map(read).into(), status }
}

#[test]
fn all_formats_report_the_same_outcomes() {
    let folder = tempfile::tempdir().expect("a folder");
    let expected = write_files(folder.path());
    let path = folder.path().to_str().expect("UTF-8");
    let run = check(&[path]);
    let (status, sentence) = run.outcome();
    assert!(status == 1 && sentence.ends_with(" (2 of 13 files)"), "{status} {sentence}");
    assert_eq!(of_json(&run.json()), expected);
    assert_eq!(of_text(&run.reports["text"], path), expected);
    assert_eq!(of_junit(&run.junit()), expected);
    assert_eq!(of_sarif(&run.reports["sarif"], expected.keys().cloned()), expected);
    assert_eq!(of_html(&run.reports["html"]), expected);
    let markdown = of_markdown(&run.reports["markdown"]);
    assert_eq!(markdown.len(), 13, "the last of 13 sections is omitted");
    assert!(markdown.iter().all(|(name, outcome)| expected[name] == *outcome), "{markdown:?}");
}

#[test]
fn text_fits_a_terminal() {
    let folder = tempfile::tempdir().expect("a folder");
    write_files(folder.path());
    let run = check(&[folder.path().to_str().expect("UTF-8")]);
    for line in run.reports["text"].lines() {
        let has_long_word = line.split_whitespace().any(|word| word.chars().count() > 50);
        assert!(line.chars().count() <= 80 || has_long_word, "{line}");
    }
}

#[test]
fn the_exit_status_of_each_file_is_its_outcome() {
    let folder = tempfile::tempdir().expect("a folder");
    let expected = write_files(folder.path());
    // Even the larger step of quick mode includes files with different outcomes.
    for (name, outcome) in expected.iter().skip(extent(0, 1)).step_by(extent(1, 4)) {
        let path = folder.path().join(name);
        let path = path.to_str().expect("UTF-8");
        let status = match outcome.as_str() {
            "conforms" | "partial coverage" => 0,
            "does not conform" => 1,
            // A file that is named explicitly is always checked.
            _ => 6,
        };
        let (found, sentence) = check(&[path]).outcome();
        assert_eq!(found, status, "{name}: {sentence}");
        let allowed = check(&["--allow-incomplete", path]);
        let expected = (if status == 6 { 0 } else { status }, sentence);
        assert_eq!(allowed.outcome(), expected, "{name}: the reason stays");
        let junit = allowed.junit();
        assert_eq!(junit.test_suites[0].failures > 0, status == 1, "{name}");
        // Parts of a file that doesn't conform may also be unreadable.
        if status == 6 {
            assert_eq!(junit.test_suites[0].errors, 0, "{name}");
        }
    }
}

#[test]
fn options_change_the_outcome() {
    let folder = tempfile::tempdir().expect("a folder");
    write_files(folder.path());
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let partial = path("partial.jsonl");
    assert_eq!(check(&["--min-coverage", "97%", &partial]).status, 0);
    let text = "Incomplete: 40 of 41 types fully checked (97 %), less than 98 %";
    assert_eq!(check(&["--min-coverage=98", &partial]).outcome(), (6, text.to_owned()));
    assert_eq!(check(&["--min-coverage=100%", &path("good.ulg")]).status, 0);

    let definitions = Definitions::built_in();
    let flight = Flight::new(&definitions);
    let mutant = mutants().find(|mutant| mutant.rule.id == "PX-RANGE-01").expect("a mutant");
    let (_, warned) = mutant.captures(&flight).pop().expect("a capture");
    let file = path("warned");
    fs::write(&file, warned).expect("a file");
    assert_eq!(check(&[&file]).outcome(), (0, "Conforms, with 1 warning".to_owned()));
    let denied = check(&["--deny", "warning", &file]);
    assert_eq!(denied.outcome(), (1, "Does not conform: 0 MUST, 1 SHOULD".to_owned()));
    assert_eq!(denied.junit().test_suites[0].failures, 1);
}

#[test]
fn a_folder_without_captures_checks_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().to_str().expect("UTF-8");
    fs::write(folder.path().join("README.md"), "# Flights\n").expect("a file");
    let run = check(&[path]);
    assert_eq!(run.outcome(), (5, "Nothing was checked".to_owned()));
    assert_eq!(run.json()["not_checked"].as_array().map(Vec::len), Some(1));
    let definitions = Definitions::built_in();
    let log = tempfile::Builder::new().suffix(".ulg").tempfile().expect("a file");
    fs::write(log.path(), Flight::new(&definitions).log().to_bytes()).expect("a file");
    assert_eq!(check(&[path, log.path().to_str().expect("UTF-8")]).status, 3, "an argument has no captures");
}
