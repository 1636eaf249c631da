//! Tests of pages and of timelines as text.

use data_encoding::BASE64;
use serde_json::json;
use sha2::{Digest as _, Sha256};
use uavspec_check::check_bytes;
use uavspec_check::timeline::Texts;
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::sample::story;
use uavspec_schema::translation::Translations;

use super::*;
use crate::html::tests::compare_with_site;
use crate::timeline::{to_json, to_text};

const HOSTILE: &str = "</script><script>alert(1)</script>\u{1b}[31m\u{202e}\n::error::x";

fn timeline(bytes: &[u8]) -> Timeline {
    let (definitions, translations) = (Definitions::built_in(), Translations::default());
    Timeline::of_bytes(bytes, &definitions, &Texts::of(translations)).expect("a readable capture")
}

/// A session with hostile text in each text that a timeline shows.
fn hostile() -> Timeline {
    let status = json!({ HOSTILE: { "errors": [66, 999_999], "mode": HOSTILE } });
    let message = json!({ "$fw.version": "1.0", "id": "a", "body": { "type": "UAV-INF", "status": status } });
    let lines = [
        json!({ "t": 1.8e9, "conn": HOSTILE, "dir": "event", "event": HOSTILE }),
        json!({ "t": 1.8e9 + 1.0, "conn": HOSTILE, "dir": "in", "msg": message }),
    ];
    let mut timeline = timeline(lines.map(|line| format!("{line}\n")).concat().as_bytes());
    HOSTILE.clone_into(&mut timeline.capture);
    HOSTILE.clone_into(&mut timeline.definitions);
    timeline
}

#[test]
fn hostile_text_is_escaped() {
    let timeline = hostile();
    let page = to_html(&timeline, "en", HOSTILE);
    assert_eq!(page.matches("<script").count(), 1, "only the script of the page");
    assert!(page.contains("&lt;/script&gt;"));
    let text = to_text(&timeline, "en");
    assert!(text.contains("alert(1)"), "{text}");
    for rendered in [page, text] {
        assert!(!rendered.contains(['\u{1b}', '\u{202e}']), "{rendered}");
        assert!(!rendered.lines().any(|line| line.trim_start().starts_with("::error::")), "{rendered}");
    }
}

#[test]
fn the_policy_permits_the_script_of_the_page() {
    let page = to_html(&hostile(), "en", "uavspec");
    let script =
        page.split("<script>").nth(1).and_then(|rest| rest.split("</script>").next()).expect("a script");
    let hash = format!("'sha256-{}'", BASE64.encode(&Sha256::digest(script.as_bytes())));
    assert!(page.contains(&format!("script-src {hash};")), "the policy must contain {hash}");
    assert!(page.contains("default-src 'none';"));
    // The script and the style sheet load nothing.
    for word in ["http:", "fetch(", "XMLHttpRequest", "import(", "url(", "@import", "innerHTML", "eval("] {
        assert!(![STYLE, SCRIPT].iter().any(|text| text.contains(word)), "{word}");
    }
}

#[test]
fn the_page_is_valid_and_contains_all_languages() {
    let page = to_html(&hostile(), "uk", "uavspec");
    let errors: Vec<String> = html5gum::Tokenizer::new(&page.replace(SCRIPT, ""))
        .filter_map(|token| match token {
            Ok(html5gum::Token::Error(error)) => Some(format!("{error:?}")),
            _ => None,
        })
        .collect();
    assert_eq!(errors, Vec::<String>::new());
    assert!(page.contains("<html lang=\"en\" data-language=\"uk\">"));
    for tag in ["en", "uk"] {
        assert!(page.contains(&format!("<span data-label=\"{tag}\" lang=\"{tag}\">")), "{tag}");
        assert!(
            page.contains(&format!("[data-language=\"{tag}\"] [data-label]:not([data-label=\"{tag}\"])"))
        );
    }
}

#[test]
fn the_table_has_a_row_for_each_change() {
    let timeline = hostile();
    let page = to_html(&timeline, "en", "uavspec");
    let table = page.split("<table class=\"changes\">").nth(1).and_then(|rest| rest.split("</table>").next());
    let rows = table.expect("a table").matches("<tr>").count() - 1;
    assert_eq!(rows as u64, totals(&timeline).0);
    assert!(rows >= 4, "{rows}");
}

#[test]
fn text_fits_into_80_columns_and_has_the_language() {
    let status = |errors: &[u32]| json!({ "7": { "errors": errors } });
    let line = |time: f64, errors: &[u32]| {
        let body = json!({ "type": "UAV-INF", "status": status(errors) });
        let message = json!({ "$fw.version": "1.0", "id": "a", "body": body });
        format!("{}\n", json!({ "t": time, "conn": "tcp#1", "dir": "in", "msg": message }))
    };
    let timeline = timeline(
        [line(1.8e9, &[]), line(1.8e9 + 1.5, &[1, 4, 66]), line(1.8e9 + 3.0, &[1])].concat().as_bytes(),
    );
    let text = to_text(&timeline, "en");
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    assert!(text.contains("08:00:01.500  UAV-INF.1 GROUND (7) set – The UAV is on the ground\n"), "{text}");
    assert!(text.contains("00:01.500  UAV-INF.66 LOWBAT (7), 2 changes\n"), "{text}");
    assert!(to_text(&timeline, "uk").contains("UAV-INF.1 GROUND (7) set – БПЛА на землі\n"));
    assert!(to_json(&timeline).contains("\"БПЛА на землі\""));
}

#[test]
fn times_have_minutes_and_milliseconds() {
    use crate::timeline::clock;
    for (time, text) in
        [(0, "00:00.000"), (61_234_567, "01:01.234"), (-1_500_000, "-00:01.500"), (-5, "00:00.000")]
    {
        assert_eq!(clock(time), text);
    }
    assert_eq!(duration(6_000_000_000), "100:00.000");
}

#[test]
fn the_timeline_on_the_documentation_site_is_up_to_date() {
    let [story::File { name, content: log, .. }, ..] = story::files().expect("the sample");
    let definitions = check_bytes(&log, &Library::built_in()).expect("a log").definitions;
    let timeline = Timeline::of_bytes(&log, &definitions, &Texts::of(Translations::default()));
    let mut timeline = timeline.expect("a timeline");
    name.clone_into(&mut timeline.capture);
    let command = format!("uavspec explain {name} --report html=flight.html");
    compare_with_site("flight.html", &to_html(&timeline, "en", &command));
}
