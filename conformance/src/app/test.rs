//! `uavspec test`.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use globset::{Glob, GlobMatcher};
use uavspec_dynamic::Types;
use uavspec_model::net::Address;
use uavspec_model::text::command_line;
use uavspec_probe::testee::case::{Case, cases};
use uavspec_probe::testee::file::{dump, replay};
use uavspec_probe::testee::known::{case_outcomes, excuse_cases};
use uavspec_probe::testee::options::Options;
use uavspec_probe::testee::outcome::Outcome;
use uavspec_probe::testee::run::run;
use uavspec_probe::testee::target::Target;
use uavspec_report::{Action, Origin, Report, Subject};
use uavspec_schema::stage::write_file;

use super::baseline::{self, BaselineArgs};
use super::outputs::{self, Inputs, Output};
use super::progress::Progress;
use super::report::{Outputs, ReportArgs};
use super::{Exit, Status, outcome_statuses, unreadable};

const EXAMPLES: &str = "Examples:
  uavspec test -- ./my-codec --stdio
  uavspec test --filter 'decode-*/px4/Event/*' -- python3 testee.py
  uavspec test --baseline baseline.toml -- ./my-codec --stdio
  uavspec test --attach localhost:7700
  uavspec test --report html=report.html,junit=report.xml -- ./my-codec
  uavspec test --dump-cases requests.jsonl
  uavspec test --replay responses.jsonl";

