//! Tests of all report formats: other programs can read them, regardless of the input.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use html5gum::{Token, Tokenizer};
use quick_junit::{NonSuccessKind, Report as Junit, TestCase, TestCaseStatus};
use serde_json::{Value, json};
use uavspec_check::check_capture;
use uavspec_lint::report::{rule_url, site_url};
use uavspec_report::{Action, CheckedCapture, Kind, OutcomeKind, Report, Settings, Subject, Verdict};
use uavspec_rules::RULES;
use uavspec_rules::definitions::Definitions;
use uavspec_test_support::extent;

use crate::hostile::{HOSTILE, captured_mutants, checked, tested};

fn create_reports() -> [Report; 2] {
    let definitions = Definitions::built_in();
    [checked(&definitions), tested(&definitions)]
}

/// A report of `check` and one of `test`, created once.
fn reports() -> &'static [Report; 2] {
    static BOTH: OnceLock<[Report; 2]> = OnceLock::new();
    BOTH.get_or_init(create_reports)
}

#[test]
fn the_report_has_the_outcome() {
    let [checked, tested] = reports();
    assert_eq!(checked.outcome.kind, OutcomeKind::Failed, "a file can't be opened");
    assert_eq!(checked.outcome.text, "Failed: 1 file can't be opened");
    assert!(checked.outcome.remarks[0].starts_with("Does not conform: "), "{:?}", checked.outcome);
    assert_eq!((tested.outcome.kind, tested.outcome.status), (OutcomeKind::Failed, 3));
    // Every rule has the worst verdict among its mutants.
    assert_eq!(checked.rules.len(), RULES.len());
    let violated: BTreeSet<&str> = captured_mutants().map(|mutant| mutant.rule.id).collect();
    for rule in &checked.rules {
        let is_violated = rule.verdict >= Verdict::Shown && rule.verdict != Verdict::Pass;
        assert!(is_violated || !violated.contains(rule.id), "{}", rule.id);
        let counted: u64 = checked
            .subjects
            .iter()
            .flat_map(|one| &one.rules)
            .filter(|one| one.id == rule.id)
            .map(|one| one.findings)
            .sum();
        assert_eq!(rule.findings, counted, "{}", rule.id);
    }
    let of_testee: Vec<Verdict> = tested.rules.iter().map(|rule| rule.verdict).collect();
    assert!(!of_testee.is_empty() && of_testee.contains(&Verdict::Fail), "{of_testee:?}");
}

#[test]
fn the_same_run_produces_the_same_bytes() {
    for (one, other) in reports().iter().zip(create_reports()) {
        for kind in [Kind::Text, Kind::Json, Kind::Junit, Kind::Sarif, Kind::Html, Kind::Markdown] {
            assert!(one.to_text(kind) == other.to_text(kind), "{kind:?}");
        }
    }
}

#[test]
fn json_follows_the_published_schema_and_preserves_texts() {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../generated/schemas/uavspec/report.schema.json");
    let schema = fs::read_to_string(path).expect("a schema");
    let schema: Value = serde_json::from_str(&schema).expect("JSON");
    let validator = jsonschema::validator_for(&schema).expect("a schema");
    for report in reports() {
        let mut value: Value = serde_json::from_str(&report.to_text(Kind::Json)).expect("JSON");
        let errors: Vec<String> = validator
            .iter_errors(&value)
            .map(|error| format!("{}: {error}", error.instance_path()))
            .collect();
        assert_eq!(errors, Vec::<String>::new());
        value["subjects"][0]["rules"][0]["verdict"] = json!("fine");
        assert!(!validator.is_valid(&value), "the schema rejects unknown verdicts");
    }
    let [checked, tested] = reports()
        .each_ref()
        .map(|report| -> Value { serde_json::from_str(&report.to_text(Kind::Json)).expect("JSON") });
    let last = checked["subjects"].as_array().and_then(|all| all.last()).expect("a subject");
    assert_eq!(last["path"], format!("{HOSTILE}.jsonl"));
    let finding = &last["findings"][0];
    assert_eq!((&finding["rule"], &finding["known"]["reason"]), (&"PX-ARR-01".into(), &HOSTILE.into()));
    assert_eq!(finding["definition"]["file"], "definitions/px4/UnregisterExtComponent.msg");
    assert!(
        finding["definition"]["text"].as_str().is_some_and(|text| text.contains("char[25] name")),
        "{finding}"
    );
    assert_eq!(finding["examples"][0]["expected"], "at most 25 bytes");
    assert!(finding["examples"][0].get("line").is_some(), "{finding}");
    // Passed cases are only counted.
    let cases = tested["subjects"][0]["cases"].as_array().expect("cases");
    assert!(cases.iter().all(|case| case["verdict"] != "pass") && cases.len() > 10);
    assert!(tested["subjects"][0]["counts"]["pass"].as_u64() > Some(10));
}

