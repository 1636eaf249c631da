//! Tests that read each format back and compare the values.

use serde_json::{Value, json};
use uavspec_schema::diagnostic::{Level, Problem};
use uavspec_schema::finding::Finding;
use uavspec_schema::source::{Position, SourceMap, Span};
use uavspec_schema::terminal::guarded;

use super::*;
use crate::RULES;

/// Characters with a special meaning in one of the formats.
const HOSTILE: &str =
    "50% ]]> <b a=\"'\"> &amp; [x](javascript:y) a:b,c\r\n::error::x\u{7}\u{1b}[31m\u{ffff} é 🛩";

/// A path with spaces and other characters that must be escaped in URLs and workflow commands.
const PATH: &str = "msg/Flügel a%20b#1,2:3.msg";

fn place(path: &str, line: usize, column: usize, end_column: usize) -> Place {
    let start = Position { line, column };
    let region = Region::Text { start, end: Position { line, column: end_column } };
    Place { path: path.to_owned(), region }
}

fn entry(rule: &'static str, level: Level, message: &str) -> Entry {
    Entry {
        rule: rule.into(),
        category: None,
        level,
        message: message.to_owned(),
        help: "do so".to_owned(),
        place: place(PATH, 3, 5, 9),
        sides: None,
        related: Vec::new(),
        part: String::new(),
        facts: Vec::new(),
        is_fixable: false,
        url: url(rule),
    }
}

/// The URL of a rule's page on a published site.
fn url(rule: &str) -> String {
    format!("https://example.org/{}", rule_page(rule))
}

fn report(entries: Vec<Entry>) -> Report {
    let info = |id, level| RuleInfo { url: url(id), ..RuleInfo::new(id, "Say `x`. Since y.", level) };
    let rules = vec![info("quiet", Level::Error), info("unit-missing", Level::Warning)];
    Report { command: "lint", rules, entries }
}

fn hostile() -> Report {
    let compared = Entry {
        category: Some("wire"),
        sides: Some((Some(place("old/A.msg", 1, 2, 3)), None)),
        related: vec![(place("B.msg", 7, 8, 9), HOSTILE.to_owned())],
        help: HOSTILE.to_owned(),
        part: "/msg/a~1b".to_owned(),
        facts: vec![("expected", "a [link](to nowhere)".to_owned())],
        is_fixable: true,
        ..entry("unit-missing", Level::Warning, HOSTILE)
    };
    let note = entry("unit-missing", Level::Note, "only a note");
    report(vec![compared, entry("unknown-type", Level::Error, "no message `Wnd`"), note])
}

fn sarif(report: &Report) -> Value {
    serde_json::from_str(&report.to_text(Format::Sarif)).expect("JSON")
}

#[test]
fn sarif_contains_all_findings() {
    let report = hostile();
    let log = sarif(&report);
    let run = &log["runs"][0];
    assert_eq!((&log["version"], &run["columnKind"]), (&json!("2.1.0"), &json!("unicodeCodePoints")));
    assert_eq!(run["tool"]["driver"]["name"], "uavspec");
    let [compared, error, note] = &run["results"].as_array().expect("results")[..] else { panic!("{run}") };
    assert_eq!(compared["locations"][0]["logicalLocations"][0]["fullyQualifiedName"], "/msg/a~1b");
    assert!(error["locations"][0].get("logicalLocations").is_none(), "{error}");
    let texts = HOSTILE.replace("](", "] (");
    assert_eq!(compared["message"]["text"], format!("{texts}\n{texts}"));
    assert_eq!(compared["level"], "warning");
    assert_eq!(
        compared["properties"],
        json!({ "category": "wire", "fixable": true, "expected": "a [link](to nowhere)" })
    );
    let physical = &compared["locations"][0]["physicalLocation"];
    assert_eq!(physical["artifactLocation"]["uri"], "msg/Fl%C3%BCgel%20a%2520b%231%2C2%3A3.msg");
    assert_eq!(physical["region"], json!({ "startLine": 3, "startColumn": 5, "endLine": 3, "endColumn": 9 }));
    let related = compared["relatedLocations"].as_array().expect("places");
    assert_eq!(related[0]["message"]["text"], "before");
    assert_eq!(related[0]["physicalLocation"]["artifactLocation"]["uri"], "old/A.msg");
    assert_eq!(related[1]["message"]["text"], texts);
    assert_eq!((&error["level"], &note["level"]), (&json!("error"), &json!("note")));
    assert!(error.get("relatedLocations").is_none() && error["properties"].get("category").is_none());
}

