//! Checks that tests of the default run don't sleep and don't depend on the speed of the computer. Clippy checks the
//! programs in the same way, see `clippy.toml`.

use std::fs;
use std::path::Path;

use walkdir::WalkDir;

/// The functions that read a real clock or wait for real time. Instead, tests use `uavspec_model::clock::Clock` with
/// simulated time, or the limits of `conformance/test-support`. These limits only end tests that would hang.
const REAL: [&str; 5] = ["thread::sleep", "Instant::now", "SystemTime::now", ".elapsed()", "tokio::time"];

/// The tests that only `.ci/run --release` runs.
const EXEMPT: [&str; 2] = ["conformance/tests/live/", "conformance/tests/serve/siege"];

/// The part of a source file that only tests contain.
fn test_code<'s>(path: &str, source: &'s str) -> &'s str {
    if path.contains("/tests/") || path.ends_with("/tests.rs") {
        return source;
    }
    source.find("#[cfg(test)]\nmod tests {").map_or("", |start| &source[start..])
}

#[test]
fn tests_do_not_use_real_time() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let mut found = Vec::new();
    for folder in ["codegen", "conformance", "definitions", "generated", "xtask"] {
        for file in
            WalkDir::new(root.join(folder)).sort_by_file_name().into_iter().map(|file| file.expect("a file"))
        {
            let path =
                file.path().strip_prefix(root).expect("a path").to_str().expect("UTF-8").replace('\\', "/");
            let is_own = path == "xtask/tests/clocks.rs";
            if file.path().extension().is_none_or(|extension| extension != "rs")
                || is_own
                || EXEMPT.iter().any(|exempt| path.starts_with(exempt))
            {
                continue;
            }
            let source = fs::read_to_string(file.path()).expect("UTF-8");
            let lines = test_code(&path, &source).lines();
            found.extend(
                lines
                    .filter(|line| REAL.iter().any(|real| line.contains(real)))
                    .map(|line| format!("{path}: {}", line.trim())),
            );
        }
    }
    assert!(found.is_empty(), "these tests use real time:\n{}", found.join("\n"));
}
