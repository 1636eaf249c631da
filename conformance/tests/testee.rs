//! Tests with testees that are correct, buggy, or violate the protocol.
//!
//! The testees are modes of the example program `testee`. No test depends on speed: in tests with hanging testees, time
//! passes only while other testees answer, and all other tests have long time limits.

mod attach;
mod lint;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

use serde_json::Value;
use uavspec_dynamic::Types;
use uavspec_model::clock::Clock;
use uavspec_probe::testee::{
    Case, ExpectedResponse, Format, Op, Options, Outcome, Target, Verdict, cases, run,
};
use uavspec_rules::definitions::Definitions;
use uavspec_runtime::Scalar;
use uavspec_schema::Element;
use uavspec_test_support::{cargo, extent, wait_for};

/// Definitions of a few messages with all kinds of fields. A testee reads them much faster than the built-in
/// definitions.
const DEFINITIONS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/testee/definitions");

struct Suite {
    types: Types,
    cases: Vec<Case>,
}

impl Suite {
    fn new(definitions: &Definitions) -> Self {
        let types = Types::new(&definitions.schema);
        let cases = cases(definitions, &types);
        Self { types, cases }
    }
}

/// The cases of [`DEFINITIONS`].
fn suite() -> &'static Suite {
    static SUITE: OnceLock<Suite> = OnceLock::new();
    SUITE.get_or_init(|| Suite::new(&Definitions::load(Path::new(DEFINITIONS)).expect("definitions")))
}

/// The cases of the built-in definitions.
fn built_in() -> &'static Suite {
    static SUITE: OnceLock<Suite> = OnceLock::new();
    SUITE.get_or_init(|| Suite::new(&Definitions::built_in()))
}

/// The path of the example program. Cargo doesn't build examples for a filtered test run, so this function builds the
/// program.
fn testee() -> &'static Path {
    static TESTEE: OnceLock<PathBuf> = OnceLock::new();
    TESTEE.get_or_init(|| {
        let mut cargo = cargo();
        // With `--workspace`, dependencies are built with the same features as in `cargo test --workspace`.
        cargo.args(["build", "--quiet", "--workspace", "--example", "testee"]);
        cargo.args(["--message-format", "json"]).current_dir(env!("CARGO_MANIFEST_DIR"));
        let built = cargo.stderr(Stdio::inherit()).output().expect("cargo runs");
        let printed = String::from_utf8(built.stdout).expect("UTF-8");
        let messages = printed.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
        let mut programs = messages.filter(|message| message["target"]["name"] == "testee");
        let program = programs.find_map(|message| Some(PathBuf::from(message["executable"].as_str()?)));
        program.expect("the example builds")
    })
}

/// Options for a testee of [`DEFINITIONS`].
fn options(arguments: &[&str]) -> Options {
    built_in_options(&[&["--definitions", DEFINITIONS], arguments].concat())
}

fn built_in_options(arguments: &[&str]) -> Options {
    let mut command = vec![testee().as_os_str().to_owned()];
    command.extend(arguments.iter().map(Into::into));
    Options {
        timeout: Duration::from_secs(60),
        start_timeout: Duration::from_secs(120),
        ..Options::new(Target::Command(command))
    }
}

/// The number of testees that must start and answer before another testee counts as silent.
const PATIENCE: u32 = 40;

/// Options for testees that hang.
fn impatient(arguments: &[&str], clock: &Clock) -> Options {
    let clock = clock.clone();
    Options { timeout: Duration::from_secs(4), clock, ..options(arguments) }
}

/// Runs a function with a clock that is advanced by a correct testee. Even on a busy computer, a hanging testee can
/// therefore be distinguished from a slow one.
fn patiently<T>(run: impl FnOnce(&Clock) -> T) -> T {
    let (clock, running) = (Clock::simulated(), Arc::new(()));
    let (case, is_running) = (&some_cases()[..1], Arc::downgrade(&running));
    thread::scope(|scope| {
        scope.spawn(|| {
            while is_running.strong_count() > 0 {
                run_cases(case, &options(&[]));
                clock.sleep(Duration::from_secs(4) / PATIENCE);
            }
        });
        // A panic also drops `running`.
        let outcome = run(&clock);
        drop(running);
        outcome
    })
}

fn run_cases(selected: &[usize], options: &Options) -> Outcome<'static> {
    run_cases_of(suite(), selected, options)
}

fn run_all_built_in(options: &Options) -> Outcome<'static> {
    let all: Vec<usize> = (0..built_in().cases.len()).collect();
    run_cases_of(built_in(), &all, options)
}

