//! The chores of this repository: the commands of uavspec-codegen, and its own.
//!
//! Exit status, as that of uavspec-codegen: 0 all is well; 1 something is to be mended; 2 the command can't be carried out.

mod bench;
mod docs;
mod interop;
mod package;
mod place;

use std::env;
use std::ffi::OsString;
use std::process::{self, ExitCode};

use clap::{Parser, Subcommand};
use uavspec_codegen::Failure;

/// The chores of this repository.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    #[command(flatten)]
    Specification(uavspec_codegen::cli::Command),
    /// Judge by the specification: run `uavspec`, which without arguments tests itself.
    #[command(
        disable_help_flag = true,
        after_help = "Examples:
  cargo xtask conformance                   recordings made of the definitions, conforming and broken, and the reference codec
  cargo xtask conformance check flight.ulg
  cargo xtask conformance --help"
    )]
    Conformance {
        /// Arguments of `uavspec`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENT")]
        arguments: Vec<OsString>,
    },
    /// Build the documentation site, which needs no server and no network.
    #[command(after_help = "Examples:
  cargo xtask docs --open        generate, build, and show the site
  cargo xtask docs --out public  build it into another folder")]
    Docs(docs::Arguments),
    /// Make the packages for npm and pip; needs neither of them.
    Package(package::Arguments),
    /// Give the published schemas and all test vectors to validators and generators of other makers.
    #[command(after_help = "Examples:
  cargo xtask interop                  all tools that can be run; installs below target/interop what needs no root
  cargo xtask interop --quick --check  what CI does
  cargo xtask interop --only ajv,boon
  cargo xtask interop --list")]
    Interop(interop::Arguments),
    /// Measure and print; needs the corpus.
    #[command(after_help = "Examples:
  cargo xtask bench codegen      time to read, to emit and to write PX4's 261 messages, at 1, 4 and 16 times
  cargo xtask bench compile      time to compile the crate that is generated from them
  cargo xtask bench codec        time to read and write messages, beside a plain copy and other crates
  cargo xtask bench conformance  time to judge logs and JSON, beside serde_json and jsonschema")]
    Bench {
        /// What to measure.
        what: bench::What,
    },
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Specification(command) => return command.run(),
        Command::Conformance { arguments } => return conformance(arguments),
        Command::Docs(arguments) => docs::run(arguments),
        Command::Package(arguments) => package::run(arguments),
        Command::Interop(arguments) => interop::run(&arguments),
        Command::Bench { what } => bench::run(what),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

/// Why the generator can't do something, to be told by [`main`], which says that it is an error.
fn told(failure: &Failure) -> String {
    failure.to_string().trim_start_matches("error: ").to_owned()
}

/// Runs `uavspec`. It is a process of its own: this program has to work where generated code doesn't compile.
fn conformance(arguments: Vec<OsString>) -> ExitCode {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let run = |package: &str| ["run", "--quiet", "--package", package, "--"].map(OsString::from);
    let itself = || {
        let testee = [cargo.clone()].into_iter().chain(run("uavspec-testee"));
        ["self-test".into(), "--".into()].into_iter().chain(testee).collect()
    };
    let arguments: Vec<OsString> = if arguments.is_empty() { itself() } else { arguments };
    let mut command = process::Command::new(&cargo);
    command.args(run("uavspec-conformance")).args(arguments);
    match command.status().map(|status| status.code().and_then(|code| u8::try_from(code).ok())) {
        Ok(code) => code.map_or(ExitCode::FAILURE, ExitCode::from),
        Err(error) => {
            eprintln!("error: cargo: {error}");
            ExitCode::from(2)
        }
    }
}
