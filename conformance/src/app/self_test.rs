//! `uavspec self-test`.

use std::ffi::OsString;
use std::io;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Duration;

use anstyle::{AnsiColor, Style};
use clap::Args;
use uavspec_check::parallel;
use uavspec_live::bus::Address;
use uavspec_model::text::{terminal, thousands};
use uavspec_probe::self_test::live::{cases as server_cases, live};
use uavspec_probe::self_test::vehicle::{self, check_bus, pairs};
use uavspec_probe::self_test::{Found, Row, conforming, list, matrix};
use uavspec_probe::testee::case::cases;
use uavspec_probe::testee::options::Options;
use uavspec_probe::testee::run::run;
use uavspec_probe::testee::target::Target;
use uavspec_rules::RULES;
use uavspec_rules::definitions::Definitions;

use super::progress::Progress;
use super::{Exit, Status};

const FAIL: Style = AnsiColor::Red.on_default().bold();
const PASS: Style = AnsiColor::Green.on_default().bold();
const PLAIN: Style = Style::new();

/// The time limit for a response of the testee. It is sufficient even on a busy computer.
const TIMEOUT: Duration = Duration::from_secs(60);

/// The time limit for the start of the testee. The command may build it first.
const START_TIMEOUT: Duration = Duration::from_secs(600);

const EXAMPLES: &str = "Examples:
  uavspec self-test
  uavspec self-test --definitions ../px4_msgs/msg
  uavspec self-test --recordings-only
  uavspec self-test --px4
  uavspec self-test --px4 dds://77 dds://78
  uavspec self-test -- ./reference-codec";

const STATUS: &str = "Exit status:
  0  all checks passed
  1  at least one check or case failed
  2  invalid usage, or unreadable definitions
  3  the testee can't be started or keeps failing, or a bus can't be used";

/// Arguments of `self-test`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{STATUS}"))]
pub(super) struct SelfTestArgs {
    /// Definitions to use [default: built-in].
    ///
    /// A uavspec.toml file, a folder that contains one, or a folder of .msg files. The captures are generated from the
    /// definitions.
    #[arg(long, value_name = "PATH")]
    definitions: Option<PathBuf>,
    /// Check captures only; start no servers.
    #[arg(long)]
    recordings_only: bool,
    /// Probe only the PX4 references: within the process, or over the buses at these URLs.
    ///
    /// The URLs are the same as for `uavspec probe`, such as `dds://0`. Each bus is used by one pair of participants at a
    /// time, so more buses shorten the test. In a DDS domain, the participants communicate on this computer only. Don't use
    /// the bus of a real vehicle.
    #[arg(
        long,
        value_name = "URL",
        num_args = 0..,
        conflicts_with_all = ["definitions", "recordings_only", "testee"]
    )]
    px4: Option<Vec<Address>>,
    /// Testee (with arguments) that must pass all cases.
    #[arg(last = true, value_name = "COMMAND")]
    testee: Vec<OsString>,
}

pub(super) fn self_test(args: &SelfTestArgs) -> Exit {
    let is_right = args.px4.as_ref().map_or_else(|| test_all(args), |buses| test_vehicles(buses))?;
    let (style, text) = if is_right { (PASS, "all checks passed") } else { (FAIL, "some checks failed") };
    terminal::println!("\n{style}{text}{style:#}");
    Ok(if is_right { Status::Conforms } else { Status::DoesNotConform })
}

/// Tests the PX4 references over buses, or within the process if there are none.
fn test_vehicles(given: &[Address]) -> Result<bool, Status> {
    let mut buses: Vec<Address> = Vec::new();
    for address in given {
        // Two pairs of participants on the same bus would affect each other.
        if !buses.contains(address) {
            buses.push(address.clone());
        }
    }
    let mut problem = None;
    let jobs = NonZeroUsize::new(buses.len());
    parallel::each(&buses, jobs, check_bus, |address, checked| {
        problem = problem.take().or_else(|| Some(format!("{address}: {}", checked.err()?)));
    });
    problem.map_or_else(|| Ok(vehicles(&buses)), |problem| Err(Status::Unreadable.because(problem)))
}

/// Tests the checks, the references and the testee.
fn test_all(args: &SelfTestArgs) -> Result<bool, Status> {
    let definitions = super::definitions(args.definitions.as_deref())?;
    let mut is_right = recordings(&definitions) & rules(&matrix(&definitions));
    if !args.recordings_only {
        is_right &= servers(&definitions);
        terminal::println!("");
        is_right &= vehicles(&[]);
    }
    if !args.testee.is_empty() {
        let tested = run_cases(&definitions, &args.testee);
        is_right &= tested.map_err(|error| Status::Unreadable.because(error))?;
    }
    Ok(is_right)
}

