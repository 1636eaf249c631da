//! Tests of the content of pages and of Markdown reports, which are in the same order.

use std::fs;
use std::path::Path;
use std::time::Duration;

use serde_json::{Value, json};
use uavspec_check::{Checked, check_bytes, check_capture};
use uavspec_probe::RequestType;
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::sample::story;

use crate::{Action, CheckedCapture, Kind, Report, Settings, Subject, Unreadable};

const URL: &str = "tcp://localhost:5001";
const FAILURE: &str = "connection refused";

pub(crate) fn subject(path: &str, bytes: &[u8], requests: Vec<RequestType>) -> Subject {
    let definitions = Definitions::built_in();
    let result = check_capture(bytes, None, &definitions).expect("bytes can be read");
    let checked = CheckedCapture { requests, ..CheckedCapture::new(path.to_owned(), result, Duration::ZERO) };
    Subject::from_capture(checked, &definitions, &Settings::default())
}

fn report(action: Action, subjects: Vec<Subject>, unreadable: Vec<Unreadable>) -> Report {
    let definitions = Definitions::built_in().name;
    Report::new(action, "uavspec".to_owned(), &definitions, subjects, unreadable, Vec::new())
}

/// A session with a wrong heading in an answer and in a notification.
fn session() -> Vec<u8> {
    let line = |time: f64, direction: &str, message: &Value| {
        let line = json!({ "t": time, "conn": "tcp#<7>", "dir": direction, "msg": message });
        format!("{line}\n")
    };
    let status = json!({ "glider-1": { "id": "glider-1", "heading": 3600 } });
    let message = |id: &str, body: Value| json!({ "$fw.version": "1.0", "id": id, "body": body });
    let mut answer = message("b", json!({ "type": "UAV-INF", "status": status }));
    answer["refs"] = "a".into();
    let lines = [
        line(1.8e9, "out", &message("a", json!({ "type": "UAV-INF", "ids": ["glider-1"] }))),
        line(1.8e9 + 0.25, "in", &answer),
        line(1.8e9 + 1.5, "in", &message("c", json!({ "type": "UAV-INF", "status": status }))),
    ];
    lines.concat().into_bytes()
}

fn probed(requests: Vec<RequestType>, unreadable: Vec<Unreadable>) -> Report {
    report(Action::Probe, vec![subject(URL, &session(), requests)], unreadable)
}

fn request_type(name: &str, not_sent: Option<&str>) -> RequestType {
    let sent = u64::from(not_sent.is_none());
    RequestType {
        name: name.to_owned(),
        sent,
        answered: sent,
        refused: 0,
        not_sent: not_sent.map(str::to_owned),
    }
}

/// A file with a message for each name. Each message violates PX-ARR-01, and the field with this name is out of range.
fn file(path: &str, names: &[&str]) -> Subject {
    let message = json!({ "timestamp": 1, "arming_check_id": 2, "mode_id": 3, "mode_executor_id": -1, "name": "x".repeat(26) });
    let line = |name: &&str| {
        let mut message = message.clone();
        message[*name] = 1000.into();
        format!("{}\n", json!({ "type": "px4/UnregisterExtComponent", "message": message }))
    };
    subject(path, names.iter().map(line).collect::<String>().as_bytes(), Vec::new())
}

/// Asserts that the texts occur in this order.
fn assert_order(page: &str, texts: &[&str]) {
    let mut rest = page;
    for text in texts {
        let (_, after) = rest.split_once(text).unwrap_or_else(|| panic!("no {text} in {rest}"));
        rest = after;
    }
}