/// The text of a page, and its tags. Fails if a tag isn't opened or closed properly.
fn read_html(page: &str) -> (String, BTreeSet<String>) {
    let (mut text, mut tags, mut open) = (String::new(), BTreeSet::new(), Vec::new());
    let (mut anchors, mut targets) = (BTreeSet::new(), BTreeSet::new());
    for token in Tokenizer::new(page) {
        match token.expect("a token") {
            Token::StartTag(tag) => {
                let name = String::from_utf8(tag.name.to_vec()).expect("UTF-8");
                for (attribute, value) in &tag.attributes {
                    let value = String::from_utf8_lossy(value).into_owned();
                    match &***attribute {
                        b"href" => {
                            if let Some(target) = value.strip_prefix('#') {
                                targets.insert(target.to_owned());
                            } else {
                                let mut known =
                                    site_url().into_iter().chain(["https://doc.collmot.com/public/"]);
                                assert!(known.any(|start| value.starts_with(start)), "{value}");
                            }
                        }
                        b"id" => assert!(anchors.insert(value.clone()), "duplicate anchor {value}"),
                        other => assert!(!other.starts_with(b"on") && *other != b"src"[..], "{name}"),
                    }
                }
                if name != "meta" {
                    open.push(name.clone());
                }
                tags.insert(name);
            }
            Token::EndTag(tag) => {
                assert_eq!(
                    open.pop().map(String::into_bytes),
                    Some(tag.name.to_vec()),
                    "the tag that is open"
                );
            }
            Token::String(string) => text.push_str(&String::from_utf8_lossy(&string)),
            Token::Error(error) => panic!("{error:?}"),
            Token::Comment(_) | Token::Doctype(_) => {}
        }
    }
    assert_eq!(open, Vec::<String>::new());
    assert!(targets.is_subset(&anchors), "missing anchors: {targets:?}, found {anchors:?}");
    (text, tags)
}

#[test]
fn html_is_well_formed_and_escapes_the_input() {
    for report in reports() {
        let page = report.to_text(Kind::Html);
        let (text, tags) = read_html(&page);
        let unwanted = ["script", "img", "iframe", "link", "object", "form", "b"];
        assert!(unwanted.iter().all(|tag| !tags.contains(*tag)), "{tags:?}");
        assert!(["h1", "table", "th", "details", "dl"].iter().all(|tag| tags.contains(*tag)), "{tags:?}");
        assert!(text.contains("<script>alert(1)</script>"), "the input is shown as text");
        assert!(text.contains(r"\u{202e}") && text.contains(r"\u{1b}"), "invisible characters are escaped");
        let is_invisible = |character: char| {
            character.is_control() && character != '\n' || matches!(character, '\u{202a}'..='\u{202e}')
        };
        assert!(!page.contains(is_invisible));
        assert!(page.contains(&format!("<h1>{}</h1>", page_escaped(&report.outcome.text))), "the headline");
    }
}

