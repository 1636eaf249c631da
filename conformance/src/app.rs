//! The command line of `uavspec`.
//!
//! Exit status: 0 conforms; 1 doesn't; 2 wrong usage, or definitions or lists that can't be read; 3 a source that
//! can't be read to its end, a report that can't be written, or a testee or server that broke; 4 a list of known failures no longer holds
//! true; 5 nothing was checked. Where several apply, 2 goes before 3, 1, 4 and 5.
//!
//! ```no_run
//! let status: std::process::ExitCode = uavspec_conformance::app::main();
//! ```

mod check;
mod known;
mod probe;
mod progress;
mod report;
mod required;
mod rules;
mod self_test;
mod serve;
mod test;
mod testee;
mod watch;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand, ValueEnum};

use self::report::ReportArgs;
use crate::definitions::Definitions;
use crate::flockwave::body_schema::Schemas;
use crate::report::{OutcomeKind, Report};
use crate::text::command_line;

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
    Check(check::CheckArgs),
    /// Ask a codec or validator in any language, as a child process.
    Test(test::TestArgs),
    /// Work on a testee, before it is asked in earnest.
    #[command(subcommand)]
    Testee(testee::TesteeCommand),
    /// Ask a live Flockwave server, and judge what it says.
    Probe(probe::ProbeArgs),
    /// Be a Flockwave server with a simulated fleet, for those who write clients, and with a bug for those who judge
    /// servers.
    Serve(serve::ServeArgs),
    /// Watch the fleet of a Flockwave server: where its UAVs are, what they do, and what is wrong with them.
    Watch(watch::WatchArgs),
    /// List the rules, or tell all of one.
    Rules(rules::RulesArgs),
    /// Judge recordings that are made of the definitions, and others that break each rule: whether this program
    /// finds what it should, and nothing else.
    SelfTest(self_test::SelfTestArgs),
}

/// How lists are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// For people.
    Text,
    /// For programs.
    Json,
}

/// What a run ends with, from the best to that which goes before all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Status {
    Conforms,
    Nothing,
    Stale,
    DoesNotConform,
    Unreadable,
    Usage,
}

impl Status {
    fn code(self) -> u8 {
        match self {
            Self::Conforms => 0,
            Self::DoesNotConform => 1,
            Self::Usage => 2,
            Self::Unreadable => 3,
            Self::Stale => 4,
            Self::Nothing => 5,
        }
    }
}

impl From<OutcomeKind> for Status {
    fn from(outcome: OutcomeKind) -> Self {
        match outcome {
            OutcomeKind::Conforms => Self::Conforms,
            OutcomeKind::DoesNotConform => Self::DoesNotConform,
            OutcomeKind::Incomplete => Self::Unreadable,
            OutcomeKind::Stale => Self::Stale,
            OutcomeKind::Nothing => Self::Nothing,
        }
    }
}

/// The whole program.
pub fn main() -> ExitCode {
    let status = match Cli::parse().command {
        Command::Check(args) => check::check(&args),
        Command::Test(args) => test::test(&args),
        Command::Testee(command) => testee::testee(&command),
        Command::Probe(args) => probe::run(&args),
        Command::Serve(args) => serve::serve(&args),
        Command::Watch(args) => watch::watch(&args),
        Command::Rules(args) => rules::rules(&args),
        Command::SelfTest(args) => self_test::self_test(&args),
    };
    ExitCode::from(status.code())
}

/// Prints and writes a report; the status that the run ends with.
fn deliver(args: &ReportArgs, report: &Report) -> Status {
    let failures = args.write(report);
    for failure in &failures {
        anstream::eprintln!("error: {failure}");
    }
    if failures.is_empty() { report.outcome.kind.into() } else { Status::Unreadable }
}

/// The command line of this run.
fn command() -> String {
    let arguments: Vec<String> =
        std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()).collect();
    command_line(["uavspec"].into_iter().chain(arguments.iter().map(String::as_str)))
}

/// The definitions at a path, or those of this program; what is wrong with them has been told.
fn definitions(path: Option<&Path>) -> Result<Definitions, Status> {
    path.map_or_else(|| Ok(Definitions::built_in()), Definitions::load).map_err(|failure| {
        anstream::eprintln!("{failure}");
        Status::Usage
    })
}

/// The same, with JSON Schemas for bodies of Flockwave that they don't have.
fn definitions_with(path: Option<&Path>, schemas: &[PathBuf]) -> Result<Definitions, Status> {
    let definitions = definitions(path)?;
    let schemas = Schemas::load(schemas).map_err(|error| {
        anstream::eprintln!("error: {error}");
        Status::Usage
    })?;
    Ok(definitions.with_schemas(schemas))
}
