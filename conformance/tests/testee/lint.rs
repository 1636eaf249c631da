//! Tests of `testee lint`: the reference testee passes, and each check detects a faulty testee.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use uavspec_check::parallel;
use uavspec_probe::testee::{CHECKS, Check, LintResult, Options, check, lint};

use super::{built_in, impatient, options, patiently, suite, testee};

/// Modes that always misbehave in the same way, each with all checks that fail.
const DETERMINISTIC: &[(&[&str], &[&str])] = &[
    (&["exit"], &["introduction"]),
    (&["bad-hello"], &["introduction"]),
    (&["hello-protocol"], &["introduction"]),
    (&["hello-unknown-op"], &["hello-members"]),
    (&["hello-unknown-format"], &["hello-members"]),
    (&["hello-no-version"], &["hello-members"]),
    (&["hello-odd-type"], &["hello-members"]),
    (&["crash-second-hello"], &["second-hello"]),
    (&["late"], &["answers-have-ids"]),
    (&["repeat"], &["one-answer-each"]),
    (&["short-ids"], &["ids-of-any-size"]),
    (&["unsigned-ids"], &["ids-of-any-size"]),
    (&["short-buffer"], &["long-question"]),
    (&["accept-unknown-op"], &["unknown-op"]),
    (&["silent-unknown-op"], &["unknown-op"]),
    (&["reject-unknown"], &["unknown-op", "unknown-type", "unknown-format"]),
    (&["guess-format"], &["unknown-format"]),
    (&["guess-member"], &["missing-member"]),
    (&["reject-missing"], &["missing-member"]),
    (&["crash-empty"], &["empty-line"]),
    (&["crash-not-json"], &["not-json"]),
    (&["crash-not-utf8"], &["not-utf8"]),
    (&["untagged-integers"], &["tagged-integers"]),
    (&["untagged-floats"], &["tagged-floats"]),
    (&["ignore-tags"], &["tagged-integers"]),
    (&["ends-badly"], &["ends-by-itself"]),
    (&["chatty"], &["only-answers"]),
];

/// Modes whose failures differ between runs, each with the checks that always fail. The fifth request of a session has
/// the id 1005.
const UNPREDICTABLE: &[(&[&str], &[&str])] = &[
    (&["crash", "1005"], &["answers-have-ids", "one-answer-each"]),
    (&["hang", "1005"], &["one-answer-each"]),
    (&["wrong-id", "1005"], &["answers-have-ids"]),
    (&["babble", "1005"], &["answers-have-ids", "one-answer-each"]),
    (&["not-utf8", "1005"], &["one-answer-each", "only-answers"]),
    (&["endless", "1005"], &["one-answer-each", "only-answers"]),
    (&["first-line-of-read"], &["questions-in-one-write"]),
    (&["read-is-line"], &["question-in-many-writes"]),
    (&["later", "1008"], &["answers-before-end"]),
    (&["stays"], &["ends-by-itself"]),
];

pub(super) fn lint_testee(options: &Options, only: &[&Check]) -> LintResult {
    let suite = suite();
    lint(&suite.cases, &suite.types, options, only, &|_, _| {}).expect("a testee")
}

pub(super) fn failed_checks(found: &LintResult) -> BTreeSet<&'static str> {
    let failed = found.outcomes.iter().filter(|(_, outcome)| outcome.name() == "fail");
    failed.map(|(check, _)| check.id).collect()
}

#[track_caller]
pub(super) fn assert_good(found: &LintResult) {
    let bad: Vec<_> = found.outcomes.iter().filter(|(_, outcome)| outcome.name() == "fail").collect();
    let bad: Vec<_> = bad.iter().map(|(check, outcome)| (check.id, outcome)).collect();
    assert!(found.is_ok() && bad.is_empty(), "{bad:?}");
}

#[test]
fn the_reference_testee_passes_lint() {
    let found = lint_testee(&options(&[]), &[]);
    assert_eq!(found.outcomes.len(), CHECKS.len());
    for (check, outcome) in &found.outcomes {
        assert_eq!(outcome.name(), "pass", "{}: {outcome:?}", check.id);
    }
}

#[test]
fn accepts_split_writes_long_standard_error_and_any_order() {
    for mode in [&["split"][..], &["flood"], &["later", "1003"]] {
        let only = ["answers-have-ids", "one-answer-each", "only-answers"];
        let only: Vec<&Check> = only.iter().map(|id| check(id).expect("a check")).collect();
        assert_good(&lint_testee(&options(mode), &only));
    }
}

#[test]
fn each_mode_fails_exactly_its_checks() {
    patiently(|clock| {
        let try_one = |(mode, _): &(&[&str], _)| lint_testee(&impatient(mode, clock), &[]);
        parallel::each(DETERMINISTIC, None, try_one, |(mode, expected), found| {
            assert_eq!(failed_checks(&found), expected.iter().copied().collect(), "{mode:?}");
        });
    });
}

#[test]
fn detects_unpredictable_testees() {
    patiently(|clock| {
        let try_one = |(mode, expected): &(&[&str], &[&str])| {
            let only: Vec<&Check> = expected.iter().map(|id| check(id).expect("a check")).collect();
            lint_testee(&impatient(mode, clock), &only)
        };
        parallel::each(UNPREDICTABLE, None, try_one, |(mode, expected), found| {
            assert_eq!(failed_checks(&found), expected.iter().copied().collect(), "{mode:?}");
        });
    });
}

#[test]
fn every_check_fails_for_some_testee() {
    let all: BTreeSet<&str> =
        DETERMINISTIC.iter().chain(UNPREDICTABLE).flat_map(|(_, caught)| caught.iter().copied()).collect();
    assert_eq!(all, CHECKS.iter().map(|check| check.id).collect());
}