/// A headline as escaped in the page.
fn page_escaped(text: &str) -> String {
    let shown = text.escape_debug().to_string().replace("\\\"", "\"").replace("\\'", "'");
    shown.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[test]
fn markdown_escapes_the_input() {
    use pulldown_cmark::{Event, Options, Parser, Tag};
    for report in reports() {
        let text = report.to_text(Kind::Markdown);
        let (mut headings, mut columns) = (0, BTreeSet::new());
        for event in Parser::new_ext(&text, Options::ENABLE_TABLES) {
            match event {
                Event::Start(Tag::Heading { .. }) => headings += 1,
                Event::Start(Tag::Link { dest_url, .. }) => {
                    let is_page = |site| dest_url.starts_with(&format!("{site}/docs/rules/"));
                    assert!(site_url().is_some_and(is_page), "{dest_url}");
                }
                Event::Start(Tag::Table(alignments)) => _ = columns.insert(alignments.len()),
                Event::Html(html) => assert!(html.starts_with("<!-- Generated"), "{html}"),
                Event::InlineHtml(html) => assert!(matches!(&*html, "<code>" | "</code>"), "{html}"),
                _ => {}
            }
        }
        // The table lists only rules beyond the maximum number, so it is missing in a quick run.
        assert!(headings > 5 && extent(!columns.is_empty(), true), "{headings} {columns:?}");
        assert!(!text.contains(['\u{202e}', '\u{1b}']));
        assert!(text.len() < 65_536, "too long for a comment on GitHub: {}", text.len());
    }
}

/// Parses a `JUnit` report. Asserts that misleading characters are escaped everywhere except in paths.
fn read(report: &Report) -> Junit {
    let text = report.to_text(Kind::Junit);
    let junit = Junit::deserialize_from_str(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    for case in junit.test_suites.iter().flat_map(|suite| &suite.test_cases) {
        let (message, description) = match &case.status {
            TestCaseStatus::NonSuccess { message, description, .. }
            | TestCaseStatus::Skipped { message, description, .. } => (message, description),
            TestCaseStatus::Success { .. } => (&None, &None),
        };
        let shown = [message, description, &case.classname, &case.system_out, &case.system_err];
        let shown: String = shown.into_iter().flatten().map(quick_junit::XmlString::as_str).collect();
        assert!(!format!("{}{shown}", case.name.as_str()).contains('\u{202e}'), "{case:?}");
    }
    junit
}

#[test]
fn junit_has_a_case_for_each_rule_or_request() {
    let [checked, tested] = reports();
    let junit = read(checked);
    let [.., unreadable, whole] = &junit.test_suites[..] else { panic!("{junit:?}") };
    assert_eq!(junit.test_suites.len(), checked.subjects.len() + 2);
    for (suite, subject) in junit.test_suites.iter().zip(&checked.subjects) {
        assert_eq!(suite.test_cases.len(), subject.rules.len() + 1);
        for rule in &subject.rules {
            let case =
                suite.test_cases.iter().find(|case| case.name.as_str().starts_with(rule.id)).expect("a case");
            let is_right = match (&case.status, rule.verdict) {
                (TestCaseStatus::NonSuccess { kind, description, .. }, Verdict::Fail) => {
                    *kind == NonSuccessKind::Failure && description.is_some()
                }
                (TestCaseStatus::Success { .. }, Verdict::Warn | Verdict::Shown) => case.system_out.is_some(),
                (TestCaseStatus::Success { .. }, Verdict::Pass) => case.system_out.is_none(),
                (TestCaseStatus::Skipped { .. }, Verdict::NotCovered) => true,
                _ => false,
            };
            assert!(is_right, "{} {:?}: {:?}", rule.id, rule.verdict, case.status);
        }
    }
    let is = |case: &TestCase, expected: NonSuccessKind| matches!(case.status, TestCaseStatus::NonSuccess { kind, .. } if kind == expected);
    let is_error = |case: &TestCase| is(case, NonSuccessKind::Error);
    assert!(is_error(&unreadable.test_cases[0]), "{unreadable:?}");
    assert!(is(&whole.test_cases[0], NonSuccessKind::Failure), "{whole:?}");
    let junit = read(tested);
    let [suite] = &junit.test_suites[..] else { panic!("{junit:?}") };
    let requested = usize::try_from(tested.subjects[0].records).expect("small");
    assert_eq!(suite.test_cases.len(), requested + 2, "the cases, the protocol, and the run itself");
    assert!(
        suite.test_cases.iter().filter(|case| is_error(case)).count() > 2,
        "crashes and hangs are errors"
    );
    let is_failed = |case: &&TestCase| matches!(&case.status, TestCaseStatus::NonSuccess { ty: Some(ty), .. } if ty.as_str() == "failed");
    let failed = suite.test_cases.iter().find(is_failed).expect("the run failed");
    assert_eq!(failed.name.as_str(), "run completes");
    let names: BTreeSet<_> =
        suite.test_cases.iter().map(|case| (case.classname.clone(), case.name.clone())).collect();
    assert_eq!(names.len(), suite.test_cases.len(), "class and name identify a case");
}

#[test]
fn sarif_has_rules_with_help_and_locations() {
    let [checked, tested] = reports();
    let log: Value = serde_json::from_str(&checked.to_text(Kind::Sarif)).expect("JSON");
    let run = &log["runs"][0];
    let rules = run["tool"]["driver"]["rules"].as_array().expect("rules");
    for (rule, written) in RULES.iter().zip(rules) {
        assert_eq!(written["id"], rule.id);
        assert_eq!(written["helpUri"].as_str().unwrap_or_default(), rule_url(rule.id));
        assert_eq!(written["fullDescription"]["text"], rule.statement);
    }
    let results = run["results"].as_array().expect("results");
    let region = |rule: &str, path: &str| {
        let of = |result: &&Value| {
            let physical = &result["locations"][0]["physicalLocation"];
            result["ruleId"] == rule
                && physical["artifactLocation"]["uri"].as_str().is_some_and(|uri| uri.starts_with(path))
        };
        results.iter().find(of).map(|result| result["locations"][0]["physicalLocation"]["region"].clone())
    };
    let of_log = region("PX-BOOL-01", "PX-BOOL-01").expect("a result");
    assert!(of_log["byteOffset"].as_u64() > Some(0), "{of_log}");
    let of_lines = region("PX-ARR-01", "PX-ARR-01").expect("a result");
    assert!(of_lines["startLine"].as_u64() > Some(0), "{of_lines}");
    for result in results {
        let index = usize::try_from(result["ruleIndex"].as_u64().expect("an index")).expect("small");
        assert_eq!(rules[index]["id"], result["ruleId"]);
        let text = result["message"]["text"].as_str().expect("a message");
        assert!(!text.contains(['\u{1b}', '\u{202e}']) && !text.contains("](javascript"), "{text}");
        assert!(text.chars().count() < 10_000, "{text}");
    }
    let log: Value = serde_json::from_str(&tested.to_text(Kind::Sarif)).expect("JSON");
    let results = log["runs"][0]["results"].as_array().expect("results");
    let is_of_event =
        |result: &&Value| result["message"]["text"].as_str().is_some_and(|text| text.contains("/px4/Event/"));
    let result = results.iter().find(is_of_event).expect("a result");
    let location = &result["locations"][0]["physicalLocation"];
    assert_eq!(location["artifactLocation"]["uri"], "definitions/px4/Event.msg");
    assert!(location["region"]["startLine"].as_u64() > Some(0), "{location}");
}

#[test]
fn code_quality_has_the_findings_of_sarif() {
    for report in reports() {
        let log: Value = serde_json::from_str(&report.to_text(Kind::Sarif)).expect("JSON");
        let results = log["runs"][0]["results"].as_array().expect("results");
        let issues: Vec<Value> =
            serde_json::from_str(&report.to_text(Kind::Codequality)).expect("a JSON list");
        assert!(!issues.is_empty());
        assert_eq!(issues.len(), results.len());
        for (issue, result) in issues.iter().zip(results) {
            assert_eq!(issue["check_name"], result["ruleId"]);
            let severity = match result["level"].as_str() {
                Some("error") => "major",
                Some("warning") => "minor",
                _ => "info",
            };
            assert_eq!(issue["severity"], severity);
            assert!(issue["location"]["path"].as_str().is_some_and(|path| !path.is_empty()), "{issue}");
            assert!(issue["location"]["lines"]["begin"].as_u64() > Some(0), "{issue}");
        }
    }
}

/// Every format contains the location in the record, the value found, and the command that reproduces the finding.
#[test]
fn each_format_reports_the_path_and_the_value_found() {
    let definitions = Definitions::built_in();
    let of = |path: &str, bytes: &[u8]| {
        let result = check_capture(bytes, None, &definitions).expect("bytes can be read");
        let checked = CheckedCapture {
            path: path.to_owned(),
            result,
            notes: Vec::new(),
            requests: Vec::new(),
            cut_short: Vec::new(),
            elapsed: 0,
        };
        let subject = Subject::from_capture(checked, &definitions, &Settings::default());
        Report::new(Action::Check, String::new(), &definitions.name, vec![subject], Vec::new(), Vec::new())
    };
    let message = json!({"timestamp": 1, "name": "wind", "mode_id": 1, "mode_executor_id": 1});
    let line = json!({"op": "publish", "topic": "/fmu/in/unregister_ext_component", "msg": message});
    let report = of("-it's a \"log\".jsonl", line.to_string().as_bytes());
    let (pointer, excerpt) =
        ("/msg/arming_check_id", r#"{"timestamp": 1, "name": "wind", "mode_id": 1, "mode_executor_id": 1}"#);
    let command = r#"uavspec check "./-it's a \"log\".jsonl""#;
    assert_eq!(
        shlex::split(command).expect("words"),
        ["uavspec", "check", "./-it's a \"log\".jsonl"],
        "the command as parsed by a shell"
    );
    let json: Value = serde_json::from_str(&report.to_text(Kind::Json)).expect("JSON");
    let finding = &json["subjects"][0]["findings"][0];
    assert_eq!((&finding["examples"][0]["path"], &finding["reproduce"]), (&pointer.into(), &command.into()));
    assert_eq!(finding["examples"][0]["excerpt"], excerpt);
    let sarif: Value = serde_json::from_str(&report.to_text(Kind::Sarif)).expect("JSON");
    let result = &sarif["runs"][0]["results"][0];
    assert_eq!(result["locations"][0]["logicalLocations"][0]["fullyQualifiedName"], pointer);
    assert_eq!(result["properties"]["excerpt"], excerpt);
    assert!(result["message"]["text"].as_str().is_some_and(|text| text.contains(command)), "{result}");
    let junit = read(&report);
    let cases = junit.test_suites.iter().flat_map(|suite| &suite.test_cases);
    let text: String = cases
        .filter_map(|case| match &case.status {
            TestCaseStatus::NonSuccess { description, .. } => description.as_ref(),
            _ => None,
        })
        .map(quick_junit::XmlString::as_str)
        .collect();
    let (html, _) = read_html(&report.to_text(Kind::Html));
    let markdown: String = pulldown_cmark::Parser::new(&report.to_text(Kind::Markdown))
        .filter_map(|event| match event {
            pulldown_cmark::Event::Text(text) | pulldown_cmark::Event::Code(text) => Some(text.into_string()),
            _ => None,
        })
        .collect();
    for text in [text, html, markdown] {
        for wanted in [pointer, excerpt, command] {
            assert!(text.contains(wanted), "{wanted} in {text}");
        }
    }
}

#[test]
fn escapes_terminal_sequences_of_the_input() {
    for report in reports() {
        let text = report.to_text(Kind::Text);
        let text = anstream::adapter::strip_str(&text).to_string();
        assert!(!text.contains(['\u{1b}', '\u{7}', '\u{202e}', '\r']));
        assert!(text.contains(r"\u{202e}"));
    }
}
