//! Builds the documentation site from generated and hand-written pages.

use std::path::PathBuf;
use std::process::Command;

use clap::Args;

use crate::command::cargo;
use crate::message_of;
use crate::paths::{repository, shown};

/// Arguments of `docs`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Open the site in a browser
    #[arg(long)]
    open: bool,
    /// Folder for the site [default: target/site]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Generates all output and runs the program that builds the site. That program is separate because mdBook takes a
/// minute to compile.
pub(crate) fn run(arguments: Arguments) -> Result<bool, String> {
    let root = repository();
    uavspec_codegen::generate(root.join("definitions/uavspec.toml"))
        .map_err(|failure| message_of(&failure))?;
    let mut command = Command::new(cargo());
    command.args(["run", "--quiet", "--locked", "--manifest-path"]).arg(root.join("xtask/site/Cargo.toml"));
    command.arg("--target-dir").arg(root.join("target/site-build")).arg("--");
    let out = arguments.out.unwrap_or_else(|| shown(&root.join("target/site")));
    command.arg("--repository").arg(root).arg("--out").arg(out);
    command.args(arguments.open.then_some("--open"));
    let status = command.status().map_err(|error| format!("cannot run cargo: {error}"))?;
    // The program has printed the reason.
    if status.success() { Ok(true) } else { Err("the site could not be built".to_owned()) }
}
