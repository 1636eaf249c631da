//! How fast logs are judged with all rules on: `cargo bench -p uavspec-conformance --bench check`. Needs the corpus.

use std::fs;
use std::path::{Path, PathBuf};

use divan::Bencher;
use divan::counter::BytesCount;
use uavspec_conformance::definitions::Definitions;
use uavspec_conformance::judge::judge_ulog;

const LOGS: [&str; 3] = ["sample", "sample_log_small", "sample_logging_tagged_and_default_params"];

fn main() {
    if !corpus().join("ulog").is_dir() {
        eprintln!("left out: corpus/ulog is absent; set UAVSPEC_CORPUS to the corpus");
        return;
    }
    divan::main();
}

fn corpus() -> PathBuf {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/corpus");
    std::env::var_os("UAVSPEC_CORPUS").map_or(default, PathBuf::from)
}

/// A log by the definitions of PX4 main, which restrict most.
#[divan::bench(args = LOGS, max_time = 3)]
fn judge(bencher: Bencher<'_, '_>, log: &str) {
    let bytes = fs::read(corpus().join("ulog").join(format!("{log}.ulg"))).expect("a log");
    let definitions = Definitions::load(&corpus().join("px4/main")).expect("definitions");
    bencher
        .counter(BytesCount::new(bytes.len()))
        .bench_local(|| judge_ulog(&bytes[..], &definitions).expect("bytes can be read").judged);
}

/// The definitions that a run starts with.
#[divan::bench(max_time = 2)]
fn load_definitions() -> Definitions {
    Definitions::load(&corpus().join("px4/main")).expect("definitions")
}
