//! Measurements. They report; nothing is judged by them.

mod compile;
mod derive;

use std::path::Path;
use std::process::Command;

use clap::ValueEnum;

/// What is measured.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum What {
    /// The generator.
    Codegen,
    /// Compiling what it generates.
    Compile,
    /// Reading and writing messages.
    Codec,
    /// Judging logs and JSON.
    Conformance,
}

pub(crate) fn run(what: What) -> Result<bool, String> {
    match what {
        What::Codegen => benches(&[("uavspec-codegen", "codegen")]),
        What::Compile => compile::run(),
        What::Codec => benches(&[("uavspec", "codec"), ("uavspec-codegen", "dynamic")]),
        What::Conformance => benches(&["ulog", "checking"].map(|bench| ("uavspec-conformance", bench))),
    }
    .map(|()| true)
}

/// Runs benchmarks one after the other: packages and names.
fn benches(benches: &[(&str, &str)]) -> Result<(), String> {
    let run = |(package, bench): &(&str, &str)| {
        cargo(Path::new("."), &["bench", "--package", package, "--bench", bench])
    };
    benches.iter().try_for_each(run)
}

fn cargo(folder: &Path, arguments: &[&str]) -> Result<(), String> {
    let mut command = Command::new("cargo");
    command.args(arguments).current_dir(folder).env("CARGO_INCREMENTAL", "0");
    let status = command.status().map_err(|error| format!("cargo: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("cargo {} failed", arguments.join(" "))) }
}
