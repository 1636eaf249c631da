//! Builds the program for a platform, as a static program without paths of this machine.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use crate::command::{cargo, found, output, run};
use crate::platform::{FEATURES, Platform};

/// The crate of the program.
const CRATE: &str = "uavspec";

/// The profile in the workspace's `Cargo.toml`.
const PROFILE: &str = "dist";

/// The folder with an empty libdl, which crates of zenoh link. In musl, libc contains its functions.
const LIBRARIES: &str = "xtask/src/dist/musl";

/// The reason why the program can't be built for a platform, with the missing requirement; none if it can be built.
pub(super) fn obstacle(platform: &Platform) -> Option<String> {
    let Platform { target, machine, debian, .. } = platform;
    let library = output(Command::new("rustc").args(["--print", "target-libdir", "--target", target]));
    if !library.is_ok_and(|folder| Path::new(&folder).exists()) {
        return Some(format!("requires the standard library: rustup target add {target}"));
    }
    if !headers(platform).exists() {
        return Some(format!("requires {}: apt-get install musl-dev:{debian}", headers(platform).display()));
    }
    let compiler = compiler(platform);
    (!found(&compiler))
        .then(|| format!("requires {compiler}: apt-get install gcc-{}-linux-gnu", machine.replace('_', "-")))
}

/// The C compiler for `SQLite`, zstd, mimalloc and ring.
fn compiler(platform: &Platform) -> String {
    format!("{}-linux-gnu-gcc", platform.machine)
}

/// The folder with musl's headers, as in Debian. The compiler's own headers are for glibc.
fn headers(platform: &Platform) -> PathBuf {
    Path::new("/usr/include").join(format!("{}-linux-musl", platform.machine))
}

/// A program that was built.
pub(super) struct Built {
    pub(super) platform: &'static Platform,
    pub(super) path: PathBuf,
}

/// Builds the program for a platform in the folder `target`.
pub(super) fn build(
    root: &Path,
    platform: &'static Platform,
    target: &Path,
    time: u64,
) -> Result<Built, String> {
    eprintln!("dist: building for {}", platform.target);
    fs::create_dir_all(target).map_err(|error| format!("{}: {error}", target.display()))?;
    let mut command = Command::new(cargo());
    command.args(["rustc", "--locked", "--profile", PROFILE, "--package", CRATE, "--bin", "uavspec"]);
    command.args(["--features", FEATURES]);
    command.args(["--target", platform.target]).arg("--target-dir").arg(target).arg("--manifest-path");
    command.arg(root.join("Cargo.toml")).env("SOURCE_DATE_EPOCH", time.to_string());
    command.env("CARGO_ENCODED_RUSTFLAGS", flags(root, target)?);
    let lower = platform.target.replace('-', "_");
    // The linker of the toolchain serves all processors.
    command.env(format!("CARGO_TARGET_{}_LINKER", lower.to_uppercase()), "rust-lld");
    let own = output(Command::new(compiler(platform)).arg("-print-file-name=include"))?;
    command.env(format!("CC_{lower}"), compiler(platform));
    command.env(format!("AR_{lower}"), compiler(platform).replace("gcc", "ar"));
    command.env(
        format!("CFLAGS_{lower}"),
        format!("-nostdinc -isystem {} -isystem {own}", headers(platform).display()),
    );
    // The path is relative, so that it doesn't change the program.
    command.arg("--").arg(format!("-Clink-arg=-L{LIBRARIES}"));
    run(&mut command)?;
    Ok(Built { platform, path: target.join(platform.target).join(PROFILE).join("uavspec") })
}

/// The compiler flags, separated as cargo requires it. They replace the paths in the messages of panics, and pack the
/// relocations, which otherwise take almost a megabyte.
fn flags(root: &Path, target: &Path) -> Result<OsString, String> {
    let home = match env::var_os("CARGO_HOME") {
        Some(home) => PathBuf::from(home),
        None => env::home_dir().ok_or("the home folder is unknown\n  help: set CARGO_HOME")?.join(".cargo"),
    };
    let mut flags = OsString::from("-Clink-arg=--pack-dyn-relocs=relr");
    // The last replacement that matches applies.
    for (path, name) in [(root, "/uavspec"), (target, "/target"), (&home, "/cargo")] {
        let path = fs::canonicalize(path).map_err(|error| format!("{}: {error}", path.display()))?;
        flags.push("\u{1f}--remap-path-prefix=");
        flags.push(path);
        flags.push("=");
        flags.push(name);
    }
    Ok(flags)
}
