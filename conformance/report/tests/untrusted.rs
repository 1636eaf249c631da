//! Tests that untrusted text never changes the structure of a report, in any field of any format.

mod poison;

use std::io::Write as _;
use std::sync::OnceLock;

use html5gum::{Token, Tokenizer};
use proptest::prelude::*;
use proptest::sample::select;
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};
use quick_junit::{Report as Junit, TestCaseStatus, XmlString};
use regex_lite::Regex;
use serde_json::Value;
use uavspec_lint::report::site_url;
use uavspec_report::timeline::{to_html, to_json, to_text};
use uavspec_report::{Kind, Report};
use uavspec_schema::terminal::{Guard, guarded};
use uavspec_test_support::extent;

/// Fragments that have a special meaning in a terminal, a CI system, a markup language or on a website.
const FRAGMENTS: [&str; 63] = [
    "a",
    " ",
    "é",
    "\u{1b}[31m",
    "\u{1b}]0;title\u{7}",
    "\u{9b}2J",
    "\r",
    "\u{8}",
    "\0",
    "\t",
    "\u{7f}",
    "\u{85}",
    "\nFORGED",
    "\n::error::FORGED",
    "::error file=a::b",
    "::stop-commands::x",
    "##[error]x",
    "##vso[task.complete]x",
    "##teamcity[message text='x']",
    "section_start:1:x\r\u{1b}[0K",
    "\u{202e}",
    "\u{2066}",
    "\u{200f}",
    "\u{61c}",
    "\u{200b}",
    "\u{200d}",
    "\u{feff}",
    "\u{2028}",
    "\u{2029}",
    "\u{e0041}",
    "\u{ffff}",
    "@everyone",
    "a@b.org",
    "#1",
    "a/b#1",
    "GH-1",
    "!1",
    "0123456789abcdef",
    "0123456789abcdefé",
    "https://a.b/c",
    "www.a.b",
    ":tada:",
    "[x](javascript:y)",
    "![x](http://y)",
    "<https://a.b>",
    "[^1]",
    "[x]: /y",
    "*b*",
    "_i_",
    "~~s~~",
    "`",
    "```",
    "|",
    "\\",
    "# h",
    "> q",
    "- [ ] l",
    "<b onclick=x>",
    "</script><script>",
    "<!--",
    "]]>",
    "&amp;",
    "$x$",
];

/// The formats. Text has colours.
const KINDS: &[Kind] = &[
    Kind::Text,
    Kind::Short,
    Kind::Json,
    Kind::Junit,
    Kind::Sarif,
    Kind::Codequality,
    Kind::Html,
    Kind::Markdown,
];

/// The structure of each report if all texts are harmless.
fn expected() -> &'static [Vec<Vec<String>>] {
    static STRUCTURES: OnceLock<Vec<Vec<Vec<String>>>> = OnceLock::new();
    STRUCTURES.get_or_init(|| poison::reports("harmless").iter().map(structures).collect())
}

fn structures(report: &Report) -> Vec<Vec<String>> {
    KINDS.iter().map(|kind| structure(*kind, &report.to_text(*kind))).collect()
}

/// The elements of a document, without its text. Fails if the document isn't well-formed.
fn structure(kind: Kind, text: &str) -> Vec<String> {
    match kind {
        Kind::Text | Kind::Short => Vec::new(),
        Kind::Json | Kind::Sarif | Kind::Codequality => {
            let value: Value = serde_json::from_str(text).expect("JSON");
            vec![shape(&value)]
        }
        Kind::Junit => junit(text),
        Kind::Html => html(text),
        Kind::Markdown => markdown(text),
    }
}

/// The keys and lengths in a JSON value.
fn shape(value: &Value) -> String {
    match value {
        Value::Array(values) => format!("[{}]", values.iter().map(shape).collect::<Vec<_>>().join(",")),
        Value::Object(members) => {
            let members = members.iter().map(|(key, value)| format!("{key}:{}", shape(value)));
            format!("{{{}}}", members.collect::<Vec<_>>().join(","))
        }
        _ => String::new(),
    }
}

