//! Benchmarks, which print results and have no pass criteria.

mod compile;
mod derive;
mod live;

use std::path::Path;
use std::process::Command;

use clap::ValueEnum;

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
    /// Live vehicles with many large messages
    Live,
}

pub(crate) fn run(benchmark: Benchmark) -> Result<bool, String> {
    match benchmark {
        Benchmark::Codegen => benches(&[("uavspec-codegen", "codegen")]),
        Benchmark::Compile => compile::run(),
        Benchmark::Codec => benches(&[("uavspec", "codec"), ("uavspec-codegen", "dynamic")]),
        Benchmark::Live => live::run(),
        Benchmark::Conformance => benches(&["ulog", "checking"].map(|bench| ("uavspec-conformance", bench))),
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

fn cargo(folder: &Path, arguments: &[&str]) -> Result<(), String> {
    let mut command = Command::new("cargo");
    command.args(arguments).current_dir(folder).env("CARGO_INCREMENTAL", "0");
    let status = command.status().map_err(|error| format!("cannot run cargo: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("cargo {} failed", arguments.join(" "))) }
}