fn uavspec(arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    let output = command.args(["testee", "lint"]).args(arguments).output().expect("uavspec runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn the_exit_status_reflects_the_lint_result() {
    let testee = testee().to_str().expect("UTF-8");
    let (status, printed, output) = uavspec(&["--only", "unknown-op,unknown-type", "--", testee]);
    assert_eq!(output, "", "progress is shown on terminals only");
    assert!(status == Some(0) && printed.ends_with("follows the protocol\n"), "{printed}");
    assert!(printed.contains("3 passed, 0 failed, 0 not applicable"), "{printed}");
    let (status, printed, _) = uavspec(&["--only", "unknown-op", "--", testee, "accept-unknown-op"]);
    assert!(status == Some(1) && printed.ends_with("violates the protocol\n"), "{printed}");
    assert!(
        printed
            .contains("\"levitate\" is \"ok\", expected \"unsupported\" or \"error\"\n      help: respond"),
        "{printed}"
    );
    let (status, printed, _) = uavspec(&["--format", "json", "--", testee, "exit"]);
    let report: Value = serde_json::from_str(&printed).expect("JSON");
    assert_eq!((status, &report["version"], &report["testee"]), (Some(1), &1.into(), &Value::Null));
    assert_eq!(report["checks"].as_array().map(Vec::len), Some(CHECKS.len()));
    assert_eq!(report["checks"][0]["verdict"], "fail");
    let message = report["checks"][0]["message"].as_str().expect("a message");
    assert!(message.contains('7') && message.ends_with("out of cheese"), "{message}");
    let (status, _, output) = uavspec(&["--", "/nowhere/at/all"]);
    assert!(status == Some(3) && output.contains("can't start /nowhere/at/all"), "{output}");
    let (status, _, output) = uavspec(&["--only", "politeness", "--", testee]);
    assert!(status == Some(2) && output.contains("use one of introduction, "), "{output}");
    for usage in [&[][..], &["--attach", "localhost", "--"], &["--attach", "localhost:7700", "--", testee]] {
        assert_eq!(uavspec(usage).0, Some(2), "{usage:?}");
    }
}

#[test]
fn checks_of_unsupported_features_are_not_applicable() {
    let folder = tempfile::tempdir().expect("a folder");
    let wind = "uint64 timestamp  # [us] Time\nuint16 speed  # [cm/s] Speed\n";
    std::fs::write(folder.path().join("Wind.msg"), wind).expect("a file");
    let folder = folder.path().to_str().expect("UTF-8");
    let testee = testee().to_str().expect("UTF-8");
    // The reference testee of this repository doesn't support the message, but still receives requests.
    let (status, printed, output) = uavspec(&["--definitions", folder, "--", testee]);
    assert!(
        status == Some(0) && printed.contains("\n\n16 passed, 0 failed, 5 not applicable"),
        "{printed}{output}"
    );
    // With these definitions, the testee supports the message. The message has no floats.
    let (status, printed, output) =
        uavspec(&["--definitions", folder, "--", testee, "--definitions", folder]);
    assert!(
        status == Some(0) && printed.contains("\n\n20 passed, 0 failed, 1 not applicable"),
        "{printed}{output}"
    );
}

/// Lints a testee that is written in another language.
fn check_testee(command: &[&str], script: &str) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("testees").join(script);
    let command = command.iter().map(Into::into).chain([script.into()]).collect();
    let options = Options { target: super::Target::Command(command), ..options(&[]) };
    let suite = built_in();
    let found = lint(&suite.cases, &suite.types, &options, &[], &|_, _| {}).expect("a testee");
    assert_good(&found);
    let other: Vec<&str> =
        found.outcomes.iter().filter(|(_, it)| it.name() != "pass").map(|(it, _)| it.id).collect();
    assert_eq!(other, ["tagged-floats"], "their types have no floats");
}

#[test]
#[ignore = "requires Python"]
fn the_python_testee_passes_lint() {
    check_testee(&["python3", "-B"], "python/testee.py");
}

#[test]
#[ignore = "requires Node"]
fn the_javascript_testee_passes_lint() {
    check_testee(&["node"], "node/testee.js");
}

/// The responses of the testee to these requests.
fn replies(requests: &[Value]) -> Vec<Value> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("requests");
    std::fs::write(&path, requests.iter().map(|it| format!("{it}\n")).collect::<String>()).expect("a file");
    let input = std::fs::File::open(&path).expect("a file");
    let run = Command::new(testee()).stdin(input).output().expect("the testee runs");
    let replies = String::from_utf8(run.stdout).expect("UTF-8");
    replies.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

#[test]
fn the_examples_in_the_readme_are_correct() {
    let page = include_str!("../../testees/README.md");
    let lines = |mark: &str| -> Vec<Value> {
        let lines = page.lines().filter_map(|line| line.strip_prefix(mark));
        lines.map(|line| serde_json::from_str(line).expect(line)).collect()
    };
    let (requests, documented) = (lines("→ "), lines("← "));
    let actual = replies(&requests);
    assert_eq!((documented.len(), actual.len()), (6, 6));
    for (documented, actual) in documented.iter().zip(&actual) {
        let names = |reply: &Value| -> BTreeSet<String> {
            reply.as_object().expect("an object").keys().cloned().collect()
        };
        assert_eq!((names(documented), &documented["id"]), (names(actual), &actual["id"]));
        // The text of a reason may be anything.
        assert_eq!(documented.get("ok"), actual.get("ok"));
    }
}
