//! Tests of the dependencies of all crates.

use std::process::{Command, Stdio};

use serde_json::Value;

/// All packages of the workspace with all features, including dependencies.
fn packages() -> Vec<Value> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--all-features", "--format-version", "1"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stderr(Stdio::inherit())
        .output()
        .expect("cargo runs");
    assert!(output.status.success());
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    metadata["packages"].as_array().expect("a list").clone()
}

/// The parts of a version of Rust, such as `1.88` or `1.88.0`.
fn version(text: &str) -> [u32; 3] {
    let mut parts = text.split('.').map(|part| part.parse().expect("a number"));
    [(); 3].map(|()| parts.next().unwrap_or(0))
}

#[test]
#[ignore = "downloads all dependencies"]
fn no_dependency_requires_a_newer_rust() {
    let packages = packages();
    assert!(packages.len() > 300, "{}", packages.len());
    let required = |package: &Value| package["rust_version"].as_str().map(version);
    let own = packages.iter().find(|package| package["name"] == "uavspec").expect("our crate");
    let minimum = required(own).expect("a minimum version");
    let newer = packages.iter().filter(|package| required(package) > Some(minimum));
    let names: Vec<&Value> = newer.map(|package| &package["id"]).collect();
    assert!(names.is_empty(), "these require a newer Rust than {minimum:?}: {names:?}");
}
