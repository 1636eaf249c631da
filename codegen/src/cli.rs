//! The command line of an `xtask`, in this workspace or another.
//!
//! ```no_run
//! fn main() -> std::process::ExitCode {
//!     uavspec_codegen::cli::main()
//! }
//! ```
//!
//! A build script calls [`generate`](crate::generate()) instead, which prints nothing.
//!
//! The exit status is 0 on success. The exit status is 1 if the definitions contain errors, if `--check` finds outdated
//! files, or if `lint` or `breaking` has findings at the `--deny` level or above. The exit status is 2 if the command
//! failed because of invalid usage, missing input or unwritable output. The exit status is 4 if the only problem is a
//! baseline that is out of date.

mod arguments;
pub mod baseline;
mod breaking;
mod codegen;
mod format;
mod inspect;
mod lint;
mod print;
mod report;
mod revision;
mod status;
mod stopwatch;
mod translate;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use uavspec_schema::failure::Failure;
use uavspec_schema::terminal;

use self::status::Status;

/// The program in the examples.
const PROGRAM: &str = "cargo xtask";

/// Generates code, schemas and documentation from drone interface definitions.
///
/// Reads `.msg` definitions and specification tables.
#[derive(Debug, Parser)]
#[command(
    name = PROGRAM,
    bin_name = PROGRAM,
    max_term_width = 80,
    version,
    after_help = "Run `cargo xtask COMMAND --help` for examples."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// The commands, to embed in another command line.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Generate code, schemas, documentation and test vectors
    Codegen(codegen::CodegenArgs),
    /// Format definitions and specification pages
    Fmt(format::FmtArgs),
    /// Print the model of the definitions as JSON
    Inspect(inspect::InspectArgs),
    /// Check definitions for style problems, and fix them with --fix
    Lint(lint::LintArgs),
    /// Create or update translation catalogues
    Translate(translate::TranslateArgs),
    /// Compare the definitions with an earlier version
    Breaking(breaking::BreakingArgs),
}

/// Names another program in the examples of the commands, instead of `cargo xtask`.
#[must_use]
pub fn with_program(mut command: clap::Command, program: &str) -> clap::Command {
    let own = Command::augment_subcommands(clap::Command::new(PROGRAM));
    for known in own.get_subcommands() {
        command = command.mut_subcommand(known.get_name(), |command| {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            command.after_help(help.replace(PROGRAM, program))
        });
    }
    command
}

/// Runs the command line of an `xtask` that has no other commands.
pub fn main() -> ExitCode {
    terminal::parse::<Cli>().command.run()
}

impl Command {
    /// Runs the command. The command's messages go to standard error.
    pub fn run(self) -> ExitCode {
        let result = match self {
            Self::Codegen(args) => codegen::run(&args).map(Status::from),
            Self::Fmt(args) => format::run(&args).map(Status::from),
            Self::Inspect(args) => inspect::run(&args).map(Status::from),
            Self::Lint(args) => lint::run(&args),
            Self::Translate(args) => translate::run(&args).map(Status::from),
            Self::Breaking(args) => breaking::run(&args),
        };
        // Report lost output even if the command also has findings.
        let printed = |error| Failure::new(format!("standard output: {error}"));
        match result.and_then(|status| terminal::finish().map(|()| status).map_err(printed)) {
            Ok(status) => ExitCode::from(status as u8),
            Err(failure) => {
                terminal::eprintln!("{failure}");
                ExitCode::from(2)
            }
        }
    }
}