#[test]
fn every_result_of_sarif_has_its_rule() {
    let log = sarif(&hostile());
    let rules = log["runs"][0]["tool"]["driver"]["rules"].as_array().expect("rules").clone();
    let ids: Vec<&Value> = rules.iter().map(|rule| &rule["id"]).collect();
    assert_eq!(ids, ["quiet", "unit-missing", "unknown-type"], "parser errors follow the rules");
    for result in log["runs"][0]["results"].as_array().expect("results") {
        let index = usize::try_from(result["ruleIndex"].as_u64().expect("an index")).expect("small");
        assert_eq!(rules[index]["id"], result["ruleId"]);
    }
    assert_eq!(rules[1]["shortDescription"]["text"], "Say `x`.");
    assert_eq!(rules[1]["fullDescription"]["text"], "Say `x`. Since y.");
    assert_eq!(rules[1]["helpUri"], "https://example.org/docs/rules/unit-missing.html");
    assert_eq!(rules[1]["defaultConfiguration"]["level"], "warning");
    assert_eq!(rules[2]["helpUri"], "https://example.org/docs/rules/reading.html#unknown-type");
    assert_eq!(rules[2]["defaultConfiguration"]["level"], "error");
}

#[test]
fn totals_are_part_of_formats_with_a_place_for_them() {
    let finding = |level| Finding::new("unit-missing", level, Span::default(), "`speed` has no unit");
    let findings = [finding(Level::Note), finding(Level::Warning), finding(Level::Note)];
    let totals = Totals { known: 2, ..Totals::of("lint", &findings, &SourceMap::default(), 3) };
    let counts: Vec<_> = totals.rules.iter().map(|total| (total.level, total.count)).collect();
    assert_eq!(counts, [(Level::Warning, 1), (Level::Note, 2)], "the most severe level is first");
    let report = hostile();
    let log: Value = serde_json::from_str(&report.to_text_with_totals(Format::Sarif, &totals)).expect("JSON");
    assert_eq!(log["runs"][0]["properties"]["totals"], totals.to_json());
    assert_eq!(totals.to_json()["known"], 2);
    let commands = report.to_text_with_totals(Format::Github, &totals);
    let (first, others) = commands.split_once('\n').expect("several lines");
    assert!(
        first.starts_with("::notice title=lint::level") && first.contains("1 warning, 2 notes"),
        "{first}"
    );
    assert_eq!(others, report.to_text(Format::Github));
    assert_eq!(report.to_text_with_totals(Format::Json, &totals), report.to_text(Format::Json));
}

#[test]
fn totals_count_each_change_once() {
    let finding = |category, level, message: &str| Finding {
        category: Some(category),
        ..Finding::new("field-removed", level, Span::default(), message)
    };
    let findings = [
        finding("json", Level::Error, "`a` was removed"),
        finding("cdr", Level::Note, "`a` was removed"),
        finding("cdr", Level::Error, "`b` was removed"),
    ];
    let totals = Totals::of("breaking", &findings, &SourceMap::default(), 1);
    assert_eq!(totals.headline(), "2 changes; incompatible: json 1, cdr 1");
    assert_eq!(totals.to_json()["categories"], json!({ "json": 1, "cdr": 1 }));
    let notes = findings.map(|finding| Finding { level: Level::Note, ..finding });
    let totals = Totals::of("breaking", &notes, &SourceMap::default(), 1);
    assert_eq!(totals.headline(), "2 changes; all compatible");
}