const DETAILS: &str = "\
Requests and responses look like this:
  → {\"op\":\"hello\",\"protocol\":1}
  ← {\"op\":\"hello\",\"protocol\":1,\"name\":\"my-codec\",\"version\":\"1.2\",
     \"ops\":[\"decode\"],\"formats\":[\"uorb\"],\"types\":[\"px4/Event\"]}
  → {\"id\":17,\"op\":\"decode\",\"type\":\"px4/Event\",\"format\":\"uorb\",\"bytes\":\"Zg==\"}
  ← {\"id\":17,\"ok\":{…}}

Instead of \"ok\", a response can be \"rejected\":\"reason\", \"unsupported\":true or \"error\":\"reason\".

In both directions, integers outside ±2^53 are written as {\"$u64\":\"…\"} or {\"$i64\":\"…\"}, and NaN as \
{\"$f\":\"NaN\"}. \
`uavspec testee lint` checks whether a testee implements the protocol.

A baseline is a TOML file with a list of known failures. Only case and reason are required:
  [[known]]                       # use [[flaky]] if it sometimes passes
  case = \"decode-cdr/px4/Event/*\"
  message = \"/id: expected\"       # start of the message
  reason = \"big-endian CDR is not supported yet\"
  link = \"https://example.org/issues/7\"
  expires = 2027-06-30";

/// The meaning of exit status 3.
const FAILURE: &str = "the testee failed, or a report can't be written";

/// Arguments of `test`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{DETAILS}\n\n{}", outcome_statuses(FAILURE, None)))]
pub(super) struct TestArgs {
    /// Testee and its arguments.
    ///
    /// A script that starts another program should `exec` it.
    #[arg(last = true, value_name = "COMMAND", required_unless_present_any = ["attach", "dump_cases", "replay"])]
    command: Vec<OsString>,
    /// Connect to a running testee over TCP.
    ///
    /// A connection is treated like a process: a lost connection counts as a crash, and a new connection as a restart.
    #[arg(long, value_name = "HOST:PORT", conflicts_with_all = ["command", "dump_cases", "replay"])]
    attach: Option<Address>,
    /// Definitions to use [default: built-in].
    ///
    /// A uavspec.toml file, a folder that contains one, or a folder of .msg files. The cases are generated from the
    /// definitions.
    #[arg(long, value_name = "PATH")]
    definitions: Option<PathBuf>,
    /// Run only the cases that match this glob.
    ///
    /// Case names look like decode-uorb/px4/Event/typical.
    #[arg(long, value_name = "PATTERN")]
    filter: Option<String>,
    /// Maximum time without a response.
    #[arg(long, value_name = "SECONDS", default_value = "5", value_parser = seconds)]
    timeout: Duration,
    /// Maximum time to start.
    ///
    /// This includes the wait for the hello response and, with --attach, the time to connect.
    #[arg(long, value_name = "SECONDS", default_value = "30", value_parser = seconds)]
    start_timeout: Duration,
    /// Number of pending requests per process.
    #[arg(long, value_name = "N", default_value = "32", value_parser = clap::value_parser!(u16).range(1..))]
    window: u16,
    /// Stop after this many restarts in a row that no test case caused.
    ///
    /// Each process of --jobs counts its own restarts. A case that crashes the testee costs one restart. The run also ends
    /// after 100 crashes in a row.
    #[arg(long, value_name = "N", default_value = "20")]
    max_restarts: u32,
    /// Maximum number of successive timeouts.
    ///
    /// The run ends after this many timeouts without a response in between, and after three times as many in all. Each of
    /// the parallel --jobs counts its own timeouts. A case that hangs costs up to three timeouts.
    #[arg(long, value_name = "N", default_value = "3", value_parser = clap::value_parser!(u32).range(1..))]
    max_timeouts: u32,
    /// Number of parallel processes.
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u16).range(1..=256))]
    jobs: u16,
    #[command(flatten)]
    report: ReportArgs,
    /// Write all requests to a file, and exit.
    ///
    /// Each request includes its expected responses. The path `-` means standard output.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["command", "replay"])]
    dump_cases: Option<PathBuf>,
    /// Check responses that were written to a file, instead of running a testee.
    ///
    /// The path `-` means standard input. --dump-cases writes the requests.
    #[arg(long, value_name = "FILE", conflicts_with = "command")]
    replay: Option<PathBuf>,
    #[command(flatten)]
    baseline: BaselineArgs,
}

/// Parses a time in seconds.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    let duration = Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())?;
    // Adding a long time to an `Instant` may cause an overflow.
    let is_sensible = !duration.is_zero() && duration <= Duration::from_secs(86_400);
    is_sensible
        .then_some(duration)
        .ok_or_else(|| "expected a number greater than 0 and at most 86400".to_owned())
}

/// The testee to use. clap ensures that one of the arguments is present.
pub(super) fn target(command: &[OsString], attach: Option<&Address>) -> Target {
    attach.map_or_else(|| Target::Command(command.to_vec()), |address| Target::Address(address.clone()))
}

pub(super) fn test(args: &TestArgs) -> Exit {
    if let Some(problem) = args.report.problem() {
        return Err(Status::Usage.because(problem));
    }
    let mut outputs = start_reports(args)?;
    let definitions = super::definitions(args.definitions.as_deref())?;
    let types = definitions.types();
    let cases = cases(&definitions, types);
    let selected = select(&cases, args.filter.as_deref()).map_err(|error| Status::Usage.because(error))?;
    if let Some(path) = &args.dump_cases {
        write_cases(path, &cases, &selected, types).map_err(|error| unreadable(path, error))?;
        return Ok(Status::Conforms);
    }
    let mut baselines = baseline::read(&args.baseline)?;
    let mut outcome = match &args.replay {
        Some(path) => {
            read_answers(path, &cases, &selected, types).map_err(|error| unreadable(path, error))?
        }
        None => run_cases(args, &cases, &selected, types)
            .map_err(|error| Status::Unreadable.with_details(error))?,
    };
    let names: Vec<(&Case, String)> = cases.iter().map(|case| (case, case.name())).collect();
    let is_outdated = baselines.compare(&|rule| rule.is_none(), |lists, sums| {
        for (name, outcome) in case_outcomes(&names, &outcome) {
            lists.count(sums, &name, &outcome);
        }
    });
    excuse_cases(&mut baselines.lists, &mut outcome);
    let baseline_status = baseline::write(&baselines, is_outdated);
    let subject = Subject::from_testee(&outcome, &definitions, &|case| rerun_command(args, case));
    outputs.add(&subject, &Origin::default(), None);
    let (totals, command) = (outputs.finish(), super::command());
    let report = Report::of_totals(Action::Test, command, &definitions.name, totals, Vec::new(), Vec::new());
    Ok(outputs.deliver(&report.with_stale(baseline::reasons(&baselines))).max(baseline_status))
}

/// Starts the reports, and checks that no output replaces an input. Prints errors.
fn start_reports(args: &TestArgs) -> Result<Outputs<'_>, Status> {
    let cases = args.dump_cases.iter().map(|path| Output::new("--dump-cases", path));
    let outputs: Vec<Output<'_>> =
        cases.chain(args.report.outputs()).chain(baseline::outputs(&args.baseline)).collect();
    // The words of the command may name the program and the files of the testee.
    let words = args.command.iter().map(Path::new).filter(|path| path.is_file());
    let inputs = Inputs {
        files: args.replay.as_deref().into_iter().chain(args.baseline.inputs()).chain(words).collect(),
        definitions: args.definitions.as_deref().into_iter().collect(),
        ..Inputs::default()
    };
    outputs::check(&inputs, &outputs)?;
    args.report.start(Action::Test, false)
}

