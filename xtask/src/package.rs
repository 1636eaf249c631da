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
use std::process::ExitCode;

use clap::Args;

use self::content::Content;

/// Arguments of `package`.
#[derive(Args)]
#[command(after_help = concat!(
    "Examples:
  cargo xtask package                 target/package/uavspec-….tgz, .whl and .tar.gz
  npm install ./target/package/uavspec-", env!("CARGO_PKG_VERSION"), ".tgz
  pip install target/package/uavspec-", env!("CARGO_PKG_VERSION"), "-py3-none-any.whl

The version is that of the workspace. The packages are made from definitions/, not from generated/."
))]
pub(crate) struct PackageArgs {
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

impl PackageArgs {
    /// Makes the packages and prints what they are.
    pub(crate) fn run(self) -> ExitCode {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let out = self.out.unwrap_or_else(|| root.join("target/package"));
        match make(&root).and_then(|packages| write(&packages, &out)) {
            Ok(summary) => {
                eprintln!("{summary}");
                ExitCode::SUCCESS
            }
            Err(message) => {
                eprintln!("error: {message}");
                ExitCode::from(2)
            }
        }
    }
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
    // Shown as short as it can be.
    let shown = fs::canonicalize(out).unwrap_or_else(|_| out.to_path_buf());
    let here = std::env::current_dir().and_then(fs::canonicalize).unwrap_or_default();
    let shown = shown.strip_prefix(&here).unwrap_or(&shown);
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
        make(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).expect("packages")
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
