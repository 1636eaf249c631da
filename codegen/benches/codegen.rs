//! Benchmarks for reading all 261 PX4 messages and generating code from them. Benchmarks are repeated with 4 and 16
//! times as many messages to show how the run time scales.
//!
//! Run with `cargo bench -p uavspec-codegen` or `cargo xtask bench codegen`. Requires the corpus.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use divan::Bencher;
use divan::counter::ItemsCount;
use tempfile::TempDir;
use uavspec_codegen::generate;
use uavspec_dynamic::breaking::{Between, breaking};
use uavspec_emit::OutputFile;
use uavspec_lint::{Preset, Settings, lint};
use uavspec_schema::msg::Dialect;
use uavspec_schema::translation::Translations;
use uavspec_schema::{Form, PackageInput, Schema, SourceMap, read, render};

/// The numbers of corpus copies. Each benchmark runs once per number.
const TIMES: [usize; 3] = [1, 4, 16];

fn main() {
    if corpus(MAIN).is_none() {
        eprintln!("skipped: corpus/px4/main is absent; set UAVSPEC_CORPUS to the path of the corpus");
        return;
    }
    divan::main();
}

/// The newest PX4 definitions in the corpus.
const MAIN: &str = "px4/main/msg";

fn corpus(release: &str) -> Option<Vec<PathBuf>> {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/corpus");
    let folder = std::env::var_os("UAVSPEC_CORPUS").map_or(default, PathBuf::from).join(release);
    let mut files: Vec<PathBuf> =
        fs::read_dir(folder).ok()?.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.sort();
    Some(files)
}

struct Input {
    sources: SourceMap,
    packages: Vec<PackageInput>,
    messages: usize,
}

fn input(times: usize) -> Input {
    let files = corpus(MAIN).unwrap_or_default();
    let mut sources = SourceMap::default();
    let mut packages = Vec::new();
    for number in 0..times {
        let mut add = |file: &PathBuf| {
            let text = fs::read(file).expect("a readable file");
            sources.add(file.to_string_lossy(), text).expect("a valid text")
        };
        let ids = files.iter().map(&mut add).collect();
        packages.push(PackageInput::new(format!("px4_{number}"), Form::Msg(Dialect::Px4), ids));
    }
    Input { sources, packages, messages: files.len() * times }
}

/// Parses and resolves the definitions.
#[divan::bench(args = TIMES, max_time = 2, sample_size = 1)]
fn read_definitions(bencher: Bencher<'_, '_>, times: usize) {
    let input = input(times);
    bencher.counter(ItemsCount::new(input.messages)).bench_local(|| read(&input.sources, &input.packages));
}

/// Applies all rules and renders the findings as text. The `lint` command does the same, after reading the files.
#[divan::bench(args = TIMES, max_time = 2, sample_size = 1)]
fn lint_definitions(bencher: Bencher<'_, '_>, times: usize) {
    let input = input(times);
    let settings = Settings { preset: Preset::Strict, ..Settings::default() };
    bencher.counter(ItemsCount::new(input.messages)).bench_local(|| {
        let findings = lint(&input.sources, &input.packages, &[], &settings);
        render::findings(&findings, &input.sources, false)
    });
}

/// Reads PX4 1.15 and main, compares them, and renders the findings as text.
#[divan::bench(max_time = 2, sample_size = 1)]
fn compare_releases(bencher: Bencher<'_, '_>) {
    let mut sources = SourceMap::default();
    let [old, new] = ["px4/1.15/msg", "px4/main/msg"].map(|release| {
        let mut add = |file: &PathBuf| {
            sources
                .add(file.to_string_lossy(), fs::read(file).expect("a readable file"))
                .expect("a valid text")
        };
        let ids = corpus(release).unwrap_or_default().iter().map(&mut add).collect();
        [PackageInput::new("px4", Form::Msg(Dialect::Px4), ids)]
    });
    bencher.bench_local(|| {
        let (old, new) = (read(&sources, &old).0, read(&sources, &new).0);
        render::findings(&breaking(&sources, &old, &new, Between::Releases), &sources, false)
    });
}