#[test]
fn fingerprints_survive_moves_and_distinguish_findings() {
    let fingerprints = |report: &Report| -> Vec<String> {
        let log = sarif(report);
        let results = log["runs"][0]["results"].as_array().expect("results").clone();
        results.iter().map(|result| result["partialFingerprints"]["uavspecFinding/v1"].to_string()).collect()
    };
    let first = entry("unit-missing", Level::Warning, "a");
    let twin = Entry { place: place(PATH, 9, 1, 2), ..first.clone() };
    let before = fingerprints(&report(vec![first.clone(), twin.clone()]));
    assert_ne!(before[0], before[1]);
    let moved = |entry: &Entry| Entry { place: place(PATH, 30, 7, 8), ..entry.clone() };
    assert_eq!(before, fingerprints(&report(vec![moved(&first), moved(&twin)])));
    for other in [
        Entry { message: "b".to_owned(), ..first.clone() },
        Entry { rule: "quiet".into(), ..first.clone() },
        Entry { category: Some("wire"), ..first.clone() },
        Entry { place: place("other.msg", 3, 5, 9), ..first.clone() },
    ] {
        assert_ne!(before[0], fingerprints(&report(vec![other]))[0]);
    }
}

#[test]
fn code_quality_contains_all_findings() {
    let byte = Entry {
        place: Place { path: "./logs/a.ulg".to_owned(), region: Region::Byte(77) },
        ..entry("odd", Level::Error, "odd value")
    };
    let mut report = hostile();
    report.entries.extend([byte.clone(), byte]);
    let issues: Vec<Value> = serde_json::from_str(&report.to_text(Format::Codequality)).expect("a JSON list");
    assert_eq!(issues.len(), report.entries.len());
    assert_eq!(
        [&issues[0]["description"], &issues[0]["check_name"], &issues[0]["severity"]],
        [&json!(format!("unit-missing: {HOSTILE} (wire)")), &json!("unit-missing"), &json!("minor")]
    );
    assert_eq!(issues[0]["location"], json!({ "path": PATH, "lines": { "begin": 3 } }));
    assert_eq!([&issues[1]["severity"], &issues[2]["severity"]], ["major", "info"]);
    assert_eq!(issues[3]["description"], "odd: odd value (byte 77)");
    assert_eq!(issues[3]["location"], json!({ "path": "logs/a.ulg", "lines": { "begin": 1 } }));
    let mut fingerprints: Vec<&Value> = issues.iter().map(|issue| &issue["fingerprint"]).collect();
    fingerprints.sort_by_key(ToString::to_string);
    fingerprints.dedup();
    assert_eq!(
        fingerprints.len(),
        issues.len(),
        "GitLab ignores an issue with the fingerprint of another one"
    );
    assert_eq!(self::report(Vec::new()).to_text(Format::Codequality), "[]\n");
}

#[test]
fn locations_become_uris() {
    for (path, expected) in [
        ("/a b/c.msg", "file:///a%20b/c.msg"),
        ("C:/a b/c.msg", "file:///C:/a%20b/c.msg"),
        ("../c.msg", "../c.msg"),
        ("c:d.msg", "c%3Ad.msg"),
        ("é", "%C3%A9"),
        ("tcp://127.0.0.1:5001", "tcp://127.0.0.1:5001"),
        ("ws://[::1]:5000/a b", "ws://[::1]:5000/a%20b"),
        ("s3://logs/a%20b/50%.ulg", "s3://logs/a%20b/50%25.ulg"),
        ("abfss://logs@account/é:1.ulg", "abfss://logs@account/%C3%A9%3A1.ulg"),
        ("a/b://c", "a/b%3A//c"),
        ("://c", "%3A//c"),
    ] {
        let entry = Entry { place: place(path, 1, 1, 1), ..entry("quiet", Level::Error, "a") };
        let log = sarif(&report(vec![entry]));
        let physical = &log["runs"][0]["results"][0]["locations"][0]["physicalLocation"];
        assert_eq!(physical["artifactLocation"]["uri"], expected);
    }
}

