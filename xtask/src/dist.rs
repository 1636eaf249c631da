//! Builds the program for all platforms, and the archives and packages that contain it.
//!
//! The programs contain no paths of this machine, and all files in archives have the time of the commit. The same
//! commit and toolchain therefore produce the same bytes.

mod build;
mod debian;
mod documents;
mod notices;
mod test;
#[cfg(test)]
mod tests;

use std::env;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::slice;

use clap::Args;
use clap::builder::PossibleValuesParser;
use sha2::{Digest as _, Sha256};

use self::build::Built;
use crate::archive::{File, tar_gz};
use crate::command;
use crate::package::{self, licences};
use crate::paths::repository;
use crate::platform::{NATIVE, PLATFORMS, Platform, Program};

/// The version of the workspace.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The script that installs the program from an archive.
const INSTALLER: &str = include_str!("dist/install.sh");

/// The file with the checksums of all archives.
const CHECKSUMS: &str = "SHA256SUMS";

/// Arguments of `dist`.
#[derive(Args)]
#[command(after_help = "Examples:
  cargo xtask dist
  cargo xtask dist --target aarch64-unknown-linux-musl
  cargo xtask dist --test    install the packages in empty Debian systems, and run the program

On macOS and Windows, builds only the archive for this machine, and requires only Rust and a C compiler.

On Linux, requires maturin, cargo-zigbuild and cargo-deb, and the standard library for each target. Targets without it \
are skipped, unless --target names them. --test requires root privileges, debootstrap, npm, and qemu-user-static for other \
processors.")]
pub(crate) struct Arguments {
    /// Target to build for (repeatable) [default: all that can be built here]
    #[arg(long, value_name = "TARGET", value_parser = PossibleValuesParser::new(PLATFORMS.iter().map(|it| it.target)))]
    target: Vec<String>,
    /// Folder for the archives and packages [default: target/dist]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Also install and run each package in an empty system
    #[arg(long)]
    test: bool,
}

/// Builds the archives and packages, and prints a summary. Returns false if a package fails its test.
pub(crate) fn run(arguments: Arguments) -> Result<bool, String> {
    let root = repository();
    let out = arguments.out.unwrap_or_else(|| root.join("target/dist"));
    if !cfg!(target_os = "linux") && arguments.target.is_empty() && !arguments.test {
        return native(root, &out);
    }
    build::check_tools()?;
    let platforms = platforms(&arguments.target)?;
    let time = time(root)?;
    let programs = platforms.iter().map(|platform| build::program(platform, time));
    let programs: Vec<Built> = programs.collect::<Result<_, _>>()?;
    let documents = build::folder().join("documents");
    documents::write(root, &programs, &documents)?;
    let mut packages = package::for_all_platforms(&platforms)?;
    packages.extend(build::source_distribution(time)?);
    for built in programs {
        let platform = built.platform;
        let third_party = notices::third_party(root, platform.target)?;
        third_party.iter().try_for_each(|file| file.write(&documents))?;
        packages.extend(build::wheels(&built, &third_party, time)?);
        let program = Program { platform, bytes: File::read(&built.path)?.bytes, third_party };
        packages.push(archive(&program, &documents, time)?);
        packages.push(debian::package(&built, time)?);
        packages.push(package::for_platform(&program)?);
    }
    packages.push(File::new("install.sh", INSTALLER));
    packages.push(checksums(&packages));
    eprintln!("{}", package::write("dist", &packages, &out)?);
    if arguments.test { test::run(&out, &platforms) } else { Ok(true) }
}

/// Builds the archive for this machine, which runs macOS or Windows.
fn native(root: &Path, out: &Path) -> Result<bool, String> {
    let time = time(root)?;
    let built = build::native(&NATIVE, time)?;
    let documents = build::folder().join("documents");
    documents::write(root, slice::from_ref(&built), &documents)?;
    let third_party = notices::third_party(root, NATIVE.target)?;
    let program = Program { platform: &NATIVE, bytes: File::read(&built.path)?.bytes, third_party };
    let archive = archive(&program, &documents, time)?;
    let packages = [checksums(slice::from_ref(&archive)), archive];
    eprintln!("{}", package::write("dist", &packages, out)?);
    Ok(true)
}

/// The platforms with these targets. Without targets, all platforms for which this machine can build.
fn platforms(targets: &[String]) -> Result<Vec<&'static Platform>, String> {
    let mut platforms = Vec::new();
    for platform in &PLATFORMS {
        let is_named = targets.iter().any(|target| target == platform.target);
        if !is_named && !targets.is_empty() {
            continue;
        }
        match build::obstacle(platform) {
            None => platforms.push(platform),
            Some(obstacle) if is_named => return Err(format!("{}: {obstacle}", platform.target)),
            Some(obstacle) => eprintln!("dist: skipped {}: {obstacle}", platform.target),
        }
    }
    if platforms.is_empty() {
        return Err("no target can be built on this machine".to_owned());
    }
    if targets.is_empty() {
        eprintln!("dist: skipped Windows and macOS: run `cargo xtask dist` there");
    }
    Ok(platforms)
}

/// The time of the commit in seconds since 1970, or the value of `SOURCE_DATE_EPOCH`.
fn time(root: &Path) -> Result<u64, String> {
    let (text, origin) = if let Ok(text) = env::var("SOURCE_DATE_EPOCH") {
        (text, "SOURCE_DATE_EPOCH")
    } else {
        let mut git = Command::new("git");
        git.arg("-C").arg(root).args(["log", "-1", "--format=%ct"]);
        let text = command::output(&mut git).map_err(|error| {
            format!("the time of the commit is unknown: {error}\n  help: set SOURCE_DATE_EPOCH")
        })?;
        (text, "git")
    };
    text.parse().map_err(|_| format!("{origin}: expected seconds since 1970, found {text:?}"))
}

/// The archive with the program and the documents in a folder.
fn archive(program: &Program, documents: &Path, time: u64) -> Result<File, String> {
    let folder = format!("uavspec-{VERSION}-{}", program.platform.target);
    let mut files = [licences(), program.third_party.clone()].concat();
    files.push(program.file(program.platform.program()));
    files.push(File::new("README.md", include_str!("dist/README.md")));
    files.push(File::new("CHANGELOG.md", include_str!("../../CHANGELOG.md")));
    for part in ["completions", "man/man1"] {
        files.extend(File::read_all(&documents.join(part))?.iter().map(|file| file.below(part)));
    }
    files.sort_by(|left, right| left.path.cmp(&right.path));
    let files: Vec<File> = files.iter().map(|file| file.below(&folder)).collect();
    Ok(File::binary(format!("{folder}.tar.gz"), tar_gz(&files, time)?))
}

/// The checksums in the format of `sha256sum`.
fn checksums(packages: &[File]) -> File {
    let mut text = String::new();
    for package in packages {
        let checksum = data_encoding::HEXLOWER.encode(&Sha256::digest(&package.bytes));
        let _ = writeln!(text, "{checksum}  {}", package.path);
    }
    File::new(CHECKSUMS, &text)
}