fn emitter(bencher: Bencher<'_, '_>, times: usize, emit: impl Fn(&Schema, &SourceMap) -> Vec<OutputFile>) {
    let input = input(times);
    let (schema, _) = read(&input.sources, &input.packages);
    bencher.counter(ItemsCount::new(input.messages)).bench_local(|| emit(&schema, &input.sources));
}

/// Emits Rust from the model.
#[divan::bench(args = TIMES, max_time = 2, sample_size = 1)]
fn emit_rust(bencher: Bencher<'_, '_>, times: usize) {
    emitter(bencher, times, |schema, sources| {
        uavspec_emit::rust::emit(schema, sources, &uavspec_emit::rust::Options::default())
    });
}

/// Emits JSON Schemas from the model.
#[divan::bench(args = TIMES, max_time = 2, sample_size = 1)]
fn emit_json_schema(bencher: Bencher<'_, '_>, times: usize) {
    emitter(bencher, times, |schema, _| {
        uavspec_emit::json_schema::emit(schema, &uavspec_emit::json_schema::Options::default())
    });
}

/// Emits documentation from the model.
#[divan::bench(args = TIMES, max_time = 2, sample_size = 1)]
fn emit_docs(bencher: Bencher<'_, '_>, times: usize) {
    emitter(bencher, times, |schema, sources| {
        uavspec_emit::docs::emit(
            schema,
            &Translations::default(),
            sources,
            &uavspec_emit::docs::Options::default(),
        )
    });
}

/// Emits test vectors from the model.
#[divan::bench(args = TIMES, max_time = 2, sample_size = 1)]
fn emit_vectors(bencher: Bencher<'_, '_>, times: usize) {
    emitter(bencher, times, |schema, _| {
        uavspec_emit::vectors::emit(schema, &uavspec_emit::vectors::Options::default())
    });
}

/// A workspace on disk with copies of the definitions in the corpus.
fn workspace(times: usize) -> TempDir {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a temporary folder");
    let mut config = "[output]\nrust = \"rust\"\njson_schema = \"schemas\"\ndocs = \"docs\"\n".to_owned();
    for number in 0..times {
        let name = format!("px4_{number}");
        fs::create_dir(folder.path().join(&name)).expect("a folder");
        for file in corpus(MAIN).unwrap_or_default() {
            let target = folder.path().join(&name).join(file.file_name().expect("a name"));
            fs::copy(&file, target).expect("a copy");
        }
        let _ = writeln!(
            config,
            "[[package]]\nname = \"{name}\"\ndialect = \"px4\"\ninclude = [\"{name}/*.msg\"]"
        );
    }
    fs::write(folder.path().join("uavspec.toml"), config).expect("a configuration");
    folder
}

/// Runs the whole command when there is no output yet.
#[divan::bench(args = TIMES, max_time = 2, sample_size = 1)]
fn generate_all(bencher: Bencher<'_, '_>, times: usize) {
    let messages = corpus(MAIN).unwrap_or_default().len() * times;
    let folder = workspace(times);
    bencher
        .counter(ItemsCount::new(messages))
        .with_inputs(|| {
            for output in ["rust", "schemas", "docs"] {
                let _ = fs::remove_dir_all(folder.path().join(output));
            }
        })
        .bench_local_values(|()| generate(folder.path().join("uavspec.toml")).expect("output"));
}

/// Runs the whole command when all output is up to date.
#[divan::bench(args = TIMES, max_time = 2, sample_size = 1)]
fn generate_unchanged(bencher: Bencher<'_, '_>, times: usize) {
    let messages = corpus(MAIN).unwrap_or_default().len() * times;
    let folder = workspace(times);
    let config = folder.path().join("uavspec.toml");
    generate(&config).expect("output");
    bencher.counter(ItemsCount::new(messages)).bench_local(|| generate(&config).expect("output"));
}
