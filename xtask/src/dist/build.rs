//! Builds the program and the Python package without paths of this machine. zig compiles the C code and links, so one
//! machine builds for all platforms, and for older systems than its own.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, io};

use crate::archive::File;
use crate::command::{cargo, found, output, run};
use crate::paths::repository;
use crate::platform::{FEATURES, Platform};

/// The profile in the workspace's `Cargo.toml`.
pub(super) const PROFILE: &str = "dist";

/// The programs that this task runs, and the commands that install them.
const TOOLS: [[&str; 2]; 3] = [
    ["cargo-deb", "cargo install --locked cargo-deb"],
    ["cargo-zigbuild", "pip install cargo-zigbuild"],
    ["maturin", "pip install maturin"],
];

/// The folder of the Python package, in the repository.
const PYTHON: &str = "conformance/python";

/// The subfolder of the package from which maturin adds the program to a wheel.
const DATA: &str = "uavspec._native.data";

/// The C libraries for which wheels are built, each with the oldest systems that support the wheel. A Python module
/// can't be static.
const LIBRARIES: [[&str; 2]; 2] = [["gnu", "manylinux2014"], ["musl", "musllinux_1_2"]];

/// Fails if this machine doesn't meet a requirement. The error describes the requirement.
pub(super) fn check_tools() -> Result<(), String> {
    match TOOLS.iter().find(|[tool, _]| !found(tool)) {
        Some([tool, help]) => Err(format!("{tool} is not installed\n  help: {help}")),
        None => Ok(()),
    }
}

/// The reason why programs can't be built for a platform, with the missing requirement. `None` if they can be built.
pub(super) fn obstacle(platform: &Platform) -> Option<String> {
    let target = LIBRARIES.iter().map(|[library, _]| platform.module_target(library)).find(|target| {
        let library = output(Command::new("rustc").args(["--print", "target-libdir", "--target", target]));
        !library.is_ok_and(|folder| Path::new(&folder).exists())
    })?;
    Some(format!("requires the standard library: rustup target add {target}"))
}

/// A program that was built.
pub(super) struct Built {
    pub(super) platform: &'static Platform,
    pub(super) path: PathBuf,
}

/// The folder of the compiled code.
pub(super) fn folder() -> PathBuf {
    repository().join("target/dist-build")
}

/// Builds the program for a platform.
pub(super) fn program(platform: &'static Platform, time: u64) -> Result<Built, String> {
    eprintln!("dist: building for {}", platform.target);
    let mut command = Command::new("cargo-zigbuild");
    command.args(["rustc", "--locked", "--profile", PROFILE, "--package", "uavspec", "--bin", "uavspec"]);
    command.args(["--features", FEATURES, "--target", platform.target]);
    // Without this option, zig links the program at a fixed address.
    run_with(command.args(["--", "-Clink-arg=-pie"]), time)?;
    Ok(Built { platform, path: folder().join(platform.target).join(PROFILE).join("uavspec") })
}

/// Builds the program with the linker of this machine.
pub(super) fn native(platform: &'static Platform, time: u64) -> Result<Built, String> {
    let mut command = Command::new(cargo());
    command.args(["build", "--locked", "--profile", PROFILE, "--package", "uavspec", "--bin", "uavspec"]);
    run_with(command.args(["--features", FEATURES, "--target", platform.target]), time)?;
    Ok(Built { platform, path: folder().join(platform.target).join(PROFILE).join(platform.program()) })
}

/// Builds the source distribution of the Python package.
pub(super) fn source_distribution(time: u64) -> Result<Vec<File>, String> {
    maturin(&["sdist"], time)
}

/// Builds the wheels with a program, the Python module and the types. The wheels contain the licences `third_party`.
pub(super) fn wheels(built: &Built, third_party: &[File], time: u64) -> Result<Vec<File>, String> {
    let package = repository().join(PYTHON);
    let scripts = package.join(DATA).join("scripts");
    let failed = |error: io::Error| format!("{}: {error}", scripts.display());
    fs::create_dir_all(&scripts).map_err(failed)?;
    fs::copy(&built.path, scripts.join("uavspec")).map_err(failed)?;
    third_party.iter().try_for_each(|file| file.write(&package))?;
    let of_library = |[library, system]: &[&str; 2]| {
        let target = built.platform.module_target(library);
        eprintln!("dist: building the Python module for {target}");
        let options = ["build", "--locked", "--zig", "--profile", PROFILE, "--target", &target];
        maturin(&[&options[..], &["--compatibility", *system]].concat(), time)
    };
    let wheels: Result<Vec<Vec<File>>, String> = LIBRARIES.iter().map(of_library).collect();
    // Remove the copied files, because an installation from this checkout must not contain them.
    let mut removed = third_party.iter().map(|file| fs::remove_file(package.join(&file.path)));
    removed.try_for_each(|it| it).and_then(|()| fs::remove_dir_all(package.join(DATA))).map_err(failed)?;
    Ok(wheels?.concat())
}

/// Runs maturin, and returns the packages that it wrote.
fn maturin(arguments: &[&str], time: u64) -> Result<Vec<File>, String> {
    let out = folder().join("python");
    if out.exists() {
        fs::remove_dir_all(&out).map_err(|error| format!("{}: {error}", out.display()))?;
    }
    let mut command = Command::new("maturin");
    command.args(arguments).args(["--manifest-path", &format!("{PYTHON}/Cargo.toml")]);
    run_with(command.arg("--out").arg(&out), time)?;
    File::read_all(&out)
}

/// Runs a tool in the repository. The compiled code depends on nothing else on this machine. Compiler flags replace the
/// paths in panic messages.
pub(super) fn run_with(command: &mut Command, time: u64) -> Result<(), String> {
    let home = match env::var_os("CARGO_HOME") {
        Some(home) => PathBuf::from(home),
        None => env::home_dir().ok_or("the home folder is unknown\n  help: set CARGO_HOME")?.join(".cargo"),
    };
    let target = folder();
    fs::create_dir_all(&target).map_err(|error| format!("{}: {error}", target.display()))?;
    let mut flags = Vec::new();
    // The order matters, because the last matching replacement applies.
    for (path, name) in [(repository(), "/uavspec"), (&*target, "/target"), (&*home, "/cargo")] {
        let path = fs::canonicalize(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let mut flag = OsString::from("--remap-path-prefix=");
        flag.push(path);
        flag.push(format!("={name}"));
        flags.push(flag);
    }
    if cfg!(windows) {
        // Link the C runtime statically, because it is a separate download.
        flags.push("-Ctarget-feature=+crt-static".into());
    }
    command.current_dir(repository()).env("CARGO_TARGET_DIR", target);
    command.env("CARGO_ENCODED_RUSTFLAGS", flags.join(OsStr::new("\u{1f}")));
    run(command.env("SOURCE_DATE_EPOCH", time.to_string()))
}
