//! The chores of this repository: the commands of uavspec-codegen, and its own.

mod bench;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

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
    match Cli::parse().command {
        Command::Specification(command) => command.run(),
        Command::Bench { what } => bench::run(what),
    }
}
