//! Tests of the Python package, run in Python.

use std::fs;
use std::path::Path;
use std::process::Command;

use uavspec_test_support::cargo;
use uavspec_test_support::python::{python, run};
use walkdir::WalkDir;

/// The packages that the tests use.
const PACKAGES: &[&str] = &[
    "duckdb==2.0.1",
    "mypy==2.4.1",
    "numpy==2.4.6",
    "pandas==2.3.3",
    "polars==2.1.0",
    "psutil==7.2.2",
    "pyarrow==26.0.1",
    "pyright==1.1.414",
    "pyspark==4.3.0",
    "pytest==9.2.0",
    "pyulog==1.3.0",
    "ray[data]==2.60.0",
];

/// Builds the module, and copies the package to the folder of installed packages.
fn install(python: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    // The module must share the library that these tests use. Therefore, the features of its dependencies must be the
    // same, including those that only tests require.
    let packages = ["--package", "uavspec", "--package", "uavspec-python"];
    let mut build = cargo();
    build.args(["build", "--quiet", "--all-features", "--lib", "--test", "all"]).args(packages);
    run(build.current_dir(root));
    let output = Command::new(python)
        .args(["-c", "import sysconfig; print(sysconfig.get_path('purelib'))"])
        .output()
        .expect("Python");
    let installed = Path::new(String::from_utf8_lossy(&output.stdout).trim_end()).join("uavspec");
    // The files of an earlier run must not be used.
    let _ = fs::remove_dir_all(&installed);
    let source = root.join("python/python/uavspec");
    for entry in WalkDir::new(&source).follow_links(true) {
        let entry = entry.expect("an entry");
        let target = installed.join(entry.path().strip_prefix(&source).expect("below"));
        if entry.file_type().is_dir() {
            fs::create_dir_all(target).expect("a folder");
        } else {
            fs::copy(entry.path(), target).expect("a file");
        }
    }
    let module = Path::new(env!("CARGO_BIN_EXE_uavspec")).with_file_name("lib_native.so");
    fs::copy(module, installed.join("_native.abi3.so")).expect("the module");
}

#[test]
#[ignore = "compiles the Python package and installs other ones"]
fn the_package_works_in_python() {
    let (python, package) =
        (python("python-peers", PACKAGES), Path::new(env!("CARGO_MANIFEST_DIR")).join("python"));
    install(&python);
    run(Command::new(&python)
        .args(["-m", "pytest", "--quiet", "tests"])
        .env("UAVSPEC", env!("CARGO_BIN_EXE_uavspec"))
        .current_dir(&package));
    run(Command::new(python.with_file_name("mypy"))
        .args(["--strict", "python/uavspec"])
        .current_dir(&package));
    let pyright = Command::new(python.with_file_name("pyright"))
        .arg("--pythonpath")
        .arg(&python)
        .arg("python/uavspec")
        .current_dir(&package)
        .output()
        .expect("pyright");
    assert!(pyright.status.success(), "{}", String::from_utf8_lossy(&pyright.stdout));
}