#[test]
fn each_workflow_command_is_one_line() {
    let text = hostile().to_text(Format::Github);
    let lines: Vec<&str> = text.split_terminator('\n').collect();
    assert_eq!(lines.len(), 3, "{text}");
    let commands: Vec<&str> = lines.iter().filter_map(|line| line.split(' ').next()).collect();
    assert_eq!(commands, ["::warning", "::error", "::notice"]);
    let unescaped = |text: &str| {
        let text = text.replace("%0A", "\n").replace("%0D", "\r").replace("%3A", ":").replace("%2C", ",");
        text.replace("%25", "%")
    };
    // Neither `::` nor `,` may end a property early.
    let (properties, message) = lines[0]["::warning ".len()..].split_once("::").expect("a message");
    let properties: Vec<String> = properties.split(',').map(unescaped).collect();
    let file = format!("file={PATH}");
    let title = "title=unit-missing (wire)";
    assert_eq!(properties, [&file, "line=3", "endLine=3", "col=5", "endColumn=9", title]);
    assert!(!message.contains('\r'), "{message}");
    let url = "https://example.org/docs/rules/unit-missing.html";
    let shown = guarded(HOSTILE);
    assert!(shown.contains(r"\r") && shown.contains(r"::\u{65}rror::x\u{7}\u{1b}[31m"), "{shown}");
    assert_eq!(unescaped(message), format!("{shown}\n{shown}\n{url}"));
}

/// Text that starts commands or hides itself in a log.
const LOGGED: [&str; 8] = [
    "::error::x",
    "a\n::error::x",
    "##[error]x",
    "a ##vso[task.complete]x",
    "\u{1b}[31m\u{9b}2J\r",
    "\u{202e}\u{2028}",
    "\u{200b}\u{e0041}",
    "\0\u{8}\u{ffff}",
];

#[test]
fn text_of_any_field_is_harmless_in_a_log() {
    for text in LOGGED {
        let owned = || text.to_owned();
        let entry = Entry {
            rule: owned().into(),
            category: Some("wire"),
            level: Level::Error,
            message: owned(),
            help: owned(),
            place: place(text, 1, 1, 2),
            part: owned(),
            facts: vec![("fact", owned())],
            sides: Some((Some(place(text, 1, 1, 2)), None)),
            related: vec![(place(text, 1, 1, 2), owned())],
            is_fixable: false,
            url: owned(),
        };
        let rule =
            RuleInfo { id: owned().into(), purpose: owned().into(), level: Level::Error, url: owned() };
        let report = Report { command: "lint", rules: vec![rule], entries: vec![entry] };
        for format in [Format::Json, Format::Sarif, Format::Junit] {
            let printed = report.to_text(format);
            assert_eq!(guarded(&printed), printed, "{format:?}");
        }
        let printed = report.to_text(Format::Github);
        let (command, rest) = printed.split_at("::error".len());
        assert_eq!((command, printed.lines().count()), ("::error", 1));
        assert_eq!(guarded(rest), rest);
    }
}

#[test]
fn json_preserves_texts() {
    let list: Value = serde_json::from_str(&hostile().to_text(Format::Json)).expect("JSON");
    assert_eq!((&list[0]["message"], &list[0]["file"]), (&json!(HOSTILE), &json!(PATH)));
    assert_eq!(list[1]["url"], "https://example.org/docs/rules/reading.html#unknown-type");
}

#[test]
fn reports_lines_bytes_and_whole_files() {
    let at = |region| {
        let place = Place { path: "a.ulg".to_owned(), region };
        let entry = Entry { place, url: String::new(), ..entry("quiet", Level::Error, "a") };
        let rule = RuleInfo { url: String::new(), ..RuleInfo::new("quiet", "Say.", Level::Error) };
        Report { command: "check", rules: vec![rule], entries: vec![entry] }
    };
    for (region, of_sarif, of_json, of_github) in [
        (Region::Byte(7), json!({ "byteOffset": 7 }), json!({ "byte": 7 }), ""),
        (Region::Line(7), json!({ "startLine": 7 }), json!({ "line": 7 }), ",line=7"),
        (Region::Whole, Value::Null, json!({}), ""),
    ] {
        let report = at(region);
        let log = sarif(&report);
        let physical = &log["runs"][0]["results"][0]["locations"][0]["physicalLocation"];
        assert_eq!(physical["region"], of_sarif);
        let rule = &log["runs"][0]["tool"]["driver"]["rules"][0];
        assert!(rule.get("helpUri").is_none() && rule["help"].get("markdown").is_none(), "{rule}");
        let list: Value = serde_json::from_str(&report.to_text(Format::Json)).expect("JSON");
        assert_eq!((&list[0]["line"], &list[0]["byte"]), (&of_json["line"], &of_json["byte"]));
        let github = report.to_text(Format::Github);
        assert!(github.starts_with(&format!("::error file=a.ulg{of_github},title=quiet::a")), "{github}");
    }
}

