//! Compares the program with other libraries. Each library runs in a separate process.

use std::fs;
use std::path::Path;
use std::process::Command;

use super::compile::{Crates, FEATURES};
use super::log::Log;
use super::{cargo, execute};

/// The folder of the inputs and the peers.
const FOLDER: &str = "target/peers";

/// The number of logs, and the size of each in bytes.
const LOGS: usize = 80;
const LOG: usize = 3_200_000;

/// The size of the log whose data the bags contain, in bytes.
const FLIGHT: usize = 160_000_000;

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
        make(folder).map_err(at)?;
        execute(Command::new(&library).arg("make").arg(folder).arg(corpus.join("px4/1.13/msg")))?;
        fs::write(made, "").map_err(at)?;
    }
    let crates = Crates::write()?;
    let mut table = Command::new("python3");
    table.args(["xtask/peers/table.py", FOLDER]).arg(program).arg(library).arg(corpus);
    execute(table.arg(crates.generated).arg(crates.plain).args(FEATURES))
}

/// Creates the logs.
fn make(folder: &Path) -> std::io::Result<()> {
    let logs = folder.join("ulog");
    fs::create_dir_all(&logs)?;
    let sources = Log::of_corpus()?;
    if let Some(source) = sources.last() {
        fs::write(folder.join("flight.ulg"), source.make(FLIGHT, None).0)?;
    }
    for (number, source) in sources.iter().cycle().take(LOGS).enumerate() {
        fs::write(logs.join(format!("{number:02}.ulg")), source.make(LOG, None).0)?;
    }
    Ok(())
}
