//! Tests of captures in object stores.

use std::path::Path;
use std::process::Command;

use uavspec_test_support::python::{python, run};

/// The program to test.
const UAVSPEC: &str = env!("CARGO_BIN_EXE_uavspec");

/// Runs a script in `tests/engines` with these packages.
fn run_script(name: &str, packages: &[&str], arguments: &[&Path]) {
    let program = python(&format!("store-peers/{name}"), packages);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/engines").join(name).with_extension("py");
    run(Command::new(program).arg(script).args(arguments));
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
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/store-peers/node");
    let azurite = folder.join("node_modules/.bin/azurite-blob");
    if !azurite.exists() {
        let mut install = Command::new("npm");
        install.args(["install", "--no-audit", "--no-fund", "--ignore-scripts", "--prefix"]);
        run(install.arg(folder).arg("azurite@3.35.0"));
    }
    run_script("azurite", &["azure-storage-blob==12.31.1"], &[Path::new(UAVSPEC), &azurite]);
}
