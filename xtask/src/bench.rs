//! Measurements. They report; nothing is judged by them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

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

/// How often each compilation is timed; the median is printed.
const RUNS: usize = 5;

pub(crate) fn run(what: What) -> ExitCode {
    let here = Path::new(".");
    let result = match what {
        What::Codegen => cargo(here, &["bench", "--package", "uavspec-codegen", "--bench", "codegen"]),
        What::Compile => compile(),
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

/// Generates a crate from the whole of PX4 and times its compilation, without incremental reuse.
fn compile() -> Result<(), String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let default = root.join("../shared/corpus");
    let messages = std::env::var_os("UAVSPEC_CORPUS").map_or(default, PathBuf::from).join("px4/main/msg");
    let messages = fs::canonicalize(&messages).map_err(|error| format!("{}: {error}", messages.display()))?;
    let folder = root.join("target/bench-compile");
    let at = |error: std::io::Error| format!("{}: {error}", folder.display());
    fs::create_dir_all(folder.join("src")).map_err(at)?;
    let runtime = fs::canonicalize(root.join("generated/runtime")).map_err(at)?;
    let manifest = format!(
        "[package]\nname = \"px4\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[features]\n\
         serde = [\"uavspec-runtime/serde\"]\n\n[dependencies]\nuavspec-runtime = {{ path = \"{}\" }}\n\n[workspace]\n",
        runtime.display()
    );
    fs::write(folder.join("Cargo.toml"), manifest).map_err(at)?;
    let config = format!(
        "[output]\nrust = {{ path = \"src\", root = \"lib.rs\" }}\n\n[[package]]\nname = \"px4\"\ndialect = \"px4\"\n\
         include = [{:?}]\n",
        format!("{}/*.msg", messages.display())
    );
    fs::write(folder.join("uavspec.toml"), config).map_err(at)?;
    let generated =
        uavspec_codegen::cli::generate(folder.join("uavspec.toml")).map_err(|failure| failure.to_string())?;
    println!("{} definitions", generated.inputs.len() - 1);
    for (name, arguments) in [
        ("check", &["check", "--quiet"][..]),
        ("check with serde", &["check", "--quiet", "--features", "serde"]),
        ("build --release with serde", &["build", "--quiet", "--release", "--features", "serde"]),
    ] {
        cargo(&folder, arguments)?;
        let mut times = Vec::new();
        for _ in 0..RUNS {
            let root = folder.join("src/lib.rs");
            let text = fs::read(&root).map_err(at)?;
            fs::write(&root, text).map_err(at)?;
            let started = Instant::now();
            cargo(&folder, arguments)?;
            times.push(started.elapsed());
        }
        times.sort();
        println!(
            "{name}: {:.2} s (median of {RUNS}; {:.2} to {:.2})",
            seconds(times[RUNS / 2]),
            seconds(times[0]),
            seconds(times[RUNS - 1])
        );
    }
    Ok(())
}

fn seconds(duration: Duration) -> f64 {
    duration.as_secs_f64()
}

fn cargo(folder: &Path, arguments: &[&str]) -> Result<(), String> {
    let mut command = Command::new("cargo");
    command.args(arguments).current_dir(folder).env("CARGO_INCREMENTAL", "0");
    let status = command.status().map_err(|error| format!("cargo: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("cargo {} failed", arguments.join(" "))) }
}