#[test]
fn findings_come_first_and_passed_rules_are_folded_at_the_end() {
    let page = probed(Vec::new(), Vec::new()).to_text(Kind::Html);
    let rule = "<h3 id=\"FW-UST-HEADING\">";
    assert_order(
        &page,
        &["<h1>", "Checked: ", ">Findings</h2>", rule, "tenths of a degree", ">Other rules</h2>", "<details"],
    );
    let (_, others) = page.split_once(">Other rules</h2>").expect("a section");
    let before_tables = others.split("<table").next().expect("text");
    assert!(before_tables.contains("<details") && before_tables.contains(" passed</summary>"), "{others}");
    assert_order(others, &["passed</summary>", "FW-ENV-01<", "not covered</summary>", "</main>"]);

    let markdown = probed(Vec::new(), Vec::new()).to_text(Kind::Markdown);
    let title = "`FW-UST-HEADING`";
    assert_order(
        &markdown,
        &["# ❌ ", "checked: ", "## Findings", "### fail: ", title, "## `tcp://", "rules passed: "],
    );
}

#[test]
fn an_example_has_its_time_connection_request_and_answer() {
    let report = probed(Vec::new(), Vec::new());
    let place = "at line 2 after 0.250 s (2027-01-15T08:00:00.250Z) on tcp#";
    let page = report.to_text(Kind::Html);
    let (_, rule) = page.split_once("<h3 id=\"FW-UST-HEADING\">").expect("a rule");
    let rule = rule.split("</section>").next().expect("a section");
    assert!(rule.contains(&format!("<p class=\"aside\">2 times, first {place}&lt;7&gt;</p>")), "{rule}");
    assert_order(
        rule,
        &[
            "<div class=\"exchange\">",
            "<figcaption>Request</figcaption>",
            "&quot;ids&quot;: [&quot;glider-1&quot;]",
            "<figcaption>Answer</figcaption>",
            "&quot;heading&quot;: 3600",
            "Other examples",
            "at line 3 after 1.500 s",
            // The notification belongs to no request.
            "<figcaption>Excerpt</figcaption>",
        ],
    );
    let markdown = report.to_text(Kind::Markdown);
    assert_order(
        &markdown,
        &[place, "\nRequest:", "\"ids\": [\"glider-1\"]", "\nAnswer:", "\"heading\": 3600"],
    );
}

#[test]
fn a_server_is_not_called_a_file() {
    let failure = Unreadable { path: URL.to_owned(), message: FAILURE.to_owned() };
    for report in [probed(Vec::new(), Vec::new()), probed(Vec::new(), vec![failure])] {
        let is_failed = !report.unreadable.is_empty();
        let page = report.to_text(Kind::Html);
        let (_, page) = page.split_once("<main>").expect("content");
        // The statements of rules mention other files.
        let (page, _) = page.split_once(">Other rules</h2>").expect("a section");
        assert!(!page.contains("file") && !page.contains("File"), "{page}");
        assert!(page.contains(&format!("Server <code class=\"path\">{URL}</code></h2>")), "{page}");
        assert_eq!(page.contains(FAILURE), is_failed, "{page}");
    }
}

#[test]
fn a_session_without_a_recording_has_no_lines() {
    let mut report = probed(Vec::new(), Vec::new());
    report.subjects[0].is_readable_again = false;
    let place = "2 times, first after 0.250 s (2027-01-15T08:00:00.250Z) on tcp#";
    for kind in [Kind::Html, Kind::Markdown] {
        let page = report.to_text(kind);
        assert!(page.contains(place) && !page.contains("at line 2"), "{page}");
    }
}

#[test]
fn a_file_that_cannot_be_opened_is_listed_with_its_reason() {
    let unreadable = Unreadable { path: "gone.ulg".to_owned(), message: FAILURE.to_owned() };
    let page = report(Action::Check, Vec::new(), vec![unreadable]).to_text(Kind::Html);
    assert_order(&page, &["no files", ">Files</h2>", "gone.ulg", FAILURE]);
}