/// The test cases, each with its outcome.
fn junit(text: &str) -> Vec<String> {
    let junit = Junit::deserialize_from_str(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let cases = junit.test_suites.iter().flat_map(|suite| &suite.test_cases);
    let cases = cases.map(|case| {
        let is_clean = |text: &XmlString| assert_eq!(guarded(text), text.as_str());
        [Some(&case.name), case.classname.as_ref(), case.system_out.as_ref(), case.system_err.as_ref()]
            .into_iter()
            .flatten()
            .for_each(is_clean);
        match &case.status {
            TestCaseStatus::Success { .. } => "success",
            TestCaseStatus::NonSuccess { .. } => "failure",
            TestCaseStatus::Skipped { .. } => "skipped",
        }
        .to_owned()
    });
    cases.collect()
}

/// The tags with the names of their attributes.
fn html(page: &str) -> Vec<String> {
    let mut tags = Vec::new();
    for token in Tokenizer::new(page) {
        match token.expect("a token") {
            Token::StartTag(tag) => {
                let names = tag.attributes.keys().map(|name| String::from_utf8_lossy(name));
                let names: Vec<_> = names.collect();
                tags.push(format!("<{} {}>", String::from_utf8_lossy(&tag.name), names.join(" ")));
            }
            Token::EndTag(tag) => tags.push(format!("</{}>", String::from_utf8_lossy(&tag.name))),
            Token::String(_) => {}
            Token::Error(error) => panic!("{error:?}"),
            Token::Comment(_) => tags.push("comment".to_owned()),
            Token::Doctype(_) => tags.push("doctype".to_owned()),
        }
    }
    tags
}

/// The Markdown elements that GitHub recognizes, except code. Fails if GitHub would find a reference in text.
fn markdown(page: &str) -> Vec<String> {
    let options = Options::ENABLE_TABLES
        | Options::ENABLE_STRIKETHROUGH
        | Options::ENABLE_TASKLISTS
        | Options::ENABLE_FOOTNOTES
        | Options::ENABLE_MATH
        | Options::ENABLE_GFM;
    let (mut elements, mut text, mut is_code) = (Vec::new(), String::new(), false);
    for event in Parser::new_ext(page, options) {
        match event {
            Event::Text(part) if !is_code => text.push_str(&part),
            // A reference can't extend into code.
            Event::Text(_) | Event::Code(_) => text.push(' '),
            Event::InlineHtml(html) if matches!(&*html, "<code>" | "</code>") => is_code = &*html == "<code>",
            Event::Start(Tag::CodeBlock(_)) => is_code = true,
            Event::End(TagEnd::CodeBlock) => {
                is_code = false;
                elements.push("code block".to_owned());
            }
            Event::Start(Tag::Link { dest_url, .. }) => {
                let is_page = |site| dest_url.starts_with(&format!("{site}/docs/rules/"));
                assert!(site_url().is_some_and(is_page), "{dest_url}");
            }
            Event::Html(html) => assert!(html.starts_with("<!-- Generated by uavspec "), "{html}"),
            other => {
                elements.push(format!("{other:?}"));
                text.push('\n');
            }
        }
    }
    let reference =
        Regex::new(r"@\w|[#!%~&$^]\w|(?i:gh-\d|www\.)|://|\b[0-9a-f]{7,64}\b|:[0-9_+-]*[a-z][0-9a-z_+-]*:");
    let reference = reference.expect("a pattern").find(&text).map(|found| found.as_str().to_owned());
    assert_eq!(reference, None, "{text}");
    elements
}

/// Renders a report in a format. Fails if the output would cause an action in a terminal or a CI system.
fn rendered(report: &Report, kind: Kind) -> String {
    let text = report.to_text(kind);
    if kind == Kind::Text {
        // The formats escape everything themselves, so the guard changes nothing.
        let mut printed = Vec::new();
        Guard::new(&mut printed).write_all(text.as_bytes()).expect("written");
        let printed = String::from_utf8(printed).expect("UTF-8");
        assert!(printed == text, "{text}\n{printed}");
    }
    let text = if kind == Kind::Text { anstream::adapter::strip_str(&text).to_string() } else { text };
    assert!(guarded(&text) == text, "{kind:?}: {text}");
    let forged = text.lines().find(|line| line.trim_start().starts_with("FORGED"));
    assert_eq!(forged, None, "{kind:?}");
    text
}

proptest! {
    #![proptest_config(ProptestConfig { cases: extent(16, 4), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn untrusted_text_stays_text(text in prop::collection::vec(select(&FRAGMENTS[..]), 1..6).prop_map(|all| all.concat())) {
        check(&text);
    }
}

#[test]
fn each_fragment_stays_text() {
    FRAGMENTS.into_iter().step_by(extent(1, 17)).for_each(check);
}

/// Puts the text into every field, and renders the reports in every format.
fn check(text: &str) {
    // A text without visible characters would be omitted.
    let text = &format!("{text}z");
    for (report, structures) in poison::reports(text).iter().zip(expected()) {
        for (kind, expected) in KINDS.iter().copied().zip(structures) {
            let document = rendered(report, kind);
            assert!(structure(kind, &document) == *expected, "{kind:?} with {text:?}\n{document}");
        }
        let json: Value = serde_json::from_str(&report.to_text(Kind::Json)).expect("JSON");
        assert_eq!(json["command"], text.as_str(), "JSON preserves texts");
    }
    let (timeline, conversion) = (poison::timeline(text), poison::conversion(text));
    let json = [to_json(&timeline), conversion.to_json()];
    for document in &json {
        assert!(serde_json::from_str::<Value>(document).is_ok_and(|json| json["capture"] == text.as_str()));
    }
    let texts = [to_text(&timeline, "en"), to_html(&timeline, "en", text), conversion.to_text()];
    for document in texts.iter().chain(&json) {
        assert!(guarded(document) == *document, "{document}");
        let is_acted_on = |character: char| character.is_control() && character != '\n';
        assert!(!document.contains(is_acted_on), "{document}");
    }
}
