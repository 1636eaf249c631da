//! Builds the packages for npm.
//!
//! The content is generated from the definitions in memory, so that a stale `generated/` doesn't affect packages.
//! The times, owners, modes and order of files are fixed, so that archives are reproducible on all machines.

mod content;
mod npm;

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use self::content::Content;
use crate::archive::File;
use crate::paths::{repository, shown};
use crate::platform::{Platform, Program};

/// Arguments of `package`.
#[derive(Args)]
#[command(after_help = concat!(
    "Examples:
  cargo xtask package
  npm install ./target/package/uavspec-types-", env!("CARGO_PKG_VERSION"), ".tgz

The package has the workspace version and is built from definitions/. For Python, run `pip install ./conformance/python`."
))]
pub(crate) struct Arguments {
    /// Folder for the package [default: target/package]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Builds the package of the types and prints a summary.
pub(crate) fn run(arguments: Arguments) -> Result<bool, String> {
    let out = arguments.out.unwrap_or_else(|| repository().join("target/package"));
    eprintln!("{}", write("package", &[types()?], &out)?);
    Ok(true)
}

/// Builds the package of the types.
fn types() -> Result<File, String> {
    npm::types(&Content::of(repository())?)
}

/// Builds the packages that don't contain a program. `platforms` are the platforms for which a package contains the
/// program.
pub(crate) fn for_all_platforms(platforms: &[&Platform]) -> Result<Vec<File>, String> {
    Ok(vec![types()?, npm::launcher(platforms)?])
}

/// Builds the package with a program.
pub(crate) fn for_platform(program: &Program) -> Result<File, String> {
    npm::program(program)
}

/// The licences of the project.
pub(crate) fn licences() -> Vec<File> {
    vec![
        File::new("LICENSE-APACHE", include_str!("../../LICENSE-APACHE")),
        File::new("LICENSE-MIT", include_str!("../../LICENSE-MIT")),
    ]
}

/// Writes the packages, and returns a summary with the name of the command.
pub(crate) fn write(command: &str, packages: &[File], out: &Path) -> Result<String, String> {
    fs::create_dir_all(out)
        .map_err(|error| format!("{}: {error}\n  help: choose another folder with --out", out.display()))?;
    let shown = shown(out);
    let mut lines = Vec::new();
    for package in packages {
        let path = out.join(&package.path);
        fs::write(&path, &package.bytes).map_err(|error| {
            format!("{}: {error}\n  help: choose another folder with --out", path.display())
        })?;
        lines.push(format!(
            "{command}: {} ({} KiB)",
            shown.join(&package.path).display(),
            package.bytes.len().div_ceil(1024)
        ));
    }
    Ok(lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_are_reproducible_and_have_valid_file_names() {
        let [first, second] = [types(), types()].map(|package| package.expect("a package"));
        assert!(first.bytes == second.bytes);
        assert_eq!(first.path, format!("uavspec-types-{}.tgz", env!("CARGO_PKG_VERSION")));
    }
}
