//! Testees that do right, that have a bug, and that misbehave.
//!
//! They are modes of the example `testee`. Nothing here depends on something being fast: what must time out hangs
//! for ever, and what must not has plenty of time.

mod attach;
mod lint;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

use serde_json::Value;
use uavspec_codegen::dynamic::{PlacedElement, Types};
use uavspec_conformance::definitions::Definitions;
use uavspec_conformance::testee::{
    Case, ExpectedResponse, Format, Op, Options, Outcome, Target, Verdict, cases, run,
};
use uavspec_runtime::Scalar;

struct Suite {
    types: Types,
    cases: Vec<Case>,
}

fn suite() -> &'static Suite {
    static SUITE: OnceLock<Suite> = OnceLock::new();
    SUITE.get_or_init(|| {
        let definitions = Definitions::built_in();
        let types = Types::new(&definitions.schema);
        let cases = cases(&definitions, &types);
        Suite { types, cases }
    })
}

/// The example. Cargo builds it before tests unless it is asked for some of them only, so this asks for it.
fn testee() -> &'static Path {
    static TESTEE: OnceLock<PathBuf> = OnceLock::new();
    TESTEE.get_or_init(|| {
        let mut cargo = Command::new(env!("CARGO"));
        // With `--workspace`, dependencies have the features that `cargo test --workspace` has compiled them with.
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

fn options(arguments: &[&str]) -> Options {
    let mut command = vec![testee().as_os_str().to_owned()];
    command.extend(arguments.iter().map(Into::into));
    Options {
        timeout: Duration::from_secs(60),
        start_timeout: Duration::from_secs(120),
        ..Options::new(Target::Command(command))
    }
}

/// For testees that hang: short, as those that are asked next have it too, but enough for them.
fn impatient(arguments: &[&str]) -> Options {
    Options { timeout: Duration::from_secs(4), ..options(arguments) }
}

fn ask(selected: &[usize], options: &Options) -> Outcome<'static> {
    let suite = suite();
    run(&suite.cases, selected, &suite.types, options, &|_, _| {}).expect("the testee introduces itself")
}

/// The first cases of decoding `px4/Event`.
fn some() -> Vec<usize> {
    let is_wanted = |case: &Case| {
        case.op == Op::Decode && case.format == Some(Format::Uorb) && case.type_name == "px4/Event"
    };
    let cases = suite().cases.iter().enumerate().filter(|(_, case)| is_wanted(case));
    cases.map(|(id, _)| id).take(8).collect()
}

fn everything() -> Vec<usize> {
    (0..suite().cases.len()).collect()
}

fn failures(outcome: &Outcome<'_>) -> BTreeSet<String> {
    outcome.failures().map(|(case, _)| case.name()).collect()
}

/// Asks a testee that misbehaves over the fifth of eight cases; gives the verdict on that.
#[track_caller]
fn culprit(mode: &str, options: impl Fn(&[&str]) -> Options) -> (Verdict, Outcome<'static>) {
    let selected = some();
    let outcome = ask(&selected, &options(&[mode, &selected[4].to_string()]));
    let guilty = suite().cases[selected[4]].name();
    for (case, verdict) in &outcome.verdicts {
        assert_eq!(*verdict == Verdict::Pass, case.name() != guilty, "{}: {verdict:?}", case.name());
    }
    assert_eq!(outcome.gave_up, None);
    (outcome.verdicts[4].1.clone(), outcome)
}

#[test]
fn the_reference_passes_everything() {
    for jobs in [1, 3] {
        let outcome = ask(&everything(), &Options { jobs, ..options(&[]) });
        assert_eq!(failures(&outcome), BTreeSet::new());
        assert!(outcome.protocol_remarks.is_empty(), "{:?}", outcome.protocol_remarks);
        let counts = outcome.counts();
        assert_eq!((counts.passed, counts.unsupported, outcome.restarts), (suite().cases.len(), 0, 0));
        assert!(counts.passed > 4_000);
    }
}

#[test]
fn skips_types_that_are_not_listed() {
    // Another definition than the testee's: none of its types is known there.
    let suite = suite();
    let mut foreign = suite.cases[some()[0]].clone();
    foreign.type_name = "px4/Unheard".to_owned();
    let cases = [foreign];
    let outcome = run(&cases, &[0], &suite.types, &options(&[]), &|_, _| {}).expect("a hello");
    assert_eq!(outcome.verdicts[0].1, Verdict::Unsupported);
}

#[test]
fn swapped_bytes_fail_where_they_show() {
    let suite = suite();
    let shows = |case: &&Case| {
        let ExpectedResponse::Message(wanted) = &case.expected.ok else { return false };
        let (package, name) = case.type_name.split_once('/').expect("a package");
        let message = suite.types.find(package, name).expect("a type");
        message.layout().any(|field| {
            let differs = |value: &Value| {
                value
                    .as_u64()
                    .and_then(|value| u16::try_from(value).ok())
                    .is_some_and(|it| it != it.swap_bytes())
            };
            let value = &wanted[field.name];
            matches!(field.element, PlacedElement::Scalar(Scalar::UInt16))
                && (differs(value) || value.as_array().is_some_and(|items| items.iter().any(differs)))
        })
    };
    let expected: BTreeSet<String> = suite.cases.iter().filter(shows).map(Case::name).collect();
    assert!(expected.len() > 10);
    assert_eq!(failures(&ask(&everything(), &options(&["swap-uint16"]))), expected);
}

#[test]
fn a_lost_nan_fails_where_one_was() {
    // No other value than NaN is null in a decoded message, and no message within a message has a float here.
    let has_nan = |case: &&Case| match &case.expected.ok {
        ExpectedResponse::Message(Value::Object(members)) => members.values().any(|value| {
            value.is_null() || value.as_array().is_some_and(|items| items.iter().any(Value::is_null))
        }),
        _ => false,
    };
    let expected: BTreeSet<String> = suite().cases.iter().filter(has_nan).map(Case::name).collect();
    assert!(expected.len() > 10);
    assert_eq!(failures(&ask(&everything(), &options(&["drop-nan"]))), expected);
}

#[test]
fn a_crash_has_a_culprit_and_evidence() {
    let (verdict, outcome) = culprit("crash", options);
    let Verdict::Crashed { how, stderr } = verdict else { panic!("{verdict:?}") };
    assert!(how.contains('3'), "{how}");
    assert_eq!(stderr, "no field of that name");
    // The cases before it pass again as suspects, so it isn't the first of its process, and is asked once more.
    assert!((2..=3).contains(&outcome.restarts), "{}", outcome.restarts);
}

/// Who ends is not waited for because of what it started, which ends with it.
#[cfg(target_os = "linux")]
#[test]
fn a_crash_leaves_nobody_behind() {
    let (verdict, _) = culprit("orphan", options);
    let Verdict::Crashed { how, stderr } = verdict else { panic!("{verdict:?}") };
    assert!(how.contains('5'), "{how}");
    // What was killed may stay in the table as a zombie.
    let is_over = || {
        let state = std::fs::read_to_string(format!("/proc/{stderr}/stat")).unwrap_or_default();
        state.is_empty() || state.contains(") Z ")
    };
    let mut waits = 0;
    while !is_over() {
        waits += 1;
        assert!(waits < 200, "{stderr} still runs");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn a_hang_has_a_culprit() {
    let (verdict, _) = culprit("hang", impatient);
    assert!(matches!(verdict, Verdict::TimedOut { .. }), "{verdict:?}");
}

#[test]
fn a_line_without_end_has_a_culprit() {
    let (verdict, _) = culprit("endless", options);
    assert!(
        matches!(&verdict, Verdict::Crashed { how, .. } if how.contains("16777216 bytes")),
        "{verdict:?}"
    );
}

#[test]
fn an_answer_that_is_lost_has_a_culprit_and_a_remark() {
    let (verdict, outcome) = culprit("wrong-id", impatient);
    assert!(matches!(verdict, Verdict::TimedOut { .. }), "{verdict:?}");
    let remark = &outcome.protocol_remarks.remarks[0].0;
    assert!(remark.starts_with("an answer without a question: id 1000000"), "{remark}");
}

#[test]
fn an_answer_that_can_not_be_read_is_not_waited_for() {
    let (verdict, outcome) = culprit("not-utf8", options);
    let Verdict::Fail(difference) = verdict else { panic!("{verdict:?}") };
    assert!(difference.actual.contains("no UTF-8 from byte"), "{difference:?}");
    assert_eq!(outcome.restarts, 0);
}

#[test]
fn a_crash_that_no_case_leads_to_alone_ends_the_run() {
    let selected = everything();
    let outcome = ask(&selected[..100], &options(&["crash-third"]));
    // In a fresh process any case passes, so none is blamed.
    assert_eq!(failures(&outcome), BTreeSet::new());
    assert_eq!(outcome.restarts, 20);
    assert!(outcome.gave_up.as_ref().is_some_and(|why| why.starts_with("gave up after 20 restarts")));
    let counts = outcome.counts();
    assert_eq!((counts.passed > 20, counts.not_run > 0, counts.passed + counts.not_run), (true, true, 100));
}

#[test]
fn a_crash_over_every_case_ends_no_run() {
    let selected = everything();
    let outcome = ask(&selected[..70], &options(&["crash"]));
    assert_eq!(outcome.gave_up, None);
    let has_crashed = |(_, verdict): &(&Case, Verdict)| matches!(verdict, Verdict::Crashed { .. });
    assert!(outcome.verdicts.len() == 70 && outcome.verdicts.iter().all(has_crashed));
    // The first is looked for, and then each costs one start.
    assert!((69..=72).contains(&outcome.restarts), "{}", outcome.restarts);
}

#[test]
fn the_limit_of_restarts_can_be_set() {
    let options = Options { max_restarts: 3, ..options(&["crash-third"]) };
    let outcome = ask(&everything()[..100], &options);
    assert_eq!(outcome.restarts, 3);
    assert!(outcome.gave_up.as_ref().is_some_and(|why| why.starts_with("gave up after 3 restarts in a row")));
}

#[test]
fn split_writes_and_much_on_standard_error_are_no_fault() {
    for mode in ["split", "flood"] {
        let outcome = ask(&some(), &options(&[mode]));
        assert_eq!((outcome.counts().passed, outcome.restarts), (8, 0), "{mode}");
        assert!(outcome.protocol_remarks.is_empty(), "{mode}: {:?}", outcome.protocol_remarks);
    }
}

#[test]
fn answers_may_come_in_any_order() {
    let selected = some();
    let outcome = ask(&selected, &options(&["later", &selected[4].to_string()]));
    assert_eq!((outcome.counts().passed, outcome.restarts), (8, 0));
    assert!(outcome.protocol_remarks.is_empty(), "{:?}", outcome.protocol_remarks);
}

#[test]
fn repeated_and_late_answers_are_bad_manners() {
    let selected = some();
    let outcome = ask(&selected, &options(&["repeat", &selected[4].to_string()]));
    assert_eq!(outcome.verdicts[4].1, Verdict::Unsupported);
    assert_eq!(outcome.protocol_remarks.remarks[0].0, format!("a second answer to id {}", selected[4]));
    let outcome = ask(&selected, &options(&["late"]));
    assert_eq!(outcome.counts().passed, 8);
    assert!(
        outcome.protocol_remarks.remarks[0].0.starts_with("a line after the last answer"),
        "{:?}",
        outcome.protocol_remarks
    );
}

#[test]
fn reports_a_missing_hello() {
    let suite = suite();
    let broken = |options: &Options| {
        run(&suite.cases, &some(), &suite.types, options, &|_, _| {}).map(|_| ()).expect_err("no hello")
    };
    let output = broken(&options(&["exit"]));
    assert!(output.contains('7') && output.ends_with("out of cheese"), "{output}");
    let output = broken(&options(&["bad-hello"]));
    assert!(output.contains("no JSON") && output.contains("`hello, world`"), "{output}");
    let output = broken(&Options { start_timeout: Duration::from_millis(200), ..options(&["no-hello"]) });
    assert!(output.contains("nothing within 0.2 s"), "{output}");
    let output = broken(&Options::new(Target::Command(vec!["/nowhere/at/all".into()])));
    assert!(output.contains("can't start /nowhere/at/all"), "{output}");
}

/// Status, what was printed, and what was said.
fn uavspec(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    let output = command.arg("test").args(arguments).current_dir(folder).output().expect("uavspec runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn the_exit_status_is_the_outcome() {
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
    assert!(status == Some(1) && printed.contains("breaks the protocol"), "{printed}");
    // What is asked again is asked in the same way.
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
    assert!(status == Some(3) && output.contains("doesn't introduce itself"), "{output}");
    assert_eq!(uavspec(here, &["--replay", "nowhere"]).0, Some(3));
    let (status, printed, _) = uavspec(here, &["--help"]);
    assert!(status == Some(0) && printed.contains("Examples:"), "{printed}");
}

#[test]
fn answers_can_come_from_a_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let filter = "--filter=*/px4/Event/*";
    let (status, _, output) = uavspec(folder.path(), &["--dump-cases", "questions", filter]);
    assert_eq!(status, Some(0), "{output}");
    let questions = std::fs::File::open(folder.path().join("questions")).expect("a file");
    let answers = std::fs::File::create(folder.path().join("answers")).expect("a file");
    let run = Command::new(testee()).stdin(questions).stdout(answers).status();
    assert!(run.expect("it runs").success());
    let (status, printed, _) = uavspec(folder.path(), &["--replay", "answers", filter]);
    assert!(status == Some(0) && printed.ends_with("conforms\n"), "{printed}");

    // What no hello promises is unsupported; an empty file is nothing.
    std::fs::write(folder.path().join("empty"), "").expect("a file");
    assert_eq!(uavspec(folder.path(), &["--replay", "empty"]).0, Some(5));
    std::fs::write(folder.path().join("odd"), "{\"id\":99999999,\"ok\":1}\nx\n").expect("a file");
    let (status, printed, _) = uavspec(folder.path(), &["--replay", "odd"]);
    assert!(status == Some(1) && printed.contains("id 99999999") && printed.contains("no JSON"), "{printed}");
}

#[test]
fn tests_with_other_definitions() {
    let folder = tempfile::tempdir().expect("a folder");
    let definition = "uint64 timestamp  # [us] Time\nint64 offset  # [us] Off\nint32 low\nfloat64 wide\n\
                      float64[2] pair\nfloat32 narrow  # [@range -1, 1] [@invalid NaN] How far\nchar[8] name\n\
                      bool is_set\nbool[3] set\nint16[2] short\nWind[2] winds\n";
    std::fs::write(folder.path().join("Odd.msg"), definition).expect("a file");
    let wind = "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] [@invalid NaN] Speed\n";
    std::fs::write(folder.path().join("Wind.msg"), wind).expect("a file");
    let testee = testee().to_str().expect("UTF-8");
    let arguments = ["--definitions", ".", "--", testee, "--definitions", "."];
    let (status, printed, output) = uavspec(folder.path(), &arguments);
    assert!(status == Some(0) && printed.contains("Odd"), "{printed}{output}");
    assert!(printed.contains(" 0 failed, 0 unsupported, 0 not run, 0 restarts"), "{printed}");
    let (_, printed, _) = uavspec(folder.path(), &["--definitions", ".", "--dump-cases", "-"]);
    // One above the greatest int64 can be told from it, one below the least can't.
    assert!(printed.contains("Odd/offset-above-max") && !printed.contains("Odd/offset-below-min"));
    // The reference for this repository knows none of them.
    let (status, printed, _) = uavspec(folder.path(), &["--definitions", ".", "--", testee]);
    assert!(status == Some(5) && printed.ends_with("nothing was checked\n"), "{printed}");
}

#[test]
fn a_crash_in_one_process_leaves_the_others_alone() {
    let selected = &everything()[..300];
    let guilty = &suite().cases[selected[150]];
    let options = Options { jobs: 3, ..options(&["crash", &selected[150].to_string()]) };
    let outcome = ask(selected, &options);
    assert_eq!(failures(&outcome), BTreeSet::from([guilty.name()]));
    assert_eq!((outcome.counts().passed, outcome.counts().not_run), (299, 0));
}

/// Asks a codec that was written by hand in another language.
fn by_hand(command: &[&str], script: &str) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("testees").join(script);
    let command = command.iter().map(Into::into).chain([script.into()]).collect();
    let outcome = ask(&everything(), &Options { target: Target::Command(command), ..options(&[]) });
    assert_eq!(failures(&outcome), BTreeSet::new());
    assert!(outcome.protocol_remarks.is_empty() && outcome.counts().passed > 1_000, "{:?}", outcome.counts());
}

#[test]
#[ignore = "needs python3"]
fn a_codec_in_python_passes() {
    by_hand(&["python3", "-B"], "python/testee.py");
}

#[test]
#[ignore = "needs node"]
fn a_codec_in_javascript_passes() {
    by_hand(&["node"], "node/testee.js");
}
