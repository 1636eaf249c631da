//! The documentation site: what is generated, and what is written by hand, as a book.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::Args;

/// Arguments of `docs`.
#[derive(Args)]
pub(crate) struct DocsArgs {
    /// Show the site when it is built.
    #[arg(long)]
    open: bool,
    /// The folder of the site.
    #[arg(long, value_name = "DIR", default_value = "target/site")]
    output: PathBuf,
}

/// Generates, and has a program of its own build the site: mdBook takes a minute to compile, which nobody should wait
/// for who only generates.
pub(crate) fn run(args: &DocsArgs) -> ExitCode {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."));
    if let Err(failure) = uavspec_codegen::cli::generate(repository.join("definitions/uavspec.toml")) {
        eprintln!("{failure}");
        return ExitCode::FAILURE;
    }
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command
        .args(["run", "--quiet", "--locked", "--manifest-path"])
        .arg(repository.join("xtask/site/Cargo.toml"));
    command.arg("--target-dir").arg(repository.join("target/site-build")).arg("--");
    command.arg("--repository").arg(repository).arg("--output").arg(&args.output);
    command.args(args.open.then_some("--open"));
    match command.status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: cargo: {error}");
            ExitCode::FAILURE
        }
    }
}
