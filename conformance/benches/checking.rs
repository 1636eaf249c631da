//! Measures how fast uavspec checks data with all rules, and compares the speed with the speed of other libraries:
//! `cargo bench -p uavspec --bench checking`.
//!
//! Words after `--` select comparisons by title. The environment variable `ROUNDS` sets the number of runs.
//!
//! The contestants take turns. The output shows median throughputs and ratios, so other load on the machine has little
//! effect. Each contestant runs on one core. The comparisons are:
//!
//! - Each fast path against the general path, which uses neither templates for messages nor the cache for status
//!   reports. A fast path is worthwhile only if it is at least 1.3 times as fast as the general path.
//! - `FailsafeFlags` messages as JSON Lines, against two other readers. One reader only skips the values with
//!   `serde_json` (`IgnoredAny`), which is the practical speed limit for `serde_json` users. The other builds a tree
//!   with `serde_json` and validates the tree with the `jsonschema` crate and the published schema.
//! - A fleet's status reports, with one or fifty UAVs each, against the same two readers. `jsonschema` validates only
//!   the bodies.
//! - PX4 logs, if the corpus is available. If pyulog is installed, it reads the same logs. uavspec also checks copies
//!   of a log two at a time, on two cores.

#[path = "../../xtask/peers/src/capture.rs"]
mod capture;

use std::hint::black_box;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};
use std::{fs, io};

use serde::de::IgnoredAny;
use serde_json::{Value, json};
use uavspec_check::{FlockwaveChecker, check_capture, parallel};
use uavspec_rules::definitions::Definitions;

/// The number of JSON lines.
const LINES: usize = 10_000;

/// The default number of runs.
const ROUNDS: usize = 31;

/// The published schema of `FailsafeFlags`.
const SCHEMA: &str = include_str!("../../generated/schemas/px4/FailsafeFlags.schema.json");

/// The schemas of all Flockwave messages.
const SCHEMAS: &str = include_str!("../../generated/schemas/flockwave.bundle.schema.json");

/// The total number of UAV states in a fleet's reports.
const STATES: usize = 30_000;

const LOGS: [&str; 3] = ["sample", "sample_log_small", "sample_logging_tagged_and_default_params"];

/// Reads a log with pyulog several times, and prints the median time in seconds.
const PYULOG: &str = "
import sys, time
from pyulog import ULog
times = []
for _ in range(int(sys.argv[2])):
    start = time.perf_counter()
    ULog(sys.argv[1])
    times.append(time.perf_counter() - start)
