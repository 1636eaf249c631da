//! How fast sources are judged with all rules on, beside what others do with the same bytes:
//! `cargo bench -p uavspec-conformance --bench checking`.
//!
//! Words behind `--` select comparisons by their titles, and the number `ROUNDS` in the environment sets how often each
//! contestant runs.
//!
//! All that is compared takes turns, and what is shown is the median of the throughputs and of the ratios, so that
//! a machine that is busy now and then changes little. Each runs on one core.
//!
//! - Each shortcut against the way that it shortens: messages without templates, and reports without those that are cached.
//!   One that doesn't buy 1.3 times the throughput has no place here.
//! - JSON Lines of `FailsafeFlags` against `serde_json` passing over the values (`IgnoredAny`), the practical limit
//!   of whoever reads with it, and against `serde_json` to a tree plus the crate `jsonschema` with the published
//!   schema.
//! - Reports of Flockwave on a fleet, with one UAV each and with fifty, against the same two, where the schema is that of
//!   their bodies.
//! - Logs of PX4, where the corpus is, against pyulog, where Python has it; and two at a time on two cores.

use std::fmt::Write as _;
use std::fs;
use std::hint::black_box;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use serde::de::IgnoredAny;
use serde_json::{Value, json};
use uavspec_conformance::check::{FlockwaveChecker, check_capture, check_json_thoroughly, parallel};
use uavspec_conformance::definitions::Definitions;

/// How many lines of JSON there are.
const LINES: usize = 10_000;

/// How often each is measured, by default.
const ROUNDS: usize = 31;

/// The schema that is published.
const SCHEMA: &str = include_str!("../../generated/schemas/px4/FailsafeFlags.schema.json");

/// The schemas of Flockwave, all in one.
const SCHEMAS: &str = include_str!("../../generated/schemas/flockwave.bundle.schema.json");

/// How many UAVs a fleet has.
const FLEET: usize = 1_000;

/// How many states the reports on a fleet have together.
const STATES: usize = 30_000;

const LOGS: [&str; 3] = ["sample", "sample_log_small", "sample_logging_tagged_and_default_params"];

/// Reads a log with pyulog as often as it is asked, and prints the median of the seconds.
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
        println!("left out: corpus/ulog is absent; set UAVSPEC_CORPUS to the corpus");
    }
}

/// Something that is measured.
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

