//! The command line of `uavspec`.
//!
//! Exit status: 0 conforms; 1 doesn't; 2 wrong usage, or definitions that can't be read; 3 a source that can't be
//! read, a report that can't be written, or a testee that broke; 5 nothing was checked.

mod report;
mod rules;
mod test;

use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::{Args, Parser, Subcommand};
use uavspec_codegen::schema::MessageId;

use self::report::ReportArgs;
use crate::definitions::Definitions;
use crate::input;
use crate::judge;
use crate::parallel;
use crate::report::{
    Action, Judged, Kind, Outcome, Report, Settings, Subject, Unreadable, command_line, subject_text,
};
use crate::rule::rule;

/// Judges outputs of drone software by the specification.
#[derive(Debug, Parser)]
#[command(name = "uavspec", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Judge logs and messages that others wrote.
    Check(CheckArgs),
    /// Ask a codec or validator in any language, as a child process.
    Test(test::TestArgs),
    /// List the rules, or tell all of one.
    Rules(rules::RulesArgs),
}

/// Arguments of `check`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  uavspec check flight.ulg
  uavspec check --definitions ../px4_msgs/msg logs/*.ulg
  uavspec check --format json flight.ulg > report.json
  uavspec check --report html=report.html,junit=report.xml flight.ulg
  uavspec check rosbridge.jsonl
  zcat flight.ulg.gz | uavspec check - archive/
  uavspec check --type px4/FailsafeFlags flags.jsonl

JSON is an object a line, or an array of objects. Without --type each says what it is:
  {\"type\": \"px4/FailsafeFlags\", \"message\": {…}}
  {\"op\": \"publish\", \"topic\": \"/fmu/out/failsafe_flags\", \"msg\": {…}}   (rosbridge)

Exit status: 0 conforms, 1 does not, 2 wrong usage or definitions, 3 a file can't be read or a report
can't be written, 5 nothing was checked.")]
struct CheckArgs {
    /// Logs of PX4 in the format `ULog`, or messages as JSON or JSON Lines, also packed with gzip or zstd; which,
    /// is seen by the content. Folders are searched; `-` is standard input.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// What to judge by: a uavspec.toml, a folder with one, or a folder of .msg files; those of this program,
    /// where nothing is said.
    #[arg(long, value_name = "PATH")]
    definitions: Option<PathBuf>,
    /// The type of all messages as JSON, which then have nothing around them.
    #[arg(long = "type", value_name = "PACKAGE/NAME")]
    of: Option<String>,
    /// Let formats that differ from the definitions count as breaches (PX-FMT-01).
    #[arg(long)]
    strict_formats: bool,
    /// Rules that have to be exercised: that nothing was there to judge is a breach, too.
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    require: Vec<String>,
    /// How many files are read at the same time; as many as there are processors, where nothing is said.
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    #[command(flatten)]
    report: ReportArgs,
}

/// What a run ends with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Status {
    Conforms = 0,
    Breaks = 1,
    Usage = 2,
    Unreadable = 3,
    Stale = 4,
    Nothing = 5,
}

impl From<Outcome> for Status {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Conforms => Self::Conforms,
            Outcome::Breaks => Self::Breaks,
            Outcome::Broken => Self::Unreadable,
            Outcome::Stale => Self::Stale,
            Outcome::Nothing => Self::Nothing,
        }
    }
}

/// The whole program.
pub fn main() -> ExitCode {
    let status = match Cli::parse().command {
        Command::Check(args) => check(&args),
        Command::Test(args) => test::test(&args),
        Command::Rules(args) => rules::rules(&args),
    };
    ExitCode::from(status as u8)
}

fn check(args: &CheckArgs) -> Status {
    if let Some(problem) = args.report.problem() {
        anstream::eprintln!("error: {problem}");
        return Status::Usage;
    }
    let definitions = match definitions(args.definitions.as_deref()) {
        Ok(definitions) => definitions,
        Err(status) => return status,
    };
    let mut required = Vec::new();
    for id in &args.require {
        let Some(rule) = rule(id) else {
            anstream::eprintln!("error: --require {id}: no such rule\n  help: `uavspec rules` lists all");
            return Status::Usage;
        };
        required.push(rule);
    }
    let of = args.of.as_deref().map(|name| (name, definitions.message_of_type(name)));
    if let Some((name, None)) = of {
        anstream::eprintln!("error: --type {name}: the definitions have no such message");
        return Status::Usage;
    }
    let of = of.and_then(|(_, id)| id);
    let files = match input::files(&args.files) {
        Ok(files) => files,
        Err((path, error)) => {
            anstream::eprintln!("error: {}: {error}", path.display());
            return Status::Unreadable;
        }
    };
    let settings = settings(args);
    let (mut subjects, mut unreadable) = (Vec::new(), Vec::new());
    parallel::each(
        &files,
        args.jobs,
        |path| judge(path, of, &definitions),
        |path, result| match result {
            Ok(found) => {
                let subject = Subject::of_source(found, &definitions, &settings);
                if args.report.printed() == Kind::Text {
                    report::print(&subject_text(&subject));
                }
                subjects.push(subject);
            }
            Err(error) => {
                let path = path.display().to_string();
                anstream::eprintln!("error: {path}: {error}");
                unreadable.push(Unreadable { path, message: error.to_string() });
            }
        },
    );
    let is_idle = |id: &str| {
        let rules = subjects.iter().flat_map(|subject: &Subject| &subject.rules);
        rules.filter(|rule| rule.id == id).all(|rule| rule.exercised == 0)
    };
    let idle = required.iter().filter(|rule| is_idle(rule.id));
    let remarks: Vec<String> = idle
        .map(|rule| format!("{} was required, and nothing was there that it could have judged", rule.id))
        .collect();
    for remark in &remarks {
        anstream::eprintln!("error: {remark}");
    }
    let report = Report::new(Action::Check, command(), &definitions, subjects, unreadable, remarks);
    deliver(&args.report, &report)
}

/// Prints and writes a report; the status that the run ends with.
fn deliver(args: &ReportArgs, report: &Report) -> Status {
    args.print(report);
    let failures = args.write(report);
    for (path, error) in &failures {
        anstream::eprintln!("error: {}: the report can't be written: {error}", path.display());
    }
    if failures.is_empty() { report.conclusion.outcome.into() } else { Status::Unreadable }
}

/// The command line of this run.
fn command() -> String {
    let arguments: Vec<String> =
        std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()).collect();
    command_line(["uavspec"].into_iter().chain(arguments.iter().map(String::as_str)))
}

/// How sources are to be judged.
fn settings(args: &CheckArgs) -> Settings {
    let mut arguments = Vec::new();
    if let Some(path) = &args.definitions {
        arguments.extend(["--definitions".to_owned(), path.display().to_string()]);
    }
    if let Some(name) = &args.of {
        arguments.extend(["--type".to_owned(), name.clone()]);
    }
    if args.strict_formats {
        arguments.push("--strict-formats".to_owned());
    }
    Settings { are_formats_strict: args.strict_formats, arguments }
}

/// The definitions at a path, or those of this program; what is wrong with them has been told.
fn definitions(path: Option<&Path>) -> Result<Definitions, Status> {
    path.map_or_else(|| Ok(Definitions::built_in()), Definitions::load).map_err(|failure| {
        anstream::eprintln!("{failure}");
        Status::Usage
    })
}

fn judge(path: &Path, of: Option<MessageId>, definitions: &Definitions) -> io::Result<Judged> {
    let started = Instant::now();
    let judgement = judge::judge(input::open(path)?, of, definitions)?;
    Ok(Judged { path: path.display().to_string(), judgement, elapsed: started.elapsed().as_millis() })
}
