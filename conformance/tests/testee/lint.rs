//! Manners: the reference has them, and each check catches a testee that lacks them.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use serde_json::Value;
use uavspec_conformance::check::parallel;
use uavspec_conformance::testee::{CHECKS, Check, Found, Options, check, lint};

use super::{impatient, options, suite, testee};

/// Ways to misbehave over everything, each with all the checks that catch it.
const RUDE: &[(&[&str], &[&str])] = &[
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

/// Ways that break whatever is asked then, or only sometimes, with checks that catch them in any case. The fifth
/// question of a session has the id 1005.
const WILD: &[(&[&str], &[&str])] = &[
    (&["crash", "1005"], &["answers-have-ids", "one-answer-each"]),
    (&["hang", "1005"], &["one-answer-each"]),
    (&["wrong-id", "1005"], &["answers-have-ids"]),
    (&["not-utf8", "1005"], &["one-answer-each", "only-answers"]),
    (&["endless", "1005"], &["one-answer-each", "only-answers"]),
    (&["first-line-of-read"], &["questions-in-one-write"]),
    (&["read-is-line"], &["question-in-many-writes"]),
    (&["later", "1008"], &["answers-before-end"]),
    (&["stays"], &["ends-by-itself"]),
];

pub(super) fn manners(options: &Options, only: &[&Check]) -> Found {
    let suite = suite();
    lint(&suite.cases, &suite.types, options, only, &|_, _| {}).expect("a testee")
}

pub(super) fn caught(found: &Found) -> BTreeSet<&'static str> {
    let failed = found.outcomes.iter().filter(|(_, outcome)| outcome.name() == "fail");
    failed.map(|(check, _)| check.id).collect()
}

#[track_caller]
pub(super) fn assert_good(found: &Found) {
    let bad: Vec<_> = found.outcomes.iter().filter(|(_, outcome)| outcome.name() == "fail").collect();
    let bad: Vec<_> = bad.iter().map(|(check, outcome)| (check.id, outcome)).collect();
    assert!(found.is_ok() && bad.is_empty(), "{bad:?}");
}

#[test]
fn the_reference_has_manners() {
    let found = manners(&options(&[]), &[]);
    assert_eq!(found.outcomes.len(), CHECKS.len());
    for (check, outcome) in &found.outcomes {
        assert_eq!(outcome.name(), "pass", "{}: {outcome:?}", check.id);
    }
}

#[test]
fn split_writes_floods_and_any_order_are_no_bad_manners() {
    for mode in [&["split"][..], &["flood"], &["later", "1003"]] {
        let only = ["answers-have-ids", "one-answer-each", "only-answers"];
        let only: Vec<&Check> = only.iter().map(|id| check(id).expect("a check")).collect();
        assert_good(&manners(&options(mode), &only));
    }
}

#[test]
fn bad_manners_are_caught_by_the_checks_for_them_and_no_others() {
    let try_one = |(mode, _): &(&[&str], _)| manners(&impatient(mode), &[]);
    parallel::each(RUDE, None, try_one, |(mode, expected), found| {
        assert_eq!(caught(&found), expected.iter().copied().collect(), "{mode:?}");
    });
}

#[test]
fn wild_testees_are_caught() {
    let try_one = |(mode, expected): &(&[&str], &[&str])| {
        let only: Vec<&Check> = expected.iter().map(|id| check(id).expect("a check")).collect();
        manners(&impatient(mode), &only)
    };
    parallel::each(WILD, None, try_one, |(mode, expected), found| {
        assert_eq!(caught(&found), expected.iter().copied().collect(), "{mode:?}");
    });
}

#[test]
fn reports_a_silent_testee() {
    let found =
        manners(&Options { start_timeout: Duration::from_millis(200), ..options(&["no-hello"]) }, &[]);
    assert_eq!(caught(&found), BTreeSet::from(["introduction"]));
    let others = &found.outcomes[1..];
    assert!(
        others.iter().all(|(_, outcome)| outcome.name() == "not applicable"),
        "nothing else can be tried"
    );
}

#[test]
fn every_check_catches_somebody() {
    let all: BTreeSet<&str> =
        RUDE.iter().chain(WILD).flat_map(|(_, caught)| caught.iter().copied()).collect();
    assert_eq!(all, CHECKS.iter().map(|check| check.id).collect());
}

