//! Captures in object stores.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The program to test.
const UAVSPEC: &str = env!("CARGO_BIN_EXE_uavspec");

/// The folder of the servers and of their clients.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/store-peers")
}

fn run(command: &mut Command) {
    let status = command.status().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(status.success(), "{command:?} failed: {status}");
}

/// Runs a script in `tests/engines` with these packages, which are installed in a folder with the name of the script.
fn run_script(name: &str, packages: &[&str], arguments: &[&Path]) {
    let (folder, list) = (folder().join(name), packages.join("\n"));
    let (program, installed) = (folder.join("bin/python"), folder.join("requirements.txt"));
    if fs::read_to_string(&installed).ok().as_ref() != Some(&list) {
        run(Command::new("python3").args(["-m", "venv"]).arg(&folder));
        run(Command::new(&program).args(["-m", "pip", "install", "--quiet"]).args(packages));
        fs::write(installed, list).expect("a file");
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/engines").join(name).with_extension("py");
    run(Command::new(&program).arg(script).args(arguments));
}

#[test]
#[ignore = "installs moto and DuckDB for Python"]
fn faults_of_a_store_lose_nothing() {
    let packages = ["boto3==1.44.8", "duckdb==2.0.1", "moto[server]==5.2.5"];
    run_script("stores", &packages, &[Path::new(UAVSPEC)]);
}

#[test]
#[ignore = "installs Azurite for Node, and a client for Python"]
fn captures_in_azure_are_checked() {
    let azurite = folder().join("node/node_modules/.bin/azurite-blob");
    if !azurite.exists() {
        let mut install = Command::new("npm");
        install.args(["install", "--no-audit", "--no-fund", "--ignore-scripts", "--prefix"]);
        run(install.arg(folder().join("node")).arg("azurite@3.35.0"));
    }
    run_script("azurite", &["azure-storage-blob==12.31.1"], &[Path::new(UAVSPEC), &azurite]);
}
