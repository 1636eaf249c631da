//! Captures in an object store that fails.

use std::fs::{self, File};
use std::path::Path;
use std::process::Command;

#[test]
#[ignore = "installs moto and DuckDB for Python"]
fn faults_of_a_store_lose_nothing() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = root.join("../target/store-peers");
    let program = folder.join("bin/python");
    let run = |command: &mut Command| {
        let status = command.status().unwrap_or_else(|error| panic!("{command:?}: {error}"));
        assert!(status.success(), "{command:?} failed: {status}");
    };
    if !folder.join("installed").exists() {
        fs::create_dir_all(&folder).expect("a folder");
        run(Command::new("python3").args(["-m", "venv"]).arg(&folder));
        let packages = ["boto3==1.44.8", "duckdb==2.0.1", "moto[server]==5.2.5"];
        run(Command::new(&program).args(["-m", "pip", "install", "--quiet"]).args(packages));
        File::create(folder.join("installed")).expect("a file");
    }
    run(Command::new(&program).arg(root.join("tests/engines/stores.py")).arg(env!("CARGO_BIN_EXE_uavspec")));
}
