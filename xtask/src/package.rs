//! Builds the packages for npm and `PyPI`.
//!
//! The content is generated from the definitions in memory, so that a stale `generated/` doesn't affect packages.
//! The times, owners, modes and order of files are fixed, so that archives are reproducible on all machines.

mod content;
mod metadata;
mod npm;
mod pypi;

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

pub(crate) use self::content::{Content, licences};
use crate::paths::{repository, shown};
use crate::platform::{Platform, Program};

/// Arguments of `package`.
#[derive(Args)]
#[command(after_help = concat!(
    "Examples:
  cargo xtask package
  npm install ./target/package/uavspec-", env!("CARGO_PKG_VERSION"), ".tgz
  pip install target/package/uavspec-", env!("CARGO_PKG_VERSION"), "-py3-none-any.whl

The packages have the workspace version and are built from definitions/."
))]
pub(crate) struct Arguments {
    /// Folder for the packages [default: target/package]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// An archive.
pub(crate) struct Package {
    pub(crate) file_name: String,
    /// The number of files.
    pub(crate) count: usize,
    pub(crate) bytes: Vec<u8>,
}

/// Builds the packages and prints a summary.
pub(crate) fn run(arguments: Arguments) -> Result<bool, String> {
    let out = arguments.out.unwrap_or_else(|| repository().join("target/package"));
    let summary = write("package", &for_all_platforms(&Content::of(repository())?, &[])?, &out)?;
    eprintln!("{summary}");
    Ok(true)
}

/// Builds the packages without programs. `platforms` are the platforms with a package that contains the program.
pub(crate) fn for_all_platforms(content: &Content, platforms: &[&Platform]) -> Result<Vec<Package>, String> {
    let mut packages = vec![npm::package(content, platforms)?];
    packages.extend(pypi::packages(content)?);
    Ok(packages)
}

/// Builds the packages with a program.
pub(crate) fn for_platform(content: &Content, program: &Program) -> Result<[Package; 2], String> {
    Ok([npm::platform_package(program)?, pypi::platform_wheel(content, program)?])
}

/// Writes the packages, and returns a summary with the name of the command.
pub(crate) fn write(command: &str, packages: &[Package], out: &Path) -> Result<String, String> {
    fs::create_dir_all(out)
        .map_err(|error| format!("{}: {error}\n  help: choose another folder with --out", out.display()))?;
    let shown = shown(out);
    let mut lines = Vec::new();
    for package in packages {
        let path = out.join(&package.file_name);
        fs::write(&path, &package.bytes).map_err(|error| {
            format!("{}: {error}\n  help: choose another folder with --out", path.display())
        })?;
        lines.push(format!(
            "{command}: {} ({} files, {} KiB)",
            shown.join(&package.file_name).display(),
            package.count,
            package.bytes.len().div_ceil(1024)
        ));
    }
    Ok(lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packages() -> Vec<Package> {
        for_all_platforms(&Content::of(repository()).expect("the content"), &[]).expect("packages")
    }

    #[test]
    fn packages_are_reproducible_and_have_valid_file_names() {
        let (first, second) = (packages(), packages());
        for (first, second) in first.iter().zip(second) {
            assert!(first.bytes == second.bytes, "{}", first.file_name);
        }
        let version = metadata::VERSION;
        let names: Vec<String> = first.into_iter().map(|package| package.file_name).collect();
        assert_eq!(
            names,
            [
                format!("uavspec-{version}.tgz"),
                format!("uavspec-{version}-py3-none-any.whl"),
                format!("uavspec-{version}.tar.gz")
            ]
        );
    }
}
