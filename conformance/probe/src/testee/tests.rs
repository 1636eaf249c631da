//! Tests of testees in memory that don't work: each run ends soon, and reports the reason.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use serde_json::{Value, json};
use uavspec_model::clock::Clock;

use super::case::tests::{CASES as ALL, DEFINITIONS};
use super::lint::{CHECKS, CheckOutcome, LintResult, lint};
use super::memory::Program;
use super::{Case, Op, Options, Outcome, Target, Verdict, run};

/// The type of all cases.
const TYPE: &str = "px4/Event";

static CASES: LazyLock<Vec<Case>> = LazyLock::new(|| {
    let cases: Vec<&Case> = ALL.iter().filter(|case| case.type_name == TYPE).collect();
    assert!(cases.len() > 50);
    cases.into_iter().cycle().take(500).cloned().collect()
});

fn hello() -> Value {
    let ops: Vec<&str> = Op::ALL.into_iter().map(Op::name).collect();
    json!({ "op": "hello", "name": "calm", "version": "1", "ops": ops, "types": [TYPE] })
}

/// A testee whose lines are returned by a function. The arguments of the function are the id of a request, and the
/// number of requests that the process has received.
fn testee(answer: impl Fn(u64, u32) -> Option<Vec<String>> + Copy + Send + Sync + 'static) -> Options {
    let program = Program::new(move || {
        let mut count = 0;
        Box::new(move |line| {
            let request: Value = serde_json::from_slice(line).unwrap_or_default();
            if request["op"] == "hello" {
                return Some(vec![hello().to_string()]);
            }
            count += 1;
            answer(request["id"].as_u64().unwrap_or_default(), count)
        })
    });
    in_memory(program)
}

fn in_memory(program: Program) -> Options {
    Options { clock: Clock::simulated(), ..Options::new(Target::Memory(program)) }
}

/// Runs all cases. Returns the outcome, the reason why the run ended early, and the elapsed time.
fn tested(options: &Options) -> (Outcome<'static>, String, Duration) {
    let (start, selected) = (options.clock.now(), (0..CASES.len()).collect::<Vec<_>>());
    let outcome = run(&CASES, &selected, DEFINITIONS.types(), options, &|_, _| {}).expect("a valid hello");
    let why = outcome.gave_up.clone().unwrap_or_default();
    (outcome, why, options.clock.now() - start)
}

/// Runs all checks. Returns the result and the elapsed time.
fn linted(options: &Options) -> (LintResult, Duration) {
    let start = options.clock.now();
    let found = lint(&CASES, DEFINITIONS.types(), options, &[], &|_, _| {}).expect("a testee");
    (found, options.clock.now() - start)
}

/// The ids of the checks that failed, and the outcome of the last check.
fn failed(found: &LintResult) -> (Vec<&'static str>, &CheckOutcome) {
    let failed = found.outcomes.iter().filter(|(_, outcome)| matches!(outcome, CheckOutcome::Fail(_)));
    assert_eq!(found.outcomes.len(), CHECKS.len());
    (failed.map(|(check, _)| check.id).collect(), &found.outcomes[CHECKS.len() - 1].1)
}

#[test]
fn gives_up_on_a_testee_that_never_responds() {
    let (outcome, why, time) = tested(&testee(|_, _| Some(Vec::new())));
    let expected = "gave up after 3 consecutive timeouts of 5 s; requests without a response: 32, requests that were \
                    not sent: 468";
    assert_eq!((why.as_str(), time.as_secs()), (expected, 15));
    // Many requests are pending at the first timeout.
    assert_eq!((outcome.counts().failed, outcome.counts().not_run), (2, 498));
    assert_eq!(outcome.restarts, 2);
}

#[test]
fn gives_up_on_a_testee_that_responds_once() {
    let unsupported = |id: u64| format!("{{\"id\":{id},\"unsupported\":true}}");
    let (_, why, time) =
        tested(&testee(move |id, count| Some((count == 1).then(|| unsupported(id)).into_iter().collect())));
    assert!(why.starts_with("gave up after 9 timeouts of 5 s; "), "{why}");
    assert_eq!(time.as_secs(), 45);
    // A single case that hangs isn't a reason to give up.
    let options = testee(move |id, _| Some((id != 100).then(|| unsupported(id)).into_iter().collect()));
    let (outcome, why, time) = tested(&options);
    assert_eq!((why.as_str(), outcome.counts().failed, outcome.counts().not_run), ("", 1, 0));
    assert!(time.as_secs() <= 15, "{time:?}");
}

#[test]
fn gives_up_on_a_testee_that_crashes_in_every_case() {
    let (outcome, why, _) = tested(&testee(|_, _| None));
    assert!(why.starts_with("gave up after 100 consecutive crashes; "), "{why}");
    assert_eq!(outcome.counts().failed, 100);
}

/// Options with a limit on the length of lines that results in small values for the other limits: 16 bytes without a
/// response, and 8,192 wrong bytes.
fn limited(options: Options) -> Options {
    Options { line_limit: 1 << 10, ..options }
}

