//! The command line that an `xtask` embeds, here and in other workspaces.
//!
//! ```no_run
//! fn main() -> std::process::ExitCode {
//!     uavspec_codegen::cli::main()
//! }
//! ```
//!
//! A build script calls [`generate`](crate::generate()) instead, which prints nothing.
//!
//! Exit status: 0 all is well; 1 mistakes in the definitions, or stale output or layout with `--check`;
//! 2 the command can't be carried out: wrong usage, missing input, unwritable output.

mod arguments;
mod breaking;
mod codegen;
mod format;
mod inspect;
mod lint;
mod print;
mod report;
mod revision;
mod translate;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Makes drone interface specifications executable: reads `.msg` definitions and specification
/// tables, and generates Rust types, JSON Schemas, documentation, test vectors, TypeScript and Python from them.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// The commands, to be embedded among those of another command line.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Generate Rust types, JSON Schemas, documentation, test vectors, TypeScript and Python from the definitions.
    Codegen(codegen::CodegenArgs),
    /// Lay out definitions and error-code tables: spacing, comments, annotations, columns.
    Fmt(format::FmtArgs),
    /// Print the model of the definitions as JSON.
    Inspect(inspect::InspectArgs),
    /// Find what should be written otherwise in the definitions, and mend what can be.
    Lint(lint::LintArgs),
    /// Bring catalogues of translations up to date with the definitions, or begin one.
    Translate(translate::TranslateArgs),
    /// Compare the definitions with an earlier state, and say what breaks whom.
    Breaking(breaking::BreakingArgs),
}

/// The whole command line of an `xtask` that does nothing else.
pub fn main() -> ExitCode {
    Cli::parse().command.run()
}

impl Command {
    /// Carries out the command and reports on standard error.
    pub fn run(self) -> ExitCode {
        let result = match self {
            Self::Codegen(args) => codegen::run(&args),
            Self::Fmt(args) => format::run(&args),
            Self::Inspect(args) => inspect::run(&args),
            Self::Lint(args) => lint::run(&args),
            Self::Translate(args) => translate::run(&args),
            Self::Breaking(args) => breaking::run(&args),
        };
        match result {
            Ok(true) => ExitCode::SUCCESS,
            Ok(false) => ExitCode::from(1),
            Err(failure) => {
                anstream::eprintln!("{failure}");
                ExitCode::from(2)
            }
        }
    }
}