#[test]
fn rules_and_parser_errors_have_different_pages() {
    for kind in Problem::KINDS {
        let is_rule = RULES.iter().any(|rule| rule.id == kind.code);
        let page =
            if is_rule { format!("{}.html", kind.code) } else { format!("reading.html#{}", kind.code) };
        assert_eq!(rule_page(kind.code), format!("docs/rules/{page}"));
    }
    assert_eq!(rule_page("field-removed"), "docs/rules/field-removed.html");
    assert_eq!(rule_url("field-removed").is_empty(), site_url().is_none());
}

mod junit {
    use quick_junit::{Report as Read, TestCase, TestCaseStatus};

    use super::*;

    fn cases(report: &Report) -> Vec<TestCase> {
        let text = report.to_text(Format::Junit);
        let read = Read::deserialize_from_str(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let [suite] = &read.test_suites[..] else { panic!("{text}") };
        assert_eq!((suite.name.as_str(), suite.tests), (report.command, suite.test_cases.len()));
        suite.test_cases.clone()
    }

    fn class(case: &TestCase) -> &str {
        case.classname.as_deref().unwrap_or_default()
    }

    #[test]
    fn findings_fail_and_notes_do_not() {
        let cases = cases(&hostile());
        let classes: Vec<&str> = cases.iter().map(class).collect();
        assert_eq!(classes, ["lint.unit-missing", "lint.unknown-type", "lint.unit-missing", "lint.quiet"]);
        let TestCaseStatus::NonSuccess { message, ty, description, .. } = &cases[0].status else {
            panic!("{cases:?}")
        };
        let shown =
            "50% ]]> <b a=\"'\"> &amp; [x](javascript:y) a:b,c ::error::x\\u{7}\\u{1b}[31m\\u{ffff} é 🛩";
        assert_eq!((message.as_deref(), ty.as_deref()), (Some(shown), Some("unit-missing")));
        assert_eq!(cases[0].name.as_str(), format!("{PATH}: {shown} (wire)"));
        let of_lines = guarded(HOSTILE);
        let expected = format!(
            "{PATH}:3:5: warning[unit-missing] (wire): {of_lines}\nhelp: {of_lines}\nbefore: old/A.msg:1:2\n\
             B.msg:7:8: {of_lines}\nsee: https://example.org/docs/rules/unit-missing.html"
        );
        assert_eq!(description.as_deref(), Some(&expected[..]));
        assert_eq!(cases[0].extra["file"].as_str(), PATH);
        assert!(matches!(cases[1].status, TestCaseStatus::NonSuccess { .. }));
        for passed in &cases[2..] {
            assert!(matches!(passed.status, TestCaseStatus::Success { .. }), "{passed:?}");
        }
        assert!(cases[2].system_out.as_deref().is_some_and(|text| text.contains("only a note")));
    }

    #[test]
    fn names_are_unique_and_outlast_moves() {
        let first = entry("unit-missing", Level::Warning, &"long ".repeat(100));
        let twin = Entry { place: place(PATH, 9, 1, 2), ..first.clone() };
        let found = cases(&report(vec![first.clone(), twin]));
        assert_ne!(found[0].name, found[1].name);
        assert!(found[0].name.chars().count() < 300, "{}", found[0].name.as_str());
        let moved = Entry { place: place(PATH, 30, 7, 8), ..first };
        assert_eq!(cases(&report(vec![moved]))[0].name, found[0].name);
    }

    #[test]
    fn no_findings_are_a_passed_case() {
        let cases_of_rules = cases(&report(Vec::new()));
        assert_eq!(cases_of_rules.iter().map(class).collect::<Vec<_>>(), ["lint.quiet", "lint.unit-missing"]);
        let none = cases(&Report { command: "lint", rules: Vec::new(), entries: Vec::new() });
        assert!(matches!(none[..], [TestCase { status: TestCaseStatus::Success { .. }, .. }]), "{none:?}");
    }
}
