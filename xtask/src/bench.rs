//! Measurements. They report; nothing is judged by them.

mod compile;
mod derive;

use std::path::Path;
use std::process::{Command, ExitCode};

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
}

pub(crate) fn run(what: What) -> ExitCode {
    let here = Path::new(".");
    let result = match what {
        What::Codegen => cargo(here, &["bench", "--package", "uavspec-codegen", "--bench", "codegen"]),
        What::Compile => compile::run(),
        What::Codec => [("uavspec", "codec"), ("uavspec-codegen", "dynamic")]
            .into_iter()
            .try_for_each(|(package, bench)| cargo(here, &["bench", "--package", package, "--bench", bench])),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn cargo(folder: &Path, arguments: &[&str]) -> Result<(), String> {
    let mut command = Command::new("cargo");
    command.args(arguments).current_dir(folder).env("CARGO_INCREMENTAL", "0");
    let status = command.status().map_err(|error| format!("cargo: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("cargo {} failed", arguments.join(" "))) }
}