#[test]
fn ends_a_testee_that_writes_only_other_lines() {
    let options = limited(testee(|_, _| Some(vec!["calm".to_owned(); 1_000])));
    let (outcome, why, time) = tested(&options);
    let crashed = outcome.verdicts.iter().find_map(|(_, verdict)| match verdict {
        Verdict::Crashed { how, .. } => Some(how.as_str()),
        _ => None,
    });
    assert_eq!(crashed, Some("the testee sent more than 16 bytes without a response"));
    assert!(why.starts_with("gave up after 100 consecutive crashes; "), "{why}");
    assert_eq!(time, Duration::ZERO);
    let (found, time) = linted(&options);
    let (failures, _) = failed(&found);
    assert!(failures.contains(&"one-answer-each") && !failures.contains(&"introduction"), "{failures:?}");
    assert_eq!(time, Duration::ZERO);
}

#[test]
fn gives_up_on_long_wrong_responses() {
    let long = |id, _| Some(vec![format!("{{\"id\":{id},\"error\":\"{}\"}}", "x".repeat(1_000))]);
    let (outcome, why, time) = tested(&limited(testee(long)));
    assert!(why.starts_with("gave up after 8192 bytes of wrong responses and other lines; "), "{why}");
    assert_eq!((outcome.counts().failed, outcome.restarts, time), (9, 0, Duration::ZERO));
    // Each line is longer than the limit.
    let longer = |id, _| Some(vec![format!("{{\"id\":{id},\"error\":\"{}\"}}", "x".repeat(1_024))]);
    let (outcome, why, time) = tested(&limited(testee(longer)));
    assert!(why.starts_with("gave up after 8192 bytes of wrong responses and other lines; "), "{why}");
    assert!(outcome.restarts < 10 && time == Duration::ZERO, "{}", outcome.restarts);
}

#[test]
fn lint_gives_up_on_a_testee_that_never_responds() {
    let (found, time) = linted(&testee(|_, _| Some(Vec::new())));
    let (failures, last) = failed(&found);
    assert_eq!(failures, ["second-hello", "answers-have-ids", "one-answer-each"]);
    let why = "not checked: gave up after 3 consecutive timeouts of 5 s";
    assert_eq!((last, time.as_secs()), (&CheckOutcome::NotApplicable(why.to_owned()), 15));
}

#[test]
fn lint_continues_if_only_some_requests_have_no_response() {
    // The lines for other requests contain no type or no format.
    let program = Program::new(|| {
        Box::new(|line| {
            let request: Value = serde_json::from_slice(line).unwrap_or_default();
            let is_known = request["op"] != "levitate" && request["type"] == TYPE;
            let is_known = is_known && request["format"] != "morse";
            Some(match &request["id"] {
                _ if request["op"] == "hello" => vec![hello().to_string()],
                id if is_known => vec![json!({ "id": id, "error": "calm" }).to_string()],
                _ => Vec::new(),
            })
        })
    });
    let (found, _) = linted(&in_memory(program));
    let (failures, last) = failed(&found);
    assert!(["unknown-op", "unknown-type", "unknown-format"].iter().all(|id| failures.contains(id)));
    assert_eq!(last, &CheckOutcome::Pass);
}

#[test]
fn reports_a_missing_hello_in_time() {
    let silent = in_memory(Program::new(|| Box::new(|_| Some(Vec::new()))));
    let error =
        run(&CASES, &[0], DEFINITIONS.types(), &silent, &|_, _| {}).map(|_| ()).expect_err("no hello");
    assert_eq!(error, "no valid hello from memory: no response within 30 s");
    let (found, time) = linted(&silent);
    let (failures, last) = failed(&found);
    assert_eq!((failures, time.as_secs()), (vec!["introduction"], 30));
    assert_eq!(last, &CheckOutcome::NotApplicable("the testee doesn't send a valid hello".to_owned()));
    // Only the first process sends a hello.
    let has_started = AtomicBool::new(false);
    let once = in_memory(Program::new(move || {
        let is_first = !has_started.swap(true, Ordering::Relaxed);
        Box::new(move |_| Some(is_first.then(|| hello().to_string()).into_iter().collect()))
    }));
    let (found, time) = linted(&once);
    let (failures, last) = failed(&found);
    assert_eq!((failures, time.as_secs()), (vec!["second-hello"], 30));
    let why = "not checked: the testee didn't start again";
    assert_eq!(last, &CheckOutcome::NotApplicable(why.to_owned()));
}

#[test]
fn lint_quotes_only_the_start_of_long_names() {
    let program = Program::new(|| {
        Box::new(|_| {
            let mut hello = hello();
            hello["ops"] = json!(["decode", "x".repeat(10_000)]);
            hello["formats"] = json!(["cdr", "cdr"]);
            hello["types"] = json!(["x".repeat(10_000)]);
            Some(vec![hello.to_string()])
        })
    });
    let (found, _) = linted(&in_memory(program));
    let members = found.outcomes.iter().find(|(check, _)| check.id == "hello-members").expect("a check");
    let message = members.1.message().expect("a message");
    assert!(message.contains("xxx") && message.len() < 300, "{message}");
}