/// The command that runs one case.
fn rerun_command(args: &TestArgs, case: &str) -> String {
    let filter = globset::escape(case);
    let mut words = vec!["uavspec".to_owned(), "test".to_owned(), "--filter".to_owned(), filter];
    let mut add = |name: &str, value: String| words.extend([name.to_owned(), value]);
    if let Some(path) = &args.definitions {
        add("--definitions", path.to_string_lossy().into_owned());
    }
    if let Some(path) = &args.replay {
        add("--replay", path.to_string_lossy().into_owned());
        return command_line(words.iter().map(String::as_str));
    }
    let defaults = Options::new(target(&args.command, args.attach.as_ref()));
    let limits = [
        ("--timeout", args.timeout, defaults.timeout),
        ("--start-timeout", args.start_timeout, defaults.start_timeout),
    ];
    for (name, limit, _) in limits.iter().filter(|(_, limit, default)| limit != default) {
        add(name, limit.as_secs_f64().to_string());
    }
    if usize::from(args.window) != defaults.window {
        add("--window", args.window.to_string());
    }
    if let Some(address) = &args.attach {
        add("--attach", address.to_string());
    } else {
        words.push("--".to_owned());
        words.extend(args.command.iter().map(|word| word.to_string_lossy().into_owned()));
    }
    command_line(words.iter().map(String::as_str))
}

/// The indices of the cases that match a pattern. Fails if there are none.
fn select(cases: &[Case], pattern: Option<&str>) -> Result<Vec<usize>, String> {
    let Some(pattern) = pattern else { return Ok((0..cases.len()).collect()) };
    let glob: GlobMatcher = Glob::new(pattern).map_err(|error| error.to_string())?.compile_matcher();
    let found = cases.iter().enumerate().filter(|(_, case)| glob.is_match(case.name())).map(|(id, _)| id);
    let found: Vec<usize> = found.collect();
    if found.is_empty() { Err(format!("no case matches {pattern}")) } else { Ok(found) }
}

fn run_cases<'c>(
    args: &TestArgs,
    cases: &'c [Case],
    selected: &[usize],
    types: &Types,
) -> Result<Outcome<'c>, String> {
    let options = Options {
        window: args.window.into(),
        timeout: args.timeout,
        start_timeout: args.start_timeout,
        jobs: args.jobs.into(),
        max_restarts: args.max_restarts,
        max_timeouts: args.max_timeouts,
        ..Options::new(target(&args.command, args.attach.as_ref()))
    };
    let progress = Progress::steps("cases");
    run(cases, selected, types, &options, &|done, total| progress.set(done, total))
}

fn write_cases(path: &Path, cases: &[Case], selected: &[usize], types: &Types) -> io::Result<()> {
    if path == Path::new("-") {
        let mut stdout = BufWriter::new(io::stdout().lock());
        return match dump(cases, selected, types, &mut stdout).and_then(|()| stdout.flush()) {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
            other => other,
        };
    }
    write_file(path, |file| dump(cases, selected, types, file))
}

fn read_answers<'c>(
    path: &Path,
    cases: &'c [Case],
    selected: &[usize],
    types: &Types,
) -> io::Result<Outcome<'c>> {
    if path == Path::new("-") {
        return replay(cases, selected, types, &mut io::stdin().lock());
    }
    replay(cases, selected, types, &mut BufReader::new(File::open(path)?))
}
