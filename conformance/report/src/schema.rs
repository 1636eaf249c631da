//! Tests of the schema of reports.

use serde_json::json;
use uavspec_check::check_capture;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::mutants;
use uavspec_rules::sample::Flight;
use uavspec_test_support::extent;
use uavspec_test_support::schema::{Published, errors};

use super::{Action, CheckedCapture, Reason, Report, RequestType, Settings, Subject, Unreadable};

const REPORT: Published = Published { title: "Report", file: "report" };

#[test]
fn the_published_schema_is_up_to_date_and_described() {
    REPORT.check::<Report>();
}

#[test]
fn a_report_with_every_rule_violated_matches_the_schema() {
    let definitions = Definitions::built_in();
    let flight = Flight::new(&definitions);
    let mutants = mutants().step_by(extent(1, 31)).flat_map(|mutant| mutant.captures(&flight));
    let subject = |bytes: Vec<u8>| {
        let result = check_capture(&bytes[..], None, &definitions).expect("bytes can be read");
        Subject::from_capture(
            CheckedCapture {
                path: "a\nb".to_owned(),
                result,
                notes: vec!["the server closed the connection".to_owned()],
                requests: vec![RequestType {
                    name: "UAV-INF".to_owned(),
                    sent: 2,
                    answered: 1,
                    refused: 0,
                    not_sent: None,
                }],
                cut_short: Vec::new(),
                elapsed: 7,
            },
            &definitions,
            &Settings::default(),
        )
    };
    let mut subjects: Vec<Subject> = mutants.map(|(_, bytes)| subject(bytes)).collect();
    subjects.push(subject(b"not JSON\n".to_vec()));
    let unreadable = Unreadable { path: "gone".to_owned(), message: "absent".to_owned() };
    let reasons = vec![Reason::from("a rule is required".to_owned())];
    let report = Report::new(
        Action::Check,
        "uavspec check".to_owned(),
        &definitions,
        subjects,
        vec![unreadable],
        reasons,
    );
    let value = serde_json::to_value(&report).expect("JSON");
    let schema = REPORT.schema::<Report>();
    assert_eq!(errors(&schema, &value), Vec::<String>::new());
    let mut wrong = value.clone();
    wrong["subjects"][0]["rules"][0]["verdict"] = json!("fine");
    assert!(!errors(&schema, &wrong).is_empty(), "the schema rejects unknown verdicts");
}
