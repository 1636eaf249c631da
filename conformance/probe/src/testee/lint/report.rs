//! Reports of lint results, as text and as JSON.

use std::fmt::{self, Write as _};

use anstyle::{AnsiColor, Style};
use serde_json::{Value, json};
use uavspec_model::text::shown;
use uavspec_schema::json_text;

use super::{CheckOutcome, LintResult};

/// The version of the JSON form. The version increases if a member is removed or changes its meaning.
const VERSION: u32 = 1;

const FAIL: Style = AnsiColor::Red.on_default().bold();
const PASS: Style = AnsiColor::Green.on_default().bold();
const DIMMED: Style = Style::new().dimmed();

/// The result as text, with colours. The output stream removes the colours if necessary.
pub fn to_text(found: &LintResult) -> String {
    let mut text = String::new();
    // Writing to a string can't fail.
    let _ = write_text(found, &mut text);
    text
}

fn write_text(found: &LintResult, text: &mut String) -> fmt::Result {
    if let Some(hello) = &found.hello {
        writeln!(text, "{}\n", shown(&hello.to_string()))?;
    }
    for (check, outcome) in &found.outcomes {
        let (style, word) = match outcome {
            CheckOutcome::Pass => (PASS, "pass"),
            CheckOutcome::Fail(_) => (FAIL, "fail"),
            CheckOutcome::NotApplicable(_) => (DIMMED, "n/a"),
        };
        writeln!(text, "{style}{word:<4}{style:#}  {:<24} {}", check.id, check.statement)?;
        for (index, line) in outcome.message().unwrap_or_default().lines().enumerate() {
            let mark = if index == 0 { "" } else { "| " };
            writeln!(text, "      {mark}{}", shown(line))?;
        }
        if matches!(outcome, CheckOutcome::Fail(_)) {
            writeln!(text, "      help: {}", check.help)?;
        }
    }
    let count = |name: &str| found.outcomes.iter().filter(|(_, outcome)| outcome.name() == name).count();
    let (passed, failed, other) = (count("pass"), count("fail"), count("not applicable"));
    writeln!(text, "\n{passed} passed, {failed} failed, {other} not applicable")?;
    if found.is_ok() {
        writeln!(text, "{PASS}follows the protocol{PASS:#}")
    } else {
        writeln!(text, "{FAIL}violates the protocol{FAIL:#}")
    }
}

/// The result as JSON.
pub fn to_json(found: &LintResult) -> String {
    let checks = found.outcomes.iter().map(|(check, outcome)| {
        json!({
            "id": check.id, "statement": check.statement, "verdict": outcome.name(),
            "message": outcome.message(), "help": check.help,
        })
    });
    let report = json!({
        "version": VERSION,
        "testee": found.hello.as_ref().map(|hello| json!({ "name": hello.name, "version": hello.version })),
        "checks": checks.collect::<Vec<Value>>(),
    });
    json_text::pretty(&report)
}
