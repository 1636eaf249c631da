//! Tests of the npm package's launcher, with a shell script in place of the program.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Output};

use super::tools::{run, write};

/// The launcher in the folder of the installed package.
const LAUNCHER: &str = "node_modules/uavspec/bin/uavspec.cjs";

/// Installs the launcher in an empty folder. `cargo xtask package` builds a package without it.
fn install(folder: &Path) {
    let manifest = r#"{ "optionalDependencies": { "@uavspec/linux-x64": "1.0.0" } }"#;
    write(&folder.join("node_modules/uavspec/package.json"), manifest);
    write(&folder.join(LAUNCHER), include_str!("../../src/package/npm/launcher.cjs"));
}

/// Installs a program for the current platform.
fn install_program(folder: &Path, script: &str) {
    let name = run("node", &["-p", "`${process.platform}-${process.arch}`"], folder);
    let path = folder.join("node_modules/@uavspec").join(name.trim()).join("bin/uavspec");
    write(&path, script);
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("the mode");
}

fn launch(folder: &Path, arguments: &[&str]) -> Output {
    Command::new("node").arg(folder.join(LAUNCHER)).args(arguments).output().expect("the launcher runs")
}

#[test]
#[ignore = "requires Node"]
fn the_launcher_passes_arguments_output_and_status() {
    let folder = tempfile::tempdir().expect("a folder");
    install(folder.path());
    let missing = launch(folder.path(), &[]);
    let errors = String::from_utf8_lossy(&missing.stderr);
    assert_eq!(missing.status.code(), Some(2), "{errors}");
    assert!(errors.contains("the package @uavspec/") && errors.contains("help: "), "{errors}");

    install_program(folder.path(), "#!/bin/sh\nprintf '%s\\n' \"$@\"\nexit 6\n");
    let output = launch(folder.path(), &["check", "a b", "--help"]);
    assert_eq!(String::from_utf8_lossy(&output.stdout), "check\na b\n--help\n");
    assert_eq!(output.status.code(), Some(6));
}

#[test]
#[ignore = "requires Node"]
fn the_launcher_waits_for_the_program_after_a_signal() {
    let folder = tempfile::tempdir().expect("a folder");
    install(folder.path());
    // The program interrupts the launcher, handles the forwarded signal, and ends afterwards.
    let script =
        "#!/bin/sh\ntrap 'echo landed; exit 3' TERM\nkill -TERM $PPID\nwhile :; do sleep 0.1; done\n";
    install_program(folder.path(), script);
    let output = launch(folder.path(), &[]);
    assert_eq!(String::from_utf8_lossy(&output.stdout), "landed\n");
    assert_eq!(output.status.code(), Some(3));
}
