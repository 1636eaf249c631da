//! The packages for npm and `PyPI`.
//!
//! All that they hold is made from the definitions anew, in memory: a stale `generated/` can't get into a package. The
//! archives are the same bytes on every run and machine, as times, owners, modes and order are fixed.

mod archive;
mod content;
mod metadata;
mod npm;
mod pypi;

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use self::content::Content;
use crate::place::{repository, shown};

/// Arguments of `package`.
#[derive(Args)]
#[command(after_help = concat!(
    "Examples:
  cargo xtask package                 target/package/uavspec-….tgz, .whl and .tar.gz
  npm install ./target/package/uavspec-", env!("CARGO_PKG_VERSION"), ".tgz
  pip install target/package/uavspec-", env!("CARGO_PKG_VERSION"), "-py3-none-any.whl

The version is that of the workspace. The packages are made from definitions/, not from generated/."
))]
pub(crate) struct Arguments {
    /// Folder for the packages; target/package, where absent.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// An archive.
struct Package {
    file_name: String,
    /// How many files are in it.
    count: usize,
    bytes: Vec<u8>,
}

/// Makes the packages and prints what they are.
pub(crate) fn run(arguments: Arguments) -> Result<bool, String> {
    let out = arguments.out.unwrap_or_else(|| repository().join("target/package"));
    let summary = write(&make(repository())?, &out)?;
    eprintln!("{summary}");
    Ok(true)
}

fn make(root: &Path) -> Result<Vec<Package>, String> {
    let content = Content::of(root)?;
    let mut packages = vec![npm::package(&content)?];
    packages.extend(pypi::packages(&content)?);
    Ok(packages)
}

/// Writes the packages, and says what was written.
fn write(packages: &[Package], out: &Path) -> Result<String, String> {
    fs::create_dir_all(out)
        .map_err(|error| format!("{}: {error}\n  help: --out names another folder", out.display()))?;
    let shown = shown(out);
    let mut lines = Vec::new();
    for package in packages {
        let path = out.join(&package.file_name);
        fs::write(&path, &package.bytes)
            .map_err(|error| format!("{}: {error}\n  help: --out names another folder", path.display()))?;
        lines.push(format!(
            "package: {} ({} files, {} KiB)",
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

    fn made() -> Vec<Package> {
        make(repository()).expect("packages")
    }

    #[test]
    fn packages_are_the_same_bytes_each_time_and_called_as_registries_want_it() {
        let (first, second) = (made(), made());
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
