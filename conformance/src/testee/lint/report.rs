//! What came of trying manners, for people and for programs.

use std::fmt::{self, Write as _};

use anstyle::{AnsiColor, Style};
use serde_json::{Value, json};

use super::{CheckOutcome, Found};

/// The version of the JSON form; it rises when a member changes its meaning or goes.
const VERSION: u32 = 1;

const FAIL: Style = AnsiColor::Red.on_default().bold();
const PASS: Style = AnsiColor::Green.on_default().bold();
const DIMMED: Style = Style::new().dimmed();

/// For people, with colours; a stream that knows drops them where they would not be shown.
pub(crate) fn to_text(found: &Found) -> String {
    let mut text = String::new();
    // Writing to a string can't fail.
    let _ = write_text(found, &mut text);
    text
}

fn write_text(found: &Found, text: &mut String) -> fmt::Result {
    if let Some(hello) = &found.hello {
        writeln!(text, "{hello}\n")?;
    }
    for (check, manner) in &found.outcomes {
        let (style, word) = match manner {
            CheckOutcome::Good => (PASS, "pass"),
            CheckOutcome::Bad(_) => (FAIL, "FAIL"),
            CheckOutcome::NotApplicable(_) => (DIMMED, "n/a"),
        };
        writeln!(text, "{style}{word:<4}{style:#}  {:<24} {}", check.id, check.statement)?;
        for (index, line) in manner.message().unwrap_or_default().lines().enumerate() {
            let mark = if index == 0 { "" } else { "| " };
            writeln!(text, "      {mark}{}", shown(line))?;
        }
        if matches!(manner, CheckOutcome::Bad(_)) {
            writeln!(text, "      help: {}", check.help)?;
        }
    }
    let count = |name: &str| found.outcomes.iter().filter(|(_, manner)| manner.name() == name).count();
    let (passed, failed, other) = (count("pass"), count("fail"), count("not applicable"));
    writeln!(text, "\n{passed} passed, {failed} failed, {other} not applicable")?;
    if found.are_good() {
        writeln!(text, "{PASS}keeps to the protocol{PASS:#}")
    } else {
        writeln!(text, "{FAIL}breaks the protocol{FAIL:#}")
    }
}

/// A line that may hold what a testee said, so without anything that a terminal would act upon.
fn shown(line: &str) -> String {
    let escape = |it: char| if it.is_control() { it.escape_debug().to_string() } else { it.to_string() };
    line.chars().map(escape).collect()
}

/// For programs.
pub(crate) fn to_json(found: &Found) -> String {
    let checks = found.outcomes.iter().map(|(check, manner)| {
        json!({
            "id": check.id, "statement": check.statement, "verdict": manner.name(),
            "message": manner.message(), "help": check.help,
        })
    });
    let report = json!({
        "version": VERSION,
        "testee": found.hello.as_ref().map(|hello| json!({ "name": hello.name, "version": hello.version })),
        "checks": checks.collect::<Vec<Value>>(),
    });
    // Values of this kind can always be written.
    serde_json::to_string_pretty(&report).map_or_else(|_| String::new(), |text| text + "\n")
}