/// Checks conforming captures. Returns true if there are no findings.
fn recordings(definitions: &Definitions) -> bool {
    let mut is_right = true;
    terminal::println!("Captures that conform to the definitions:");
    for (name, result) in conforming(definitions) {
        let covered = RULES.iter().filter(|rule| result.findings.covered(rule) > 0).count();
        let violated: Vec<&str> = result.findings.groups().map(|group| group.rule.id).collect();
        let is_clean = violated.is_empty() && result.corruption.is_empty();
        is_right &= is_clean;
        let records = thousands(result.records);
        let found =
            if is_clean { "no findings".to_owned() } else { format!("found {}", violated.join(", ")) };
        line(is_clean, name, &format!("{records} messages, {covered} rules covered, {found}"));
    }
    is_right
}

/// Checks that each mutant violates exactly the expected rules. Returns true if so.
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

/// Probes the reference server without bugs, and with each bug. Returns true if the probes find exactly the bugs.
fn servers(definitions: &Definitions) -> bool {
    let cases = server_cases();
    let rows = rows("servers", cases.len(), |take| live(&cases, definitions, take));
    terminal::println!(
        "\nProbes of the reference server, first without bugs, then with each bug; checked live and from captures:"
    );
    let results = cases.iter().zip(rows).map(|(case, row)| {
        let name = case.bug.map_or_else(|| case.name(), |bug| bug.rule.id.to_owned());
        let has_bug = case.bug.is_some();
        let result = row.map(|row| {
            if row.is_right() { Ok(found_text(has_bug, &row.found)) } else { Err(row.mismatch_text()) }
        });
        (name, result)
    });
    print_probes(results)
}

/// Probes the PX4 references without bugs, and with each bug. Returns true if the probes find exactly the bugs. Bugs
/// that a bus can't show are skipped.
fn vehicles(buses: &[Address]) -> bool {
    let cases = vehicle::cases();
    let (shown, skipped): (Vec<_>, Vec<_>) =
        cases.into_iter().partition(|case| case.missing(buses).is_none());
    let rows = rows("pairs", shown.len(), |take| pairs(&shown, buses, take));
    terminal::println!(
        "Probes of the PX4 references, first without bugs, then with each bug; checked live and from captures:"
    );
    let results = shown.iter().zip(rows).map(|(case, row)| {
        let has_bug = case.bug.is_some();
        let result = row.map(|row| {
            if row.is_right() { Ok(found_text(has_bug, &row.found)) } else { Err(row.mismatch_text()) }
        });
        (case.name().to_owned(), result)
    });
    let are_right = print_probes(results);
    for case in &skipped {
        let missing = case.missing(buses).unwrap_or_default();
        terminal::println!("  skip  {:<12} the bug requires {missing}", case.name());
    }
    are_right
}

/// Runs probes with a progress bar, and collects their results. `run` passes each result to the function that it
/// receives.
fn rows<R>(noun: &'static str, count: usize, run: impl FnOnce(&mut dyn FnMut(R))) -> Vec<R> {
    let (progress, mut rows) = (Progress::steps(noun), Vec::new());
    progress.set(0, count);
    run(&mut |row| {
        rows.push(row);
        progress.set(rows.len(), count);
    });
    rows
}

/// Prints the result of each probe. Returns true if all results are as expected.
fn print_probes(results: impl Iterator<Item = (String, io::Result<Result<String, String>>)>) -> bool {
    let mut are_right = true;
    for (name, result) in results {
        let result = result.unwrap_or_else(|error| Err(error.to_string()));
        are_right &= result.is_ok();
        let (Ok(text) | Err(text)) = &result;
        line(result.is_ok(), &name, text);
    }
    are_right
}

/// Describes a probe whose result is as expected.
fn found_text(has_bug: bool, found: &Found) -> String {
    if has_bug { "found".to_owned() } else { format!("{} rules covered, no findings", found.covered.len()) }
}

/// Runs all cases with the testee. Returns true if it passes all of them.
fn run_cases(definitions: &Definitions, testee: &[OsString]) -> Result<bool, String> {
    let cases = cases(definitions, definitions.types());
    let all: Vec<usize> = (0..cases.len()).collect();
    let progress = Progress::steps("cases");
    let options = Options {
        timeout: TIMEOUT,
        start_timeout: START_TIMEOUT,
        ..Options::new(Target::Command(testee.to_vec()))
    };
    let on_progress = |done, total| progress.set(done, total);
    let outcome = run(&cases, &all, definitions.types(), &options, &on_progress)?;
    drop(progress);
    terminal::println!("\nThe testee:");
    let counts = outcome.counts();
    let is_right = counts.passed == cases.len() as u64 && outcome.protocol_remarks.is_empty();
    let name = outcome.hello.map_or_else(|| "testee".to_owned(), |hello| hello.name);
    let passed = thousands(counts.passed);
    line(is_right, &name, &format!("{passed} of {} cases passed", thousands(cases.len() as u64)));
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