/// Lets all take turns, and prints the throughput of each beside that of the first.
fn compare(what: &str, bytes: usize, mut contestants: Vec<Contestant<'_>>) {
    if !is_selected(what) {
        return;
    }
    let rounds = std::env::var("ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(ROUNDS);
    for round in 0..=rounds {
        for contestant in &mut contestants {
            let start = Instant::now();
            (contestant.work)();
            // The first round warms up.
            if round > 0 {
                contestant.times.push(start.elapsed());
            }
        }
    }
    println!("{what}, {bytes} bytes");
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

/// True if the command line names no comparison, or a word of this one's title.
fn is_selected(what: &str) -> bool {
    let mut words = std::env::args().skip(1).filter(|word| !word.starts_with('-')).peekable();
    words.peek().is_none() || words.any(|word| what.contains(&word))
}

/// In MB/s.
#[allow(clippy::cast_precision_loss)] // nobody measures so many bytes
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

/// Messages that conform, each a line.
fn lines(definitions: &Definitions) -> String {
    let of = definitions.types().find("px4", "FailsafeFlags").expect("a built-in message");
    let zero = of.default().to_json().expect("finite values");
    let mut text = String::new();
    for number in 0..LINES {
        let mut message = zero.clone();
        message["timestamp"] = (1_000_000 + 20_000 * number).into();
        message["geofence_breached"] = (number % 3 == 0).into();
        writeln!(text, "{message}").expect("a string");
    }
    text
}

fn json() {
    let definitions = Definitions::built_in();
    let text = lines(&definitions);
    let of = definitions.message_of_type("px4/FailsafeFlags");
    let schema: Value = serde_json::from_str(SCHEMA).expect("JSON");
    let validator = jsonschema::validator_for(&schema).expect("a schema");
    let uavspec = || {
        let result = check_capture(text.as_bytes(), of, &definitions).expect("memory");
        assert_eq!((result.checked, result.corruption.len()), (LINES as u64, 0));
    };
    let thorough = || {
        let result = check_json_thoroughly(text.as_bytes(), of, &definitions);
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
        Contestant::new("uavspec without templates", thorough),
        Contestant::new("serde_json, skipping", skip),
        Contestant::new("serde_json to a tree, jsonschema", tree),
    ];
    compare("JSON Lines of FailsafeFlags", text.len(), contestants);
}

/// A recording of reports on a fleet, each on so many UAVs, that conforms.
fn reports(each: usize) -> String {
    let mut text = String::new();
    for (number, first) in (0..STATES).step_by(each).enumerate() {
        let time = 1_790_000_000_000 + first / 5;
        let states = (first..first + each).map(|at| {
            let uav = format!("glider-{:03}", at % FLEET);
            #[allow(clippy::cast_possible_wrap)] // it is small
            let value = (at * 7_919 % 100_000) as i64;
            let state = json!({
                "id": uav, "timestamp": time, "mode": "mission", "heading": value % 3_600,
                "position": [465_410_000 + value, 115_520_000 - value, 812_000 + value, value % 900],
                "velocity": [value % 900, 400 - value % 800, -(value % 90)], "gps": [4, 8 + value % 12],
                "battery": [110 + value % 16, value % 101], "light": value % 65_536, "rssi": [value % 101],
                "errors": [], "debug": "",
            });
            (uav, state)
        });
        let body = json!({ "type": "UAV-INF", "status": states.collect::<serde_json::Map<_, _>>() });
        let message = json!({ "$fw.version": "1.0", "id": format!("say-{number}"), "body": body });
        #[allow(clippy::cast_precision_loss)] // times fit well
        let time = time as f64 / 1e3;
        let line = json!({ "t": time, "conn": "tcp#1", "dir": "in", "msg": message });
        writeln!(text, "{line}").expect("a string");
    }
    text
}

fn flockwave() {
    let definitions = Definitions::built_in();
    let mut schema: Value = serde_json::from_str(SCHEMAS).expect("JSON");
    schema["anyOf"] = json!([{ "$ref": "#/$defs/UAV-INF.notification" }]);
    let validator = jsonschema::validator_for(&schema).expect("a schema");
    for each in [1, 50] {
        let text = reports(each);
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
        let of = if each == 1 { "one UAV".to_owned() } else { format!("{each} UAVs") };
        compare(&format!("Reports of Flockwave on {of} each"), text.len(), contestants);
    }
}

fn logs(corpus: &Path) {
    let definitions = Definitions::load(&corpus.join("px4/main")).expect("definitions");
    let checked = |bytes: &[u8]| check_capture(bytes, None, &definitions).expect("memory").checked;
    for name in LOGS {
        let path = corpus.join(format!("ulog/{name}.ulg"));
        let bytes = fs::read(&path).expect("a log");
        let uavspec = Contestant::new("uavspec", || _ = black_box(checked(&bytes)));
        compare(&format!("{name}.ulg by the definitions of PX4 main"), bytes.len(), vec![uavspec]);
        match pyulog(&path) {
            Some(time) => println!("  {:<34} {:>8.0} MB/s", "pyulog", throughput(bytes.len(), time)),
            None => println!("  left out: python3 has no pyulog"),
        }
    }
    // As two files of the same length: one after the other, and at the same time.
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

/// The time that pyulog takes for a log.
fn pyulog(path: &Path) -> Option<Duration> {
    let output = Command::new("python3").arg("-c").arg(PYULOG).arg(path).arg("5").output().ok()?;
    let seconds = String::from_utf8_lossy(&output.stdout).trim().parse().ok()?;
    Duration::try_from_secs_f64(seconds).ok()
}
