//! Benchmarks, which print results and have no pass criteria.

mod compile;
mod derive;
mod fleet;
mod live;
mod log;
mod peers;

use std::env;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::ValueEnum;

use crate::paths::repository;

/// The environment variable that names another program to measure.
const PROGRAM: &str = "UAVSPEC";

/// A group of benchmarks.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Benchmark {
    /// Code generation
    Codegen,
    /// Compilation of the generated code
    Compile,
    /// Message codecs
    Codec,
    /// Log and JSON checks
    Conformance,
    /// Thousands of captures with the program, Python, Spark and Ray. Requires 20 GB of disk space
    Fleet,
    /// Live vehicles with many large messages
    Live,
    /// Other libraries on the same inputs, in separate processes
    Peers,
}

pub(crate) fn run(benchmark: Benchmark) -> Result<bool, String> {
    match benchmark {
        Benchmark::Codegen => benches(&[("uavspec-codegen", "codegen")]),
        Benchmark::Compile => compile::run(),
        Benchmark::Codec => benches(&[("uavspec-types", "codec"), ("uavspec-codegen", "dynamic")]),
        Benchmark::Fleet => fleet::run(),
        Benchmark::Live => live::run(),
        Benchmark::Peers => peers::run(),
        Benchmark::Conformance => benches(&["ulog", "checking"].map(|bench| ("uavspec", bench))),
    }
    .map(|()| true)
}

/// Runs the benchmarks in sequence. Each benchmark is given by its package and name.
fn benches(benches: &[(&str, &str)]) -> Result<(), String> {
    let run = |(package, bench): &(&str, &str)| {
        cargo(Path::new("."), &["bench", "--package", package, "--bench", bench])
    };
    benches.iter().try_for_each(run)
}

/// The folder of the corpus.
fn corpus() -> PathBuf {
    env::var_os("UAVSPEC_CORPUS").map_or_else(|| repository().join("../shared/corpus"), PathBuf::from)
}

/// The program to measure: the release build with these features, unless the environment names another program.
fn program(features: &str) -> Result<OsString, String> {
    if let Some(program) = env::var_os(PROGRAM) {
        return Ok(program);
    }
    let build = ["build", "--release", "--package", "uavspec", "--features", features];
    cargo(Path::new("."), &build)?;
    Ok("target/release/uavspec".into())
}

fn cargo(folder: &Path, arguments: &[&str]) -> Result<(), String> {
    execute(Command::new("cargo").args(arguments).current_dir(folder).env("CARGO_INCREMENTAL", "0"))
}

/// Runs a command without the variables that describe the package of this program. Build scripts that read them would run
/// again.
fn execute(command: &mut Command) -> Result<(), String> {
    for (name, _) in env::vars_os() {
        if name
            .to_str()
            .is_some_and(|name| name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_"))
        {
            command.env_remove(name);
        }
    }
    let status = command.status();
    let words = [command.get_program()].into_iter().chain(command.get_args()).map(OsStr::to_string_lossy);
    let line = words.collect::<Vec<_>>().join(" ");
    let status = status.map_err(|error| format!("cannot run {line}: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("{line} failed: {status}")) }
}