#[test]
fn request_types_are_folded_and_those_not_sent_come_first() {
    let requests = vec![
        request_type("AUTH-INF", None),
        request_type("AUTH-REQ", Some("<needs> --login")),
        request_type("SYS-VER", None),
    ];
    let page = probed(requests, Vec::new()).to_text(Kind::Html);
    assert_order(
        &page,
        &[
            "<summary>Request types: 2 sent, 1 not sent</summary>",
            "<th class=\"number\" scope=\"col\">Refused</th>",
            "AUTH-REQ",
            "not sent: &lt;needs&gt; --login",
            "AUTH-INF",
            "SYS-VER",
            "</table>",
        ],
    );
    let without = probed(Vec::new(), Vec::new()).to_text(Kind::Html);
    assert!(!without.contains("Request types"), "{without}");
}

#[test]
fn a_rule_has_one_heading_for_all_files() {
    let report = report(
        Action::Check,
        vec![
            file("first.jsonl", &["arming_check_id"]),
            file("second.jsonl", &["arming_check_id", "mode_id"]),
        ],
        Vec::new(),
    );
    let page = report.to_text(Kind::Html);
    assert_eq!(page.matches("<h3 id=\"PX-ARR-01\">").count(), 1);
    assert_order(
        &page,
        &[
            "<h3 id=\"PX-ARR-01\">",
            "3 findings in ",
            "3 times in 2 files, first in first.jsonl at line 1",
            "<summary>1 other file</summary>",
            "second.jsonl",
            "2 times, first at line 1",
            ">Files</h2>",
        ],
    );
    let markdown = report.to_text(Kind::Markdown);
    assert_eq!(markdown.matches("`PX-ARR-01`").count(), 1);
    assert!(markdown.contains("3 times in 2 files, first in first.jsonl at line 1"), "{markdown}");
}

#[test]
fn disputed_rules_say_so() {
    let message = json!({ "$fw.version": "1.0", "id": "a", "body": null });
    let line = json!({ "conn": "x", "dir": "in", "msg": message });
    let report =
        report(Action::Check, vec![subject("a.jsonl", line.to_string().as_bytes(), Vec::new())], Vec::new());
    let listed: Vec<_> = report.rules.iter().filter(|rule| rule.id == "FW-ENV-11").collect();
    assert_eq!((listed[0].status.as_str(), listed[0].findings), ("disputed", 1));
    let page = report.to_text(Kind::Html);
    assert_order(&page, &["<h3 id=\"FW-ENV-11\">", ">SHOULD, disputed</span></h3>", "Disputed: "]);
    let markdown = report.to_text(Kind::Markdown);
    assert_order(&markdown, &["### warning: ", "`FW-ENV-11`", " SHOULD, disputed\n"]);
}

/// Compares a page with the published one on the documentation site.
pub(crate) fn compare_with_site(name: &str, page: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../xtask/site").join(name);
    if std::env::var_os("UAVSPEC_UPDATE_FIXTURES").is_some() {
        fs::write(path, page).expect("a writable file");
        return;
    }
    let on_site = fs::read_to_string(path).expect("a page of the site");
    assert!(on_site == page, "run `UAVSPEC_UPDATE_FIXTURES=1 cargo test -p uavspec-report html`");
}

#[test]
fn the_report_on_the_documentation_site_is_up_to_date() {
    let [story::File { name, content: log, .. }, ..] = story::files().expect("the sample");
    let Checked { definitions, result } = check_bytes(&log, &Library::built_in()).expect("a log");
    let checked = CheckedCapture::new(name.to_owned(), result, Duration::ZERO);
    let subject = Subject::from_capture(checked, &definitions, &Settings::default());
    let command = format!("uavspec check {name} --report html=report.html");
    let report =
        Report::new(Action::Check, command, &definitions.name, vec![subject], Vec::new(), Vec::new());
    let page = report.to_text(Kind::Html);
    assert_order(&page, &["<h3 id=\"PX-TIME-01\">", "is earlier than the previous timestamp"]);
    compare_with_site("report.html", &page);
}
