//! How fast JSON Lines are judged, beside what others do with the same bytes, in one run on one core:
//! `cargo bench -p uavspec-conformance --bench json`.
//!
//! `skip` is `serde_json` passing over the values (`IgnoredAny`), the practical limit of whoever reads with it;
//! `tree_and_schema` is `serde_json` to a tree plus the crate `jsonschema` with the published schema.

use std::fmt::Write as _;
use std::io::Cursor;

use divan::Bencher;
use divan::counter::BytesCount;
use serde::de::IgnoredAny;
use serde_json::Value;
use uavspec_conformance::definitions::Definitions;
use uavspec_conformance::judge::judge;

/// How many messages there are.
const MESSAGES: usize = 10_000;

/// The schema that is published.
const SCHEMA: &str = include_str!("../../generated/schemas/px4/FailsafeFlags.schema.json");

fn main() {
    divan::main();
}

/// Messages that conform, each a line.
fn lines(definitions: &Definitions) -> String {
    let of = definitions.types().find("px4", "FailsafeFlags").expect("a built-in message");
    let zero = of.default().to_json().expect("finite values");
    let mut text = String::new();
    for number in 0..MESSAGES {
        let mut message = zero.clone();
        message["timestamp"] = (1_000_000 + 20_000 * number).into();
        message["geofence_breached"] = (number % 3 == 0).into();
        writeln!(text, "{message}").expect("a string");
    }
    text
}

#[divan::bench]
fn uavspec(bencher: Bencher<'_, '_>) {
    let definitions = Definitions::built_in();
    let text = lines(&definitions);
    let of = definitions.message_of_type("px4/FailsafeFlags");
    bencher.counter(BytesCount::new(text.len())).bench_local(|| {
        let judgement = judge(Cursor::new(text.as_bytes()), of, &definitions).expect("memory");
        assert_eq!((judgement.judged, judgement.findings.groups().count()), (MESSAGES as u64, 0));
    });
}

#[divan::bench]
fn skip(bencher: Bencher<'_, '_>) {
    let text = lines(&Definitions::built_in());
    bencher.counter(BytesCount::new(text.len())).bench_local(|| {
        for line in text.lines() {
            serde_json::from_str::<IgnoredAny>(line).expect("JSON");
        }
    });
}

#[divan::bench]
fn tree_and_schema(bencher: Bencher<'_, '_>) {
    let text = lines(&Definitions::built_in());
    let schema: Value = serde_json::from_str(SCHEMA).expect("JSON");
    let validator = jsonschema::validator_for(&schema).expect("a schema");
    bencher.counter(BytesCount::new(text.len())).bench_local(|| {
        for line in text.lines() {
            let message: Value = serde_json::from_str(line).expect("JSON");
            assert!(validator.is_valid(&message));
        }
    });
}
