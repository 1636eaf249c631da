//! Measures compile times of the code generated from all PX4 messages.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::{cargo, derive};

/// The number of runs per measurement; the median is printed.
const RUNS: usize = 5;

/// The runtime features that add trait implementations to messages.
pub(super) const FEATURES: [&str; 5] = ["defmt", "proptest", "schemars", "serde", "views"];

/// Two crates with the same messages.
pub(super) struct Crates {
    pub(super) generated: PathBuf,
    /// Plain structs with derives.
    pub(super) plain: PathBuf,
    messages: usize,
}

impl Crates {
    /// Writes both crates.
    pub(super) fn write() -> Result<Self, String> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let generated = root.join("target/bench-compile");
        let plain = root.join("target/bench-derive");
        let messages = generate(&root, &generated)?;
        derive::write(&generated.join("src/px4"), &plain)?;
        Ok(Self { generated, plain, messages })
    }
}

pub(super) fn run() -> Result<(), String> {
    let Crates { generated, plain, messages } = Crates::write()?;
    println!("{messages} messages, seconds for cargo check (median of {RUNS}, minimum to maximum)\n");
    println!("| features | generated | | plain structs with derives | |\n|---|---|---|---|---|");
    let all = FEATURES.join(",");
    for features in [""].into_iter().chain(FEATURES).chain([all.as_str()]) {
        let of_runtime: Vec<String> =
            features.split_terminator(',').map(|feature| format!("uavspec-runtime/{feature}")).collect();
        let ours = time(&generated, &["check", "--quiet", "--features", &of_runtime.join(",")])?;
        let derived = time(&plain, &["check", "--quiet", "--features", features])?;
        println!("| {} | {ours} | {derived} |", if features.is_empty() { "none" } else { features });
    }
    let release = ["build", "--quiet", "--release", "--features", "uavspec-runtime/serde"];
    println!("\nbuild --release with serde: {}", time(&generated, &release)?);
    Ok(())
}

/// Generates the crate and returns the number of messages.
fn generate(root: &Path, folder: &Path) -> Result<usize, String> {
    let messages = super::corpus().join("px4/main/msg");
    let messages = fs::canonicalize(&messages).map_err(|error| format!("{}: {error}", messages.display()))?;
    let at = |error: std::io::Error| format!("{}: {error}", folder.display());
    fs::create_dir_all(folder.join("src")).map_err(at)?;
    let runtime = fs::canonicalize(root.join("generated/runtime")).map_err(at)?;
    let manifest = format!(
        "[package]\nname = \"px4\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\nuavspec-runtime = {{ \
         path = \"{}\" }}\n\n[workspace]\n",
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
        uavspec_codegen::generate(folder.join("uavspec.toml")).map_err(|failure| failure.to_string())?;
    Ok(generated.inputs.len() - 1)
}

/// Measures the compile time of one crate, without incremental compilation.
fn time(folder: &Path, arguments: &[&str]) -> Result<String, String> {
    let at = |error: std::io::Error| format!("{}: {error}", folder.display());
    cargo(folder, arguments)?;
    let mut times = Vec::new();
    for _ in 0..RUNS {
        let root = folder.join("src/lib.rs");
        let text = fs::read(&root).map_err(at)?;
        fs::write(&root, text).map_err(at)?;
        let started = Instant::now();
        cargo(folder, arguments)?;
        times.push(started.elapsed());
    }
    times.sort();
    let seconds = |index: usize| times.get(index).map_or(0.0, Duration::as_secs_f64);
    Ok(format!("{:.2} | {:.2} to {:.2}", seconds(RUNS / 2), seconds(0), seconds(RUNS - 1)))
}