fn uavspec(arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    let output = command.args(["testee", "lint"]).args(arguments).output().expect("uavspec runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn the_exit_status_is_the_outcome_of_lint() {
    let testee = testee().to_str().expect("UTF-8");
    let (status, printed, output) = uavspec(&["--only", "unknown-op,unknown-type", "--", testee]);
    assert_eq!(output, "", "progress is shown on terminals only");
    assert!(status == Some(0) && printed.ends_with("keeps to the protocol\n"), "{printed}");
    assert!(printed.contains("3 passed, 0 failed, 0 not applicable"), "{printed}");
    let (status, printed, _) = uavspec(&["--only", "unknown-op", "--", testee, "accept-unknown-op"]);
    assert!(status == Some(1) && printed.ends_with("breaks the protocol\n"), "{printed}");
    assert!(printed.contains("\"levitate\" is answered with \"ok\"\n      help: answer"), "{printed}");
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
    assert!(status == Some(2) && output.contains("there are introduction, "), "{output}");
    for usage in [&[][..], &["--attach", "localhost", "--"], &["--attach", "localhost:7700", "--", testee]] {
        assert_eq!(uavspec(usage).0, Some(2), "{usage:?}");
    }
}

#[test]
fn what_a_testee_does_not_know_is_not_applicable() {
    let folder = tempfile::tempdir().expect("a folder");
    let wind = "uint64 timestamp  # [us] Time\nuint16 speed  # [cm/s] Speed\n";
    std::fs::write(folder.path().join("Wind.msg"), wind).expect("a file");
    let folder = folder.path().to_str().expect("UTF-8");
    let testee = testee().to_str().expect("UTF-8");
    // The reference for this repository knows no such message: it is asked all the same.
    let (status, printed, output) = uavspec(&["--definitions", folder, "--", testee]);
    assert!(
        status == Some(0) && printed.contains("\n\n16 passed, 0 failed, 5 not applicable"),
        "{printed}{output}"
    );
    // It knows it now, but there are no floats in it.
    let (status, printed, output) =
        uavspec(&["--definitions", folder, "--", testee, "--definitions", folder]);
    assert!(
        status == Some(0) && printed.contains("\n\n20 passed, 0 failed, 1 not applicable"),
        "{printed}{output}"
    );
}

/// Testees in other languages.
fn of_language(command: &[&str], script: &str) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("testees").join(script);
    let command = command.iter().map(Into::into).chain([script.into()]).collect();
    let found = manners(&Options { target: super::Target::Command(command), ..options(&[]) }, &[]);
    assert_good(&found);
    let other: Vec<&str> =
        found.outcomes.iter().filter(|(_, it)| it.name() != "pass").map(|(it, _)| it.id).collect();
    assert_eq!(other, ["tagged-floats"], "none of their types has any");
}

#[test]
#[ignore = "needs python3"]
fn the_testee_in_python_has_manners() {
    of_language(&["python3", "-B"], "python/testee.py");
}

#[test]
#[ignore = "needs node"]
fn the_testee_in_javascript_has_manners() {
    of_language(&["node"], "node/testee.js");
}

/// What the testee says to lines, a reply for each.
fn replies(questions: &[Value]) -> Vec<Value> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("questions");
    std::fs::write(&path, questions.iter().map(|it| format!("{it}\n")).collect::<String>()).expect("a file");
    let input = std::fs::File::open(&path).expect("a file");
    let run = Command::new(testee()).stdin(input).output().expect("it runs");
    let replies = String::from_utf8(run.stdout).expect("UTF-8");
    replies.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

#[test]
fn the_conversation_in_the_documentation_takes_place() {
    let page = include_str!("../../testees/README.md");
    let lines = |mark: &str| -> Vec<Value> {
        let lines = page.lines().filter_map(|line| line.strip_prefix(mark));
        lines.map(|line| serde_json::from_str(line).expect(line)).collect()
    };
    let (questions, documented) = (lines("→ "), lines("← "));
    let actual = replies(&questions);
    assert_eq!((documented.len(), actual.len()), (6, 6));
    for (documented, actual) in documented.iter().zip(&actual) {
        let names = |reply: &Value| -> BTreeSet<String> {
            reply.as_object().expect("an object").keys().cloned().collect()
        };
        assert_eq!((names(documented), &documented["id"]), (names(actual), &actual["id"]));
        // The words of a reason are anybody's own.
        assert_eq!(documented.get("ok"), actual.get("ok"));
    }
}
