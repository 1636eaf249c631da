//! Builds Debian packages with cargo-deb, which `conformance/Cargo.toml` configures.

use std::process::Command;

use super::VERSION;
use super::build::{self, Built, PROFILE};
use crate::archive::File;
use crate::command::cargo;
use crate::platform::Platform;

/// Builds the package of a program with its documents.
pub(super) fn package(built: &Built, time: u64) -> Result<File, String> {
    let path = build::folder().join(file_name(built.platform));
    let mut command = Command::new(cargo());
    command.args(["deb", "--package", "uavspec", "--no-build", "--no-strip", "--profile", PROFILE]);
    command.args(["--target", built.platform.target, "--output"]).arg(&path);
    build::run_with(&mut command, time)?;
    File::read(&path)
}

/// The name of the package's file. Debian sorts `1.0~rc.1` before `1.0`.
pub(super) fn file_name(platform: &Platform) -> String {
    format!("uavspec_{}-1_{}.deb", VERSION.replace('-', "~"), platform.debian)
}
