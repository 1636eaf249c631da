//! `uavspec testee`.

use std::ffi::OsString;
use std::io::{self, Write as _};
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Subcommand};

use super::progress::Progress;
use super::test::{seconds, target};
use super::{Format, Status};
use crate::net::Address;
use crate::testee::case::cases;
use crate::testee::lint::report::{to_json, to_text};
use crate::testee::lint::{CHECKS, Check, check, lint};
use crate::testee::options::Options;

/// What is to be done with a testee.
#[derive(Debug, Subcommand)]
pub(super) enum TesteeCommand {
    /// Try the manners of a testee: whether it keeps to the protocol of `uavspec test`.
    Lint(LintArgs),
}

/// Arguments of `testee lint`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  uavspec testee lint -- ./my-codec --stdio
  uavspec testee lint --attach localhost:7700
  uavspec testee lint --only unknown-op,unknown-type -- ./my-codec
  uavspec testee lint --format json -- python3 testee.py

Each check has a process or a connection of its own. What the answers say is not judged: `uavspec test` does that.

Exit status: 0 good manners, 1 a check failed, 2 wrong usage or definitions, 3 the testee can't be started or reached.")]
pub(super) struct LintArgs {
    /// The testee: a program and its arguments. A script that starts another program should `exec` it.
    #[arg(last = true, value_name = "COMMAND", required_unless_present = "attach")]
    command: Vec<OsString>,
    /// Connect to a testee that listens, over TCP, instead of starting one.
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "command")]
    attach: Option<Address>,
    /// What to ask about: a uavspec.toml, a folder with one, or a folder of .msg files; the definitions of this
    /// program, where nothing is said.
    #[arg(long, value_name = "PATH")]
    definitions: Option<PathBuf>,
    /// Only these checks, and the introduction that all of them need.
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    only: Vec<String>,
    /// How long a testee may be silent while there are questions, in seconds.
    #[arg(long, value_name = "SECONDS", default_value = "5", value_parser = seconds)]
    timeout: Duration,
    /// How long it may take to introduce itself, and to take a connection, in seconds.
    #[arg(long, value_name = "SECONDS", default_value = "30", value_parser = seconds)]
    start_timeout: Duration,
    /// How to report.
    #[arg(long, default_value = "text")]
    format: Format,
}

pub(super) fn testee(command: &TesteeCommand) -> Status {
    match command {
        TesteeCommand::Lint(args) => lint_testee(args),
    }
}

fn lint_testee(args: &LintArgs) -> Status {
    let definitions = match super::definitions(args.definitions.as_deref()) {
        Ok(definitions) => definitions,
        Err(status) => return status,
    };
    let only = match args.only.iter().map(|id| check(id).ok_or(id)).collect::<Result<Vec<&Check>, _>>() {
        Ok(only) => only,
        Err(id) => {
            let known: Vec<&str> = CHECKS.iter().map(|check| check.id).collect();
            anstream::eprintln!("error: --only {id}: no such check\n  help: there are {}", known.join(", "));
            return Status::Usage;
        }
    };
    let types = definitions.types();
    let cases = cases(&definitions, types);
    let options = Options {
        timeout: args.timeout,
        start_timeout: args.start_timeout,
        ..Options::new(target(&args.command, args.attach.as_ref()))
    };
    let progress = Progress::steps("checks");
    let found = lint(&cases, types, &options, &only, &|done, total| progress.set(done, total));
    drop(progress);
    let found = match found {
        Ok(found) => found,
        Err(error) => {
            anstream::eprintln!("error: {error}");
            return Status::Unreadable;
        }
    };
    // A reader that has seen enough closes the pipe: that is no failure. The stream drops colours where needed.
    let _ = match args.format {
        Format::Text => write!(anstream::stdout(), "{}", to_text(&found)),
        Format::Json => io::stdout().write_all(to_json(&found).as_bytes()),
    };
    if found.is_ok() { Status::Conforms } else { Status::DoesNotConform }
}
