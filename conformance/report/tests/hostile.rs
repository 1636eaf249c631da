//! Captures and reports with hostile input, for tests.

use serde_json::{Value, json};
use uavspec_check::check_capture;
use uavspec_model::{Excuse, ExcuseKind, Reason};
use uavspec_probe::RequestType;
use uavspec_probe::testee::cases;
use uavspec_probe::testee::compare::Difference;
use uavspec_probe::testee::outcome::{Outcome, ProtocolRemarks, Verdict};
use uavspec_report::{Action, CheckedCapture, Report, Settings, Subject, Unreadable};
use uavspec_rules::Mutant;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::sample::Flight;
use uavspec_schema::Date;
use uavspec_test_support::extent;

use crate::mutants::tested_mutants;

/// A string with characters that have a special meaning in a report format, or that are misleading when displayed.
pub(crate) const HOSTILE: &str = "</style><script>alert(1)</script>|`*[x](javascript:y)]]>&amp;\"'\r\n::error::\u{1b}[31m\u{7}\u{202e}\u{ffff}é🛩";

/// The mutants that the captures contain.
pub(crate) fn captured_mutants() -> impl Iterator<Item = Mutant> {
    tested_mutants(&["PX-ARR-01", "PX-BOOL-01"])
}

/// Captures with their names. They contain violations of the tested rules, and JSON with hostile names.
pub(crate) fn captures(definitions: &Definitions) -> Vec<(String, Vec<u8>)> {
    let flight = Flight::new(definitions);
    let mut sources = Vec::new();
    for mutant in captured_mutants() {
        for (title, bytes) in mutant.captures(&flight) {
            sources.push((format!("{}: {title}", mutant.rule.id), bytes));
        }
    }
    sources.push((format!("{HOSTILE}.jsonl"), lines()));
    sources
}

/// Messages with hostile fields, types and texts.
fn lines() -> Vec<u8> {
    let long = "x".repeat(10_000);
    let glider = |name: &str, value: Value| {
        let mut message = json!({ "timestamp": 1, "arming_check_id": 2, "mode_id": 3, "mode_executor_id": -1, "name": "glider" });
        message[name] = value;
        json!({ "type": "px4/UnregisterExtComponent", "message": message }).to_string()
    };
    let mut lines = vec![
        glider(HOSTILE, 1.into()),
        glider(&long, 2.into()),
        glider("name", long.as_str().into()),
        glider("name", HOSTILE.repeat(3).into()),
        glider("mode_id", 300.into()),
        json!({ "type": HOSTILE, "message": {} }).to_string(),
        format!("not JSON: {HOSTILE}").replace(['\r', '\n'], " "),
    ];
    lines.extend((0..40).map(|number| glider(&format!("mark_{number}"), 0.into())));
    lines.join("\n").into_bytes()
}

/// A report of `check` with all kinds of content.
pub(crate) fn checked(definitions: &Definitions) -> Report {
    let subject = |(path, bytes): (String, Vec<u8>)| {
        let result = check_capture(&bytes[..], None, definitions).expect("bytes can be read");
        // The duration isn't compared.
        let checked = CheckedCapture {
            path,
            result,
            notes: vec!["the <b>wind</b>\u{1b}[1m turned".to_owned()],
            requests: vec![RequestType {
                name: "UAV-INF".to_owned(),
                sent: 2,
                answered: 1,
                refused: 0,
                not_sent: None,
            }],
            cut_short: Vec::new(),
            elapsed: 7,
        };
        let arguments = vec!["--definitions".to_owned(), HOSTILE.to_owned()];
        Subject::from_capture(checked, definitions, &Settings { arguments, ..Settings::default() })
    };
    let mut subjects: Vec<Subject> = captures(definitions).into_iter().map(subject).collect();
    let last = subjects.last_mut().expect("subjects");
    let known = Excuse {
        kind: ExcuseKind::Known,
        reason: HOSTILE.to_owned(),
        link: Some("javascript:alert(1)".to_owned()),
        expires: Some(Date { year: 2027, month: 6, day: 30 }),
    };
    last.findings[0].known = Some(known);
    let unreadable = vec![Unreadable { path: format!("gone{HOSTILE}"), message: HOSTILE.to_owned() }];
    let reasons = vec![Reason::from(format!("required: {HOSTILE}"))];
    let command = format!("uavspec check {HOSTILE}");
    Report::new(Action::Check, command, &definitions.name, subjects, unreadable, reasons)
}

/// A report of `test` with every verdict.
pub(crate) fn tested(definitions: &Definitions) -> Report {
    let all = cases(definitions, definitions.types());
    let cases = all.iter().step_by(extent(1, 5));
    let text = HOSTILE.to_owned();
    let verdict = |at: usize| match at % 12 {
        1 => Verdict::Fail(Difference {
            path: "/mark/2".to_owned(),
            expected: text.clone(),
            actual: "x".repeat(10_000),
        }),
        2 => Verdict::Unsupported,
        3 => Verdict::Crashed { how: text.clone(), stderr: format!("{text}\n{text}") },
        4 => Verdict::TimedOut { after: std::time::Duration::from_secs(5), stderr: String::new() },
        5 => Verdict::NotRun,
        _ => Verdict::Pass,
    };
    let outcome = Outcome {
        hello: None,
        verdicts: cases.enumerate().map(|(at, case)| (case, verdict(at))).collect(),
        protocol_remarks: ProtocolRemarks { remarks: vec![(text.clone(), 3)], more: 2 },
        restarts: 4,
        gave_up: Some(text.clone()),
    };
    let mut subject =
        Subject::from_testee(&outcome, definitions, &|case| format!("uavspec test --filter {case}"));
    subject.path.clone_from(&text);
    let command = "uavspec test -- ./codec".to_owned();
    Report::new(Action::Test, command, &definitions.name, vec![subject], Vec::new(), Vec::new())
}
