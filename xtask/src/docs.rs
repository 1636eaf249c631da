//! The documentation site: what is generated, and what is written by hand, as a book.

use std::env;
use std::path::PathBuf;
use std::process::Command;

use clap::Args;

use crate::place::{repository, shown};
use crate::told;

/// Arguments of `docs`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Show the site when it is built.
    #[arg(long)]
    open: bool,
    /// Folder for the site; target/site, where absent.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Generates, and has a program of its own build the site: mdBook takes a minute to compile, which nobody should wait
/// for who only generates.
pub(crate) fn run(arguments: Arguments) -> Result<bool, String> {
    let root = repository();
    uavspec_codegen::generate(root.join("definitions/uavspec.toml")).map_err(|failure| told(&failure))?;
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(["run", "--quiet", "--locked", "--manifest-path"]).arg(root.join("xtask/site/Cargo.toml"));
    command.arg("--target-dir").arg(root.join("target/site-build")).arg("--");
    let out = arguments.out.unwrap_or_else(|| shown(&root.join("target/site")));
    command.arg("--repository").arg(root).arg("--out").arg(out);
    command.args(arguments.open.then_some("--open"));
    let status = command.status().map_err(|error| format!("cargo: {error}"))?;
    // The program has said why.
    if status.success() { Ok(true) } else { Err("no site was built".to_owned()) }
}