print(sorted(times)[len(times) // 2])
";

fn main() {
    json();
    flockwave();
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/corpus");
    let corpus = std::env::var_os("UAVSPEC_CORPUS").map_or(corpus, PathBuf::from);
    if corpus.join("ulog").is_dir() {
        logs(&corpus);
    } else {
        println!("skipped the logs: corpus/ulog is missing; set UAVSPEC_CORPUS to the corpus");
    }
}

/// A measured function.
struct Contestant<'c> {
    name: &'c str,
    work: Box<dyn FnMut() + 'c>,
    times: Vec<Duration>,
}

impl<'c> Contestant<'c> {
    fn new(name: &'c str, work: impl FnMut() + 'c) -> Self {
        Self { name, work: Box::new(work), times: Vec::new() }
    }
}

/// Runs the contestants in turn. Prints each contestant's throughput, and the first contestant's speedup over each
/// other contestant.
fn compare(title: &str, bytes: usize, mut contestants: Vec<Contestant<'_>>) {
    if !is_selected(title) {
        return;
    }
    let rounds = std::env::var("ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(ROUNDS);
    for round in 0..=rounds {
        for contestant in &mut contestants {
            let start = Instant::now();
            (contestant.work)();
            // The first round is a warm-up.
            if round > 0 {
                contestant.times.push(start.elapsed());
            }
        }
    }
    println!("{title}, {bytes} bytes");
    let first = contestants[0].times.clone();
    for (location, contestant) in contestants.iter().enumerate() {
        let throughput = throughput(bytes, median(&contestant.times));
        let ratios: Vec<f64> = first
            .iter()
            .zip(&contestant.times)
            .map(|(first, other)| other.as_secs_f64() / first.as_secs_f64())
            .collect();
        let others = if location == 0 { String::new() } else { ratio(&ratios) };
        println!("  {:<34} {throughput:>8.0} MB/s   {others}", contestant.name);
    }
}

/// True if this title contains a command-line argument, or if there are no arguments.
fn is_selected(title: &str) -> bool {
    let mut words = std::env::args().skip(1).filter(|word| !word.starts_with('-')).peekable();
    words.peek().is_none() || words.any(|word| title.contains(&word))
}

/// The throughput in MB/s.
#[allow(clippy::cast_precision_loss)] // the values are small enough
fn throughput(bytes: usize, time: Duration) -> f64 {
    bytes as f64 / time.as_secs_f64() / 1e6
}

fn median(times: &[Duration]) -> Duration {
    let mut times = times.to_vec();
    times.sort();
    times[times.len() / 2]
}

fn ratio(ratios: &[f64]) -> String {
    let mut ratios = ratios.to_vec();
    ratios.sort_by(f64::total_cmp);
    format!("uavspec has {:.2} times its throughput", ratios[ratios.len() / 2])
}

/// The text that a function writes.
fn text(write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> String {
    let mut bytes = Vec::new();
    write(&mut bytes).expect("memory");
    String::from_utf8(bytes).expect("UTF-8")
}

fn json() {
    let definitions = Definitions::built_in();
    let text = text(|out| capture::write_lines(LINES, out));
    let message_id = definitions.message_of_type("px4/FailsafeFlags");
    let schema: Value = serde_json::from_str(SCHEMA).expect("JSON");
    let validator = jsonschema::validator_for(&schema).expect("a schema");
    let uavspec = || {
        let result = check_capture(text.as_bytes(), message_id, &definitions).expect("memory");
        assert_eq!((result.checked, result.corruption.len()), (LINES as u64, 0));
    };
    let skip = || {
        for line in text.lines() {
            serde_json::from_str::<IgnoredAny>(line).expect("JSON");
        }
    };
    let tree = || {
        for line in text.lines() {
            let message: Value = serde_json::from_str(line).expect("JSON");
            assert!(validator.is_valid(&message));
        }
    };
    let contestants = vec![
        Contestant::new("uavspec", uavspec),
        Contestant::new("serde_json, skipping", skip),
        Contestant::new("serde_json to a tree, jsonschema", tree),
    ];
    compare("JSON Lines of FailsafeFlags", text.len(), contestants);
}

fn flockwave() {
    let definitions = Definitions::built_in();
    let mut schema: Value = serde_json::from_str(SCHEMAS).expect("JSON");
    schema["anyOf"] = json!([{ "$ref": "#/$defs/UAV-INF.notification" }]);
    let validator = jsonschema::validator_for(&schema).expect("a schema");
    for each in [1, 50] {
        let text = text(|out| capture::write_reports(STATES, each, out));
        let lines = (STATES / each) as u64;
        let uavspec = || {
            let result = check_capture(text.as_bytes(), None, &definitions).expect("memory");
            let findings = result.findings.groups().count();
            assert_eq!((result.checked, result.corruption.len(), findings), (lines, 0, 0));
        };
        let thorough = || {
            let mut run_check = FlockwaveChecker::new(&definitions).thorough();
            text.lines().zip(1..).for_each(|(line, number)| run_check.line(line.as_bytes(), number, false));
            assert_eq!(run_check.finish(text.len() as u64).checked, lines);
        };
        let skip = || {
            for line in text.lines() {
                serde_json::from_str::<IgnoredAny>(line).expect("JSON");
            }
        };
        let tree = || {
            for line in text.lines() {
                let line: Value = serde_json::from_str(line).expect("JSON");
                assert!(validator.is_valid(&line["msg"]["body"]));
            }
        };
        let contestants = vec![
            Contestant::new("uavspec", uavspec),
            Contestant::new("uavspec without cached reports", thorough),
            Contestant::new("serde_json, skipping", skip),
            Contestant::new("serde_json to a tree, jsonschema", tree),
        ];
        let uavs = if each == 1 { "one UAV".to_owned() } else { format!("{each} UAVs") };
        compare(&format!("Flockwave reports with {uavs} each"), text.len(), contestants);
    }
}

fn logs(corpus: &Path) {
    let definitions = Definitions::load(&corpus.join("px4/main")).expect("definitions");
    let checked = |bytes: &[u8]| check_capture(bytes, None, &definitions).expect("memory").checked;
    for name in LOGS {
        let path = corpus.join(format!("ulog/{name}.ulg"));
        let bytes = fs::read(&path).expect("a log");
        let uavspec = Contestant::new("uavspec", || _ = black_box(checked(&bytes)));
        compare(&format!("{name}.ulg with the definitions of PX4 main"), bytes.len(), vec![uavspec]);
        match pyulog(&path) {
            Some(time) => println!("  {:<34} {:>8.0} MB/s", "pyulog", throughput(bytes.len(), time)),
            None => println!("  skipped: python3 has no pyulog"),
        }
    }
    // Files of equal length, checked one after the other and two at a time.
    let bytes = fs::read(corpus.join("ulog/sample.ulg")).expect("a log");
    let both = |jobs| {
        let jobs = NonZeroUsize::new(jobs);
        parallel::each(&[0; 8], jobs, |_| checked(&bytes), |_, count| _ = black_box(count));
    };
    let contestants = vec![
        Contestant::new("uavspec, two cores", || both(2)),
        Contestant::new("uavspec, one core", || both(1)),
    ];
    compare("sample.ulg, eight times", 8 * bytes.len(), contestants);
}

/// The time that pyulog takes to read a log.
fn pyulog(path: &Path) -> Option<Duration> {
    let output = Command::new("python3").arg("-c").arg(PYULOG).arg(path).arg("5").output().ok()?;
    let seconds = String::from_utf8_lossy(&output.stdout).trim().parse().ok()?;
    Duration::try_from_secs_f64(seconds).ok()
}
