//! The tasks of this repository: all commands of uavspec-codegen, and commands that only this repository needs.
//!
//! Exit status, as for uavspec-codegen: 0 success; 1 findings or outdated files; 2 the command failed; 4 a
//! baseline that is out of date.

mod affected;
mod archive;
mod bench;
mod command;
mod dist;
mod docs;
mod fuzz;
mod import;
mod interop;
mod package;
mod paths;
mod pictures;
mod platform;
mod sbom;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::{self, ExitCode};

use clap::{Parser, Subcommand};
use uavspec_schema::{Failure, terminal};

/// Run tasks of this repository
#[derive(Parser)]
#[command(
    name = "cargo xtask",
    bin_name = "cargo xtask",
    max_term_width = 80,
    after_help = "Run `cargo xtask COMMAND --help` for examples."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    #[command(flatten)]
    Specification(uavspec_codegen::cli::Command),
    /// Run `uavspec`; without arguments, run its self-test
    #[command(
        disable_help_flag = true,
        after_help = "Examples:
  cargo xtask conformance
  cargo xtask conformance check flight.ulg
  cargo xtask conformance --help"
    )]
    Conformance {
        /// Arguments of `uavspec`
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENT")]
        arguments: Vec<OsString>,
    },
    /// List the packages that a change can affect
    Affected(affected::Arguments),
    /// Build the documentation site
    #[command(after_help = "Examples:
  cargo xtask docs --open        generate, build and open the site
  cargo xtask docs --out public")]
    Docs(docs::Arguments),
    /// Take the pictures of the README
    #[command(after_help = "Examples:
  cargo xtask pictures
  cargo xtask pictures --check

Requires Chromium. The pages are written by the tests of uavspec-report.")]
    Pictures(pictures::Arguments),
    /// Build the packages for npm and pip
    Package(package::Arguments),
    /// Build the program for distribution, with archives and packages
    Dist(dist::Arguments),
    /// Write the software bill of materials of `uavspec`
    #[command(after_help = "Examples:
  cargo xtask sbom
  cargo xtask sbom --out uavspec.cdx.json

The document has the format CycloneDX 1.6. The same Cargo.lock leads to the same document.")]
    Sbom(sbom::Arguments),
    /// Import the definitions of a release
    #[command(after_help = "Examples:
  cargo xtask import px4 --release 1.18 --input ../px4_msgs
  cargo xtask import ros2 --release jazzy --input ../common_interfaces \\
    --input ../rcl_interfaces --input ../unique_identifier_msgs
  cargo xtask import --check

Writes definitions/releases/FAMILY/NAME.msg, and definitions/releases/fingerprints.tsv. Comments are left out. The inputs \
must contain all packages that their definitions refer to.")]
    Import(import::Arguments),
    /// Test third-party tools with the published schemas
    #[command(after_help = "Examples:
  cargo xtask interop                    run all available tools
  cargo xtask interop --quick --check    run the quick tools, as CI does
  cargo xtask interop --only ajv,boon
  cargo xtask interop --list

Tools are installed in target/interop, without root privileges. Tools that require missing system packages are \
skipped.")]
    Interop(interop::Arguments),
    /// Fuzz the readers of all inputs
    #[command(after_help = "Examples:
  cargo xtask fuzz --list
  cargo xtask fuzz ulog mcap --seconds 900
  cargo xtask fuzz --seconds 2              run each target briefly, as CI does
  cargo xtask fuzz ulog --minimise          update xtask/fuzz/corpus/ulog

Requires a C++ compiler. New inputs are written to target/fuzz/corpus, and inputs that violate a property are written \
to target/fuzz/artifacts. A run is limited to 1 GiB of memory, and an execution to 10 s.")]
    Fuzz(fuzz::Arguments),
    /// Run benchmarks; most of them require the corpus
    #[command(after_help = "Examples:
  cargo xtask bench codec          read and write messages; compare with others
  cargo xtask bench codegen        read, generate and write PX4's 261 messages
  cargo xtask bench compile        compile the generated crate
  cargo xtask bench conformance    check logs, JSON and sessions
  cargo xtask bench fleet          check thousands of captures
  cargo xtask bench live           listen to many large messages
  cargo xtask bench peers          compare the program with other libraries

codegen, compile, fleet and peers require the corpus. Without it, conformance skips the logs. fleet and live require \
Python packages that tests install. If they are missing, the command names the tests.")]
    Bench {
        /// Benchmarks to run
        benchmark: bench::Benchmark,
    },
}

fn main() -> ExitCode {
    let outcome = match terminal::parse::<Cli>().command {
        Command::Specification(command) => return command.run(),
        Command::Conformance { arguments } => return conformance(arguments),
        Command::Affected(arguments) => affected::run(&arguments),
        Command::Docs(arguments) => docs::run(arguments),
        Command::Pictures(arguments) => pictures::run(&arguments),
        Command::Package(arguments) => package::run(arguments),
        Command::Dist(arguments) => dist::run(arguments),
        Command::Interop(arguments) => interop::run(&arguments),
        Command::Import(arguments) => import::run(&arguments),
        Command::Fuzz(arguments) => fuzz::run(&arguments),
        Command::Sbom(arguments) => sbom::run(arguments),
        Command::Bench { benchmark } => bench::run(benchmark),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(message) => {
            terminal::eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

/// The message of a failure without the `error: ` prefix, which [`main`] adds.
fn message_of(failure: &Failure) -> String {
    failure.to_string().trim_start_matches("error: ").to_owned()
}

/// Runs `uavspec` in a separate process, because this program must work even if generated code doesn't compile.
fn conformance(arguments: Vec<OsString>) -> ExitCode {
    let is_self_test = arguments.is_empty();
    let built = build("uavspec")
        .and_then(|program| Ok((program, if is_self_test { Some(build("uavspec-testee")?) } else { None })));
    let (program, testee) = match built {
        Ok(built) => built,
        Err(problem) => {
            terminal::error(problem, None);
            return ExitCode::from(2);
        }
    };
    let mut command = process::Command::new(program);
    command.args(arguments);
    if let Some(testee) = testee {
        command.args(["self-test", "--"]).arg(testee);
    }
    match command.status().map(|status| status.code().and_then(|code| u8::try_from(code).ok())) {
        Ok(code) => code.map_or(ExitCode::FAILURE, ExitCode::from),
        Err(error) => {
            terminal::error(format_args!("cannot run uavspec: {error}"), None);
            ExitCode::from(2)
        }
    }
}

/// Builds the program of a package, and returns its path. Building first keeps the build time out of the program's time
/// limits.
fn build(package: &str) -> Result<PathBuf, String> {
    let mut cargo = process::Command::new(command::cargo());
    cargo.args([
        "build",
        "--quiet",
        "--bins",
        "--message-format",
        "json-render-diagnostics",
        "--package",
        package,
    ]);
    let built = cargo.stderr(process::Stdio::inherit()).output();
    let built = built.map_err(|error| format!("cannot run cargo: {error}"))?;
    let printed = String::from_utf8_lossy(&built.stdout);
    let messages = printed.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    let mut programs = messages.filter_map(|message| Some(PathBuf::from(message["executable"].as_str()?)));
    programs.next_back().filter(|_| built.status.success()).ok_or_else(|| format!("{package} doesn't build"))
}
