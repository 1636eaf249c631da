//! `uavspec self-test`.

use std::ffi::OsString;
use std::path::PathBuf;

use anstyle::{AnsiColor, Style};
use clap::Args;

use super::Status;
use super::progress::Progress;
use crate::definitions::Definitions;
use crate::matrix::live::{cases as server_cases, live};
use crate::matrix::{Row, conforming, list, matrix};
use crate::rules::RULES;
use crate::testee::case::cases;
use crate::testee::options::Options;
use crate::testee::run::run;
use crate::testee::target::Target;
use crate::text::{Grouped, terminal};

const FAIL: Style = AnsiColor::Red.on_default().bold();
const PASS: Style = AnsiColor::Green.on_default().bold();
const PLAIN: Style = Style::new();

const EXAMPLES: &str = "Examples:
  uavspec self-test
  uavspec self-test --definitions ../px4_msgs/msg
  uavspec self-test --recordings-only
  uavspec self-test -- ./reference-codec";

const STATUS: &str = "Exit status:
  0  all checks passed
  1  at least one check or case failed
  2  invalid usage, or unreadable definitions
  3  the testee can't be started or keeps failing";

/// Arguments of `self-test`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{STATUS}"))]
pub(super) struct SelfTestArgs {
    /// Definitions to use (default: built-in).
    ///
    /// A uavspec.toml file, a folder that contains one, or a folder of .msg files. The captures are generated from the
    /// definitions.
    #[arg(long, value_name = "PATH")]
    definitions: Option<PathBuf>,
    /// Check captures only; start no servers.
    #[arg(long)]
    recordings_only: bool,
    /// Testee (with arguments) that must pass all cases.
    #[arg(last = true, value_name = "COMMAND")]
    testee: Vec<OsString>,
}

pub(super) fn self_test(args: &SelfTestArgs) -> Status {
    let definitions = match super::definitions(args.definitions.as_deref()) {
        Ok(definitions) => definitions,
        Err(status) => return status,
    };
    let mut is_right = recordings(&definitions) & rules(&matrix(&definitions));
    if !args.recordings_only {
        is_right &= servers(&definitions);
    }
    if !args.testee.is_empty() {
        match run_cases(&definitions, &args.testee) {
            Ok(is_passing) => is_right &= is_passing,
            Err(error) => {
                terminal::error(error, None);
                return Status::Unreadable;
            }
        }
    }
    let (style, text) = if is_right { (PASS, "all checks passed") } else { (FAIL, "some checks failed") };
    terminal::println!("\n{style}{text}{style:#}");
    if is_right { Status::Conforms } else { Status::DoesNotConform }
}

/// Checks conforming captures. There must be no findings.
fn recordings(definitions: &Definitions) -> bool {
    let mut is_right = true;
    terminal::println!("Captures that conform to the definitions:");
    for (name, result) in conforming(definitions) {
        let covered = RULES.iter().filter(|rule| result.findings.covered(rule) > 0).count();
        let violated: Vec<&str> = result.findings.groups().map(|group| group.rule.id).collect();
        let is_clean = violated.is_empty() && result.corruption.is_empty();
        is_right &= is_clean;
        let records = Grouped(result.records);
        let found =
            if is_clean { "no findings".to_owned() } else { format!("found {}", violated.join(", ")) };
        line(is_clean, name, &format!("{records} messages, {covered} rules covered, {found}"));
    }
    is_right
}

/// Checks that each mutant violates exactly the expected rules.
fn rules(rows: &[Row]) -> bool {
    terminal::println!("\nMutants found by each rule:");
    for rule in RULES {
        let own = || rows.iter().filter(|row| row.rule.id == rule.id);
        let made = own().filter(|row| row.violated.is_some()).count();
        let wrong: Vec<String> = own().filter(|row| !row.is_right()).map(mismatch_text).collect();
        let text = match (made, wrong.is_empty()) {
            (0, _) => "no mutants: the rule applies to nothing in the definitions".to_owned(),
            (_, true) => format!("{made} of {made} found"),
            (_, false) => wrong.join("; "),
        };
        line(wrong.is_empty(), rule.id, &text);
    }
    rows.iter().all(Row::is_right)
}

/// Probes the reference server without bugs and with each bug. The probe must find the bug and nothing else.
fn servers(definitions: &Definitions) -> bool {
    let cases = server_cases();
    let progress = Progress::steps("servers");
    let mut rows = Vec::new();
    live(&cases, definitions, |row| {
        rows.push(row);
        progress.set(rows.len(), cases.len());
    });
    drop(progress);
    terminal::println!(
        "\nProbes of the reference server, first without bugs, then with each bug; checked live and from recordings:"
    );
    let mut are_right = true;
    for (case, row) in cases.iter().zip(rows) {
        let name = case.bug.map_or_else(|| case.name(), |bug| bug.rule.id.to_owned());
        let (is_right, text) = match row {
            Ok(row) if row.is_right() && case.bug.is_some() => (true, "found".to_owned()),
            Ok(row) if row.is_right() => (true, format!("{} rules covered, no findings", row.covered.len())),
            Ok(row) => (false, row.mismatch_text()),
            Err(error) => (false, error.to_string()),
        };
        are_right &= is_right;
        line(is_right, &name, &text);
    }
    are_right
}

/// Runs all cases with the testee, which must pass them all.
fn run_cases(definitions: &Definitions, testee: &[OsString]) -> Result<bool, String> {
    let cases = cases(definitions, definitions.types());
    let all: Vec<usize> = (0..cases.len()).collect();
    let progress = Progress::steps("cases");
    let options = Options::new(Target::Command(testee.to_vec()));
    let on_progress = |done, total| progress.set(done, total);
    let outcome = run(&cases, &all, definitions.types(), &options, &on_progress)?;
    drop(progress);
    terminal::println!("\nThe testee:");
    let counts = outcome.counts();
    let is_right = counts.passed == cases.len() && outcome.protocol_remarks.is_empty();
    let name = outcome.hello.map_or_else(|| "testee".to_owned(), |hello| hello.name);
    let passed = Grouped(counts.passed as u64);
    line(is_right, &name, &format!("{passed} of {} cases passed", Grouped(cases.len() as u64)));
    Ok(is_right)
}

fn mismatch_text(row: &Row) -> String {
    let found = list(row.violated.iter().flatten());
    format!("{}: expected {}, found {found}", row.title, list(&row.expected()))
}

fn line(is_right: bool, name: &str, text: &str) {
    let (style, word) = if is_right { (PLAIN, "  ok  ") } else { (FAIL, "  FAIL") };
    terminal::println!("{style}{word}{style:#}  {name:<12} {text}");
}