fn run_cases_of(suite: &'static Suite, selected: &[usize], options: &Options) -> Outcome<'static> {
    run(&suite.cases, selected, &suite.types, options, &|_, _| {}).expect("a valid hello")
}

/// The indices of the first cases that decode.
fn some_cases() -> Vec<usize> {
    let is_wanted = |case: &Case| case.op == Op::Decode && case.format == Some(Format::Uorb);
    let cases = suite().cases.iter().enumerate().filter(|(_, case)| is_wanted(case));
    cases.map(|(id, _)| id).take(8).collect()
}

fn all_cases() -> Vec<usize> {
    (0..suite().cases.len()).collect()
}

fn failures(outcome: &Outcome<'_>) -> BTreeSet<String> {
    outcome.failures().map(|(case, _)| case.name()).collect()
}

/// Runs eight cases with a testee that misbehaves on the fifth case. Returns the verdict of this case, and the outcome.
#[track_caller]
fn culprit(mode: &str, options: impl Fn(&[&str]) -> Options) -> (Verdict, Outcome<'static>) {
    let selected = some_cases();
    let outcome = run_cases(&selected, &options(&[mode, &selected[4].to_string()]));
    let guilty = suite().cases[selected[4]].name();
    for (case, verdict) in &outcome.verdicts {
        assert_eq!(*verdict == Verdict::Pass, case.name() != guilty, "{}: {verdict:?}", case.name());
    }
    assert_eq!(outcome.gave_up, None);
    (outcome.verdicts[4].1.clone(), outcome)
}

/// True if the testee rejects the input, although other codecs may decode it: a `bool` other than 0 and 1, or an
/// infinity, which JSON can't represent.
fn is_rejected(case: &Case) -> bool {
    case.rule.as_deref() == Some("PX-BOOL-01") || case.id.ends_with("-inf")
}

#[test]
fn the_reference_testee_passes_all_cases() {
    for jobs in extent(vec![1, 3], vec![3]) {
        let outcome = run_all_built_in(&Options { jobs, ..built_in_options(&[]) });
        assert_eq!(failures(&outcome), BTreeSet::new());
        assert!(outcome.protocol_remarks.is_empty(), "{:?}", outcome.protocol_remarks);
        let counts = outcome.counts();
        assert_eq!(
            (counts.passed, counts.unsupported, outcome.restarts),
            (built_in().cases.len() as u64, 0, 0)
        );
        assert!(counts.passed > 4_000);
    }
}

#[test]
fn skips_types_that_are_not_listed() {
    // The testee doesn't support the type of this case.
    let suite = suite();
    let mut foreign = suite.cases[some_cases()[0]].clone();
    foreign.type_name = "px4/Unheard".to_owned();
    let cases = [foreign];
    let outcome = run(&cases, &[0], &suite.types, &options(&[]), &|_, _| {}).expect("a hello");
    assert_eq!(outcome.verdicts[0].1, Verdict::Unsupported);
}

#[test]
fn fails_on_swapped_bytes_that_are_observable() {
    let suite = built_in();
    let shows = |case: &&Case| {
        let ExpectedResponse::Message(wanted) = &case.expected.ok else { return false };
        if is_rejected(case) {
            return false;
        }
        let (package, name) = case.type_name.split_once('/').expect("a package");
        let message = suite.types.find(package, name).expect("a type");
        message.fields().iter().any(|field| {
            let differs = |value: &Value| {
                value
                    .as_u64()
                    .and_then(|value| u16::try_from(value).ok())
                    .is_some_and(|it| it != it.swap_bytes())
            };
            let value = &wanted[&*field.name];
            field.element == Element::Scalar(Scalar::UInt16)
                && (differs(value) || value.as_array().is_some_and(|items| items.iter().any(differs)))
        })
    };
    let expected: BTreeSet<String> = suite.cases.iter().filter(shows).map(Case::name).collect();
    assert!(expected.len() > 10);
    assert_eq!(failures(&run_all_built_in(&built_in_options(&["swap-uint16"]))), expected);
}

#[test]
fn fails_if_nan_is_lost() {
    // In a decoded message, null always means NaN. No nested message in these cases has a float.
    let has_nan = |case: &&Case| match &case.expected.ok {
        ExpectedResponse::Message(Value::Object(members)) if !is_rejected(case) => {
            members.values().any(|value| {
                value.is_null() || value.as_array().is_some_and(|items| items.iter().any(Value::is_null))
            })
        }
        _ => false,
    };
    let expected: BTreeSet<String> = built_in().cases.iter().filter(has_nan).map(Case::name).collect();
    assert!(expected.len() > 10);
    assert_eq!(failures(&run_all_built_in(&built_in_options(&["drop-nan"]))), expected);
}

#[test]
fn reports_the_case_that_crashes_and_its_standard_error() {
    let (verdict, outcome) = culprit("crash", options);
    let Verdict::Crashed { how, stderr } = verdict else { panic!("{verdict:?}") };
    assert!(how.contains('3'), "{how}");
    assert_eq!(stderr, "no field of that name");
    // The preceding cases pass when they are repeated alone. The process that then crashes isn't fresh, so the case is
    // repeated in a fresh process.
    assert!((2..=3).contains(&outcome.restarts), "{}", outcome.restarts);
}

/// The processes that a testee started end together with the testee, and don't delay the run.
#[cfg(target_os = "linux")]
#[test]
fn a_crash_leaves_no_processes_behind() {
    let (verdict, _) = culprit("orphan", options);
    let Verdict::Crashed { how, stderr } = verdict else { panic!("{verdict:?}") };
    assert!(how.contains('5'), "{how}");
    // A killed process may remain as a zombie.
    let is_over = || {
        let state = std::fs::read_to_string(format!("/proc/{stderr}/stat")).unwrap_or_default();
        state.is_empty() || state.contains(") Z ")
    };
    wait_for("the process ends", || is_over().then_some(()));
}

#[test]
fn reports_the_case_that_hangs() {
    let (verdict, _) = patiently(|clock| culprit("hang", |mode| impatient(mode, clock)));
    assert!(matches!(verdict, Verdict::TimedOut { .. }), "{verdict:?}");
}

#[test]
fn reports_the_case_with_an_endless_line() {
    let (verdict, _) = culprit("endless", options);
    assert!(
        matches!(&verdict, Verdict::Crashed { how, .. } if how.contains("16777216 bytes")),
        "{verdict:?}"
    );
}

#[test]
fn reports_the_case_without_a_response() {
    let (verdict, outcome) = patiently(|clock| culprit("wrong-id", |mode| impatient(mode, clock)));
    assert!(matches!(verdict, Verdict::TimedOut { .. }), "{verdict:?}");
    let remark = &outcome.protocol_remarks.remarks[0].0;
    assert!(remark.starts_with("unexpected response with id 1000000"), "{remark}");
}

#[test]
fn reports_the_case_with_endless_wrong_responses() {
    let (verdict, outcome) = culprit("babble", options);
    assert!(
        matches!(&verdict, Verdict::Crashed { how, .. } if how.contains("262144 bytes without")),
        "{verdict:?}"
    );
    let remark = &outcome.protocol_remarks.remarks[0].0;
    assert!(remark.starts_with("unexpected response with id 1000000"), "{remark}");
}

#[test]
fn fails_on_an_unreadable_response_without_waiting() {
    let (verdict, outcome) = culprit("not-utf8", options);
    let Verdict::Fail(difference) = verdict else { panic!("{verdict:?}") };
    assert!(difference.actual.contains("invalid UTF-8 at byte"), "{difference:?}");
    assert_eq!(outcome.restarts, 0);
}

#[test]
fn gives_up_on_crashes_that_no_single_case_causes() {
    let selected = all_cases();
    let outcome = run_cases(&selected[..100], &options(&["crash-third"]));
    // In a fresh process, every single case passes, so no case fails.
    assert_eq!(failures(&outcome), BTreeSet::new());
    assert_eq!(outcome.restarts, 20);
    assert!(
        outcome.gave_up.as_ref().is_some_and(|why| why.starts_with("gave up after 20 consecutive restarts"))
    );
    let counts = outcome.counts();
    assert_eq!((counts.passed > 20, counts.not_run > 0, counts.passed + counts.not_run), (true, true, 100));
}

#[test]
fn continues_if_every_case_crashes() {
    let selected = all_cases();
    let outcome = run_cases(&selected[..70], &options(&["crash"]));
    assert_eq!(outcome.gave_up, None);
    let has_crashed = |(_, verdict): &(&Case, Verdict)| matches!(verdict, Verdict::Crashed { .. });
    assert!(outcome.verdicts.len() == 70 && outcome.verdicts.iter().all(has_crashed));
    // Finding the first case that crashes takes some restarts. Each later case takes one restart.
    assert!((69..=72).contains(&outcome.restarts), "{}", outcome.restarts);
}

#[test]
fn respects_the_restart_limit() {
    let options = Options { max_restarts: 3, ..options(&["crash-third"]) };
    let outcome = run_cases(&all_cases()[..100], &options);
    assert_eq!(outcome.restarts, 3);
    assert!(
        outcome.gave_up.as_ref().is_some_and(|why| why.starts_with("gave up after 3 consecutive restarts"))
    );
}

#[test]
fn counts_restarts_of_each_job_separately() {
    // Each of the eight jobs needs one restart to find its first case that crashes.
    let options = Options { jobs: 8, window: 2, max_restarts: 3, ..options(&["crash"]) };
    let outcome = run_cases(&all_cases()[..16], &options);
    assert_eq!(outcome.gave_up, None);
    let has_crashed = |(_, verdict): &(&Case, Verdict)| matches!(verdict, Verdict::Crashed { .. });
    assert!(outcome.verdicts.len() == 16 && outcome.verdicts.iter().all(has_crashed));
}

#[test]
fn accepts_split_writes_and_long_standard_error() {
    for mode in ["split", "flood"] {
        let outcome = run_cases(&some_cases(), &options(&[mode]));
        assert_eq!((outcome.counts().passed, outcome.restarts), (8, 0), "{mode}");
        assert!(outcome.protocol_remarks.is_empty(), "{mode}: {:?}", outcome.protocol_remarks);
    }
}

#[test]
fn accepts_responses_in_any_order() {
    let selected = some_cases();
    let outcome = run_cases(&selected, &options(&["later", &selected[4].to_string()]));
    assert_eq!((outcome.counts().passed, outcome.restarts), (8, 0));
    assert!(outcome.protocol_remarks.is_empty(), "{:?}", outcome.protocol_remarks);
}

#[test]
fn remarks_on_repeated_and_late_responses() {
    let selected = some_cases();
    let outcome = run_cases(&selected, &options(&["repeat", &selected[4].to_string()]));
    assert_eq!(outcome.verdicts[4].1, Verdict::Unsupported);
    assert_eq!(outcome.protocol_remarks.remarks[0].0, format!("duplicate response with id {}", selected[4]));
    let outcome = run_cases(&selected, &options(&["late"]));
    assert_eq!(outcome.counts().passed, 8);
    assert!(
        outcome.protocol_remarks.remarks[0].0.starts_with("a line after the last response"),
        "{:?}",
        outcome.protocol_remarks
    );
}

#[test]
fn reports_a_wrong_hello() {
    let suite = suite();
    let failure = |options: &Options| {
        run(&suite.cases, &some_cases(), &suite.types, options, &|_, _| {}).map(|_| ()).expect_err("no hello")
    };
    let output = failure(&options(&["exit"]));
    assert!(output.contains('7') && output.ends_with("out of cheese"), "{output}");
    let output = failure(&options(&["bad-hello"]));
    assert!(output.contains("invalid JSON") && output.contains("`hello, world`"), "{output}");
    let output = failure(&Options::new(Target::Command(vec!["/nowhere/at/all".into()])));
    assert!(output.contains("can't start /nowhere/at/all"), "{output}");
}

/// Runs `uavspec test`. Returns the exit status, standard output and standard error.
fn uavspec(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    let output = command.arg("test").args(arguments).current_dir(folder).output().expect("uavspec runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn the_exit_status_reflects_the_outcome() {
    let here = Path::new(".");
    let testee = testee().to_str().expect("UTF-8");
    let filter = "--filter=decode-*/px4/BatteryStatus/*";
    let (status, printed, _) = uavspec(here, &[filter, "--", testee]);
    assert!(status == Some(0) && printed.ends_with("conforms\n"), "{printed}");
    let (status, printed, _) = uavspec(here, &[filter, "--", testee, "drop-nan"]);
    assert_eq!(status, Some(1));
    assert!(printed.contains("expected NaN\n  got      0.0\n"), "{printed}");
    let (status, printed, _) = uavspec(here, &[filter, "--format", "json", "--", testee, "drop-nan"]);
    let report: Value = serde_json::from_str(&printed).expect("JSON");
    assert_eq!((status, &report["subjects"][0]["path"]), (Some(1), &"reference".into()));
    assert_eq!(report["subjects"][0]["cases"][0]["verdict"], "fail");
    let (status, printed, _) = uavspec(here, &[filter, "--", testee, "late"]);
    assert!(status == Some(1) && printed.contains("violates the test protocol"), "{printed}");
    // The command that reproduces a failure includes the limits.
    let limits = ["--timeout=60.5", "--window=3"];
    let arguments = [&limits[..], &[filter, "--format", "json", "--", testee, "drop-nan"]].concat();
    let report: Value = serde_json::from_str(&uavspec(here, &arguments).1).expect("JSON");
    let again = report["subjects"][0]["cases"][0]["reproduce"].as_str().expect("a command");
    assert!(again.contains(" --timeout 60.5 --window 3 -- ") && !again.contains("--start"), "{again}");
    for usage in [
        &["--filter", "decode/nothing", "--", testee][..],
        &["--filter", "[", "--", testee],
        &[],
        &["--timeout=0", "--", testee],
    ] {
        assert_eq!(uavspec(here, usage).0, Some(2), "{usage:?}");
    }
    let (status, _, output) = uavspec(here, &["--", testee, "exit"]);
    assert!(status == Some(3) && output.contains("no valid hello from"), "{output}");
    assert_eq!(uavspec(here, &["--replay", "nowhere"]).0, Some(3));
    let (status, printed, _) = uavspec(here, &["--help"]);
    assert!(status == Some(0) && printed.contains("Examples:"), "{printed}");
}

#[test]
fn reads_responses_from_a_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let filter = "--filter=*/px4/Event/*";
    let (status, _, output) = uavspec(folder.path(), &["--dump-cases", "requests", filter]);
    assert_eq!(status, Some(0), "{output}");
    let requests = std::fs::File::open(folder.path().join("requests")).expect("a file");
    let answers = std::fs::File::create(folder.path().join("answers")).expect("a file");
    let run = Command::new(testee()).stdin(requests).stdout(answers).status();
    assert!(run.expect("the testee runs").success());
    let (status, printed, _) = uavspec(folder.path(), &["--replay", "answers", filter]);
    assert!(status == Some(0) && printed.ends_with("conforms\n"), "{printed}");

    // Without a hello, cases that have no response count as unsupported. Therefore, an empty file checks nothing.
    std::fs::write(folder.path().join("empty"), "").expect("a file");
    assert_eq!(uavspec(folder.path(), &["--replay", "empty"]).0, Some(5));
    std::fs::write(folder.path().join("odd"), "{\"id\":99999999,\"ok\":1}\nx\n").expect("a file");
    let (status, printed, _) = uavspec(folder.path(), &["--replay", "odd"]);
    assert!(
        status == Some(1) && printed.contains("id 99999999") && printed.contains("invalid JSON"),
        "{printed}"
    );
}

#[test]
fn tests_with_other_definitions() {
    let testee = testee().to_str().expect("UTF-8");
    let folder = Path::new(DEFINITIONS);
    let arguments = ["--definitions", ".", "--", testee, "--definitions", "."];
    let (status, printed, output) = uavspec(folder, &arguments);
    assert!(status == Some(0) && printed.contains("Odd"), "{printed}{output}");
    assert!(printed.contains(" 0 failed, 0 unsupported, 0 not run, 0 restarts"), "{printed}");
    let (_, printed, _) = uavspec(folder, &["--definitions", ".", "--dump-cases", "-"]);
    // Parsers can distinguish the largest int64 from the next larger integer. They can't distinguish the smallest int64
    // from the next smaller integer.
    assert!(printed.contains("Odd/offset-above-max") && !printed.contains("Odd/offset-below-min"));
    // The reference testee of this repository supports none of these types.
    let (status, printed, _) = uavspec(folder, &["--definitions", ".", "--", testee]);
    assert!(status == Some(5) && printed.ends_with("nothing was checked\n"), "{printed}");
}

#[test]
fn a_crash_in_one_process_does_not_affect_others() {
    let selected = &all_cases()[..300];
    let guilty = &suite().cases[selected[150]];
    let options = Options { jobs: 3, ..options(&["crash", &selected[150].to_string()]) };
    let outcome = run_cases(selected, &options);
    assert_eq!(failures(&outcome), BTreeSet::from([guilty.name()]));
    assert_eq!((outcome.counts().passed, outcome.counts().not_run), (299, 0));
}

/// Tests a codec written in another language.
fn check_testee(command: &[&str], script: &str) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("testees").join(script);
    let command = command.iter().map(Into::into).chain([script.into()]).collect();
    let outcome = run_all_built_in(&Options { target: Target::Command(command), ..options(&[]) });
    assert_eq!(failures(&outcome), BTreeSet::new());
    assert!(outcome.protocol_remarks.is_empty() && outcome.counts().passed > 1_000, "{:?}", outcome.counts());
}

#[test]
#[ignore = "requires Python"]
fn the_python_testee_passes() {
    check_testee(&["python3", "-B"], "python/testee.py");
}

#[test]
#[ignore = "requires Node"]
fn the_javascript_testee_passes() {
    check_testee(&["node"], "node/testee.js");
}
