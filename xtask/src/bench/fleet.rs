//! Thousands of captures, checked by the program, Python, Spark and Ray.

use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;
use std::process::Command;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::execute;
use super::log::{Log, Violation};

/// The captures, and the list of violations.
const FOLDER: &str = "target/fleet";

/// The folders of captures, each with the number of the last capture.
const SETS: [(&str, usize); 3] = [("first", 100), ("second", 1_000), ("third", 10_000)];

/// The smallest and the largest size in MB.
const SIZES: [f64; 2] = [0.1, 50.0];

/// The exponent of the distribution of sizes, for a mean of about 1 MB.
const EXPONENT: f64 = 0.85;

/// Every fourth capture has a violation, and every tenth is compressed.
const VIOLATED: usize = 4;
const COMPRESSED: usize = 10;

/// The programs of the Python environment that the test of the Python package creates.
const PYTHON: &str = "target/python-peers/bin";

/// Creates the captures, and prints the results and times of each engine.
pub(super) fn run() -> Result<(), String> {
    if !Path::new(PYTHON).exists() {
        let help =
            "cargo test -p uavspec -p uavspec-python --all-features --test all -- python:: --include-ignored";
        return Err(format!("{PYTHON} doesn't exist\n  help: run {help}"));
    }
    let program = super::program("stores,tables")?;
    let folder = Path::new(FOLDER);
    if !folder.join("seeds.csv").exists() {
        make(folder).map_err(|error| format!("{FOLDER}: {error}"))?;
    }
    let absolute = |path: &str| fs::canonicalize(path).map_err(|error| format!("{path}: {error}"));
    let programs = absolute(PYTHON)?;
    let mut install = Command::new(programs.join("pip"));
    install.args(["install", "--quiet", "--no-deps", "--force-reinstall", "./conformance/python"]);
    install.env("CARGO_TARGET_DIR", absolute("target")?.join("python-build"));
    execute(&mut install)?;
    let script = "conformance/tests/engines/fleet.py";
    execute(Command::new(programs.join("python")).args([script, FOLDER]).arg(program))
}

/// Creates the captures, with a list of the rules and topics that they violate.
fn make(folder: &Path) -> std::io::Result<()> {
    let logs = Log::of_corpus()?;
    let mut seeds = vec!["capture,source,rule,topic\n".to_owned()];
    let (mut total, mut number) = (0, 0);
    for (set, last) in SETS {
        let set = folder.join("captures").join(set);
        fs::create_dir_all(&set)?;
        while number < last {
            let source = number % logs.len();
            let kind = Violation::ALL[number / VIOLATED / logs.len() % Violation::ALL.len()];
            let violation = Some(kind).filter(|_| number % VIOLATED == 0);
            let (bytes, topic) = logs[source].make(size(number as u64), violation);
            let is_compressed = number % COMPRESSED == 1;
            let path = set.join(format!("{number:05}.ulg{}", if is_compressed { ".gz" } else { "" }));
            if is_compressed {
                let mut encoder = GzEncoder::new(File::create(&path)?, Compression::fast());
                encoder.write_all(&bytes)?;
                encoder.finish()?;
            } else {
                fs::write(&path, &bytes)?;
            }
            let rule = topic.and(violation).map_or("", Violation::rule);
            seeds.push(format!("{},{source},{rule},{}\n", path.display(), topic.unwrap_or_default()));
            total += bytes.len();
            number += 1;
        }
    }
    println!("{number} captures from {} logs, {} MB before compression", logs.len(), total / 1_000_000);
    fs::write(folder.join("seeds.csv"), seeds.concat())
}

/// The pseudorandom size of a capture, in bytes. Few captures are large: the sizes have a Pareto distribution.
#[allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "it is random"
)]
fn size(number: u64) -> usize {
    let uniform = random(number) as f64 / u64::MAX as f64;
    let [max, min] = SIZES.map(|size| size.powf(-EXPONENT));
    ((max - uniform * (max - min)).powf(-1.0 / EXPONENT) * 1e6) as usize
}

/// A pseudorandom number (`SplitMix64`).
const fn random(seed: u64) -> u64 {
    let mut mixed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}
