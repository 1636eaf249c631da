//! The program that contains all targets.

use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::command::{cargo, output, run};

/// The flags that `cargo fuzz` sets without a sanitizer: libFuzzer counts the executions of each edge, knows the edges'
/// addresses, and sees the operands of comparisons.
const FLAGS: [&str; 6] = [
    "--cfg fuzzing",
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
];

/// The variable that selects a target.
const TARGET: &str = "UAVSPEC_FUZZ_TARGET";

/// The variable with the folder for the first inputs.
const SEEDS: &str = "UAVSPEC_FUZZ_SEEDS";

/// The compiled program.
pub(super) struct Program {
    path: PathBuf,
}

impl Program {
    /// Compiles the program, which is a separate workspace.
    pub(super) fn build(root: &Path) -> Result<Self, String> {
        let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        let host = output(Command::new(rustc).args(["--print", "host-tuple"]))?;
        let folder = root.join("target/fuzz");
        // Don't use `--locked`, because each new dependency of the main workspace changes the lock file of the fuzz
        // workspace.
        let mut cargo = Command::new(cargo());
        cargo.args(["build", "--release", "--manifest-path"]).arg(root.join("xtask/fuzz/Cargo.toml"));
        // With a target, the flags don't apply to build scripts and macros.
        cargo.args(["--target", &host, "--target-dir"]).arg(&folder);
        cargo.env("RUSTFLAGS", FLAGS.join(" ")).env_remove("CARGO_ENCODED_RUSTFLAGS");
        run(&mut cargo).map_err(|error| format!("the fuzz targets could not be compiled: {error}"))?;
        Ok(Self { path: folder.join(host).join("release/uavspec-fuzz") })
    }

    /// The names of all targets.
    pub(super) fn targets(&self) -> Result<Vec<String>, String> {
        let output = self.output(Command::new(&self.path).env_remove(TARGET))?;
        Ok(String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect())
    }

    /// Writes the inputs that a first run starts from.
    pub(super) fn write_seeds(&self, target: &str, folder: &Path) -> Result<(), String> {
        let output = self.output(Command::new(&self.path).env(TARGET, target).env(SEEDS, folder))?;
        if output.status.success() {
            return Ok(());
        }
        Err(format!("{target}: no seeds: {}", String::from_utf8_lossy(&output.stderr).trim_end()))
    }

    /// Runs a target with these libFuzzer arguments, and returns its output.
    pub(super) fn run<A: AsRef<OsStr>>(
        &self,
        target: &str,
        arguments: impl IntoIterator<Item = A>,
    ) -> Result<Output, String> {
        self.output(Command::new(&self.path).env(TARGET, target).env_remove(SEEDS).args(arguments))
    }

    fn output(&self, command: &mut Command) -> Result<Output, String> {
        command.output().map_err(|error| format!("cannot run {}: {error}", self.path.display()))
    }
}
