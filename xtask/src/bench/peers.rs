//! Compares the program with other libraries. Each library runs in a separate process.

use std::fs;
use std::path::Path;
use std::process::Command;

use super::compile::{Crates, FEATURES};
use super::{cargo, execute};

/// The folder of the inputs and the peers.
const FOLDER: &str = "target/peers";

/// The log from which the bags are made, and the folder of its definitions. Both are in the corpus.
const FLIGHT: [&str; 2] = ["ulog/sample_px4_events.ulg", "px4/1.15/msg"];

/// Creates the inputs, and prints the table.
pub(super) fn run() -> Result<(), String> {
    let program = super::program("")?;
    let peers = Path::new("xtask/peers");
    cargo(peers, &["build", "--release", "--target-dir", "../../target/peers/build"])?;
    let folder = Path::new(FOLDER);
    let library = folder.join("build/release/uavspec-peers");
    let corpus = super::corpus();
    // Written last: after an interruption, the inputs are created again.
    let made = folder.join("made");
    let at = |error: std::io::Error| format!("{FOLDER}: {error}");
    if !made.exists() {
        execute(Command::new(&library).arg("make").arg(folder).args(FLIGHT.map(|path| corpus.join(path))))?;
        fs::write(made, "").map_err(at)?;
    }
    let crates = Crates::write()?;
    let mut table = Command::new("python3");
    table.args(["xtask/peers/table.py", FOLDER]).arg(program).arg(library).arg(corpus);
    execute(table.arg(crates.generated).arg(crates.plain).args(FEATURES))
}
