//! `uavspec testee`.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Subcommand};
use uavspec_model::net::Address;
use uavspec_model::text::terminal;
use uavspec_probe::testee::case::cases;
use uavspec_probe::testee::lint::report::{to_json, to_text};
use uavspec_probe::testee::lint::{CHECKS, Check, check, lint};
use uavspec_probe::testee::options::Options;

use super::progress::Progress;
use super::test::{seconds, target};
use super::{Exit, Format, Status, unknown};

/// Subcommands of `testee`.
#[derive(Debug, Subcommand)]
pub(super) enum TesteeCommand {
    /// Check whether a testee implements the protocol of `uavspec test`.
    ///
    /// Each check uses a separate process or connection. To check the codec's results, use `uavspec test`.
    Lint(LintArgs),
}

const EXAMPLES: &str = "Examples:
  uavspec testee lint -- ./my-codec --stdio
  uavspec testee lint --attach localhost:7700
  uavspec testee lint --only unknown-op,unknown-type -- ./my-codec
  uavspec testee lint --format json -- python3 testee.py";

const STATUS: &str = "Exit status:
  0  the testee implements the protocol
  1  a check failed
  2  invalid usage, or unreadable definitions
  3  the testee can't be started or reached";

/// Arguments of `testee lint`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{STATUS}"))]
pub(super) struct LintArgs {
    /// Testee and its arguments.
    ///
    /// A script that starts another program should `exec` it.
    #[arg(last = true, value_name = "COMMAND", required_unless_present = "attach")]
    command: Vec<OsString>,
    /// Connect to a running testee over TCP.
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "command")]
    attach: Option<Address>,
    /// Definitions to use [default: built-in].
    ///
    /// A uavspec.toml file, a folder that contains one, or a folder of .msg files. The requests are generated from the
    /// definitions.
    #[arg(long, value_name = "PATH")]
    definitions: Option<PathBuf>,
    /// Run only this check (repeatable).
    ///
    /// Separate multiple ids with commas. The check `introduction` is always included.
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    only: Vec<String>,
    /// Maximum time without a response.
    #[arg(long, value_name = "SECONDS", default_value = "5", value_parser = seconds)]
    timeout: Duration,
    /// Maximum time to start.
    ///
    /// This includes the wait for the hello response and, with --attach, the time to connect.
    #[arg(long, value_name = "SECONDS", default_value = "30", value_parser = seconds)]
    start_timeout: Duration,
    /// Output format: text or json.
    #[arg(long, default_value = "text", hide_possible_values = true)]
    format: Format,
}

pub(super) fn testee(command: &TesteeCommand) -> Exit {
    let TesteeCommand::Lint(args) = command;
    let definitions = super::definitions(args.definitions.as_deref())?;
    let find = |id: &String| {
        check(id).ok_or_else(|| {
            let known: Vec<&str> = CHECKS.iter().map(|check| check.id).collect();
            let help = format!("use one of {}", known.join(", "));
            unknown(&format!("--only {id}: no such check"), id, known.into_iter(), &help)
        })
    };
    let only: Vec<&Check> = args.only.iter().map(find).collect::<Result<_, _>>()?;
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
    let found = found.map_err(|error| Status::Unreadable.with_details(error))?;
    match args.format {
        Format::Text => terminal::print(format_args!("{}", to_text(&found))),
        Format::Json => terminal::print_unguarded(&to_json(&found)),
    }
    Ok(if found.is_ok() { Status::Conforms } else { Status::DoesNotConform })
}
