//! Tests of HTML reports in a browser: they fit desktop and phone screens, follow the colour scheme, and neither load
//! resources nor run scripts.
//!
//! `UAVSPEC_PICTURES` names the folder in which to keep the screenshots.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use uavspec_report::{Kind, Report};
use uavspec_rules::definitions::Definitions;

use crate::hostile::{checked, tested};

/// Common program names of Chromium.
const BROWSERS: [&str; 5] =
    ["chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

fn browser() -> String {
    let named = std::env::var("UAVSPEC_CHROMIUM").ok();
    let runs =
        |name: &str| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success());
    named
        .or_else(|| BROWSERS.iter().find(|name| runs(name)).map(|name| (*name).to_owned()))
        .expect("Chromium, or its path in UAVSPEC_CHROMIUM")
}

/// Renders a report in a browser, and returns the measurements for each screen size. Screenshots are stored in
/// `folder`.
fn measure(name: &str, report: &Report, folder: &Path) -> Vec<Value> {
    let page = folder.join(format!("{name}.html"));
    fs::write(&page, report.to_text(Kind::Html)).expect("a file");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/browser/look.py");
    let run = Command::new("python3").arg(script).arg(browser()).arg(&page).arg(folder).output();
    let output = run.expect("Python runs");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    let lines = String::from_utf8(output.stdout).expect("UTF-8");
    lines.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

#[test]
#[ignore = "requires Chromium and Python"]
fn reports_fit_every_screen_in_both_schemes() {
    let temporary = tempfile::tempdir().expect("a folder");
    let folder =
        std::env::var_os("UAVSPEC_PICTURES").map_or_else(|| temporary.path().to_path_buf(), Into::into);
    fs::create_dir_all(&folder).expect("a folder");
    let definitions = Definitions::built_in();
    for (name, report) in [("checked", checked(&definitions)), ("tested", tested(&definitions))] {
        let seen = measure(name, &report, &folder);
        assert_eq!(seen.len(), 4, "two widths, two schemes");
        for one in &seen {
            let reported = format!("{name}: {one}");
            assert_eq!((&one["told"], &one["requests"]), (&Value::Array(vec![]), &1.into()), "{reported}");
            for state in ["closed", "open"] {
                let measured = &one[state];
                assert_eq!(measured["window"], one["width"], "{reported}");
                assert!(measured["content"].as_u64() <= one["width"].as_u64(), "{reported}");
                assert_eq!(
                    (&measured["beyond"], &measured["scripts"]),
                    (&Value::Array(vec![]), &0.into()),
                    "{reported}"
                );
            }
            let picture = format!("{name}-{}-{}.png", one["width"], one["scheme"].as_str().expect("a name"));
            let picture = fs::read(folder.join(&picture)).expect("a picture");
            assert!(picture.starts_with(b"\x89PNG") && picture.len() > 10_000, "{} bytes", picture.len());
        }
        let colours = |scheme: &str| {
            let pages = seen.iter().filter(|one| one["scheme"] == scheme);
            pages.map(|one| one["closed"]["background"].clone()).collect::<Vec<_>>()
        };
        assert!(colours("light").iter().all(|light| !colours("dark").contains(light)), "{seen:?}");
    }
}
