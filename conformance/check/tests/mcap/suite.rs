//! The conformance suite of MCAP: all files are read without problems and with the expected records.

use std::collections::BTreeMap;
use std::fs;

use serde_json::Value;
use uavspec_capture::mcap::{Event, Reader};
use uavspec_check::Summary;
use uavspec_model::Extent;
use uavspec_test_support::shared;

use crate::mcap::checked;

/// The number of files in the suite.
const FILES: usize = 208;

/// The number of records of each kind that the reader returns. The error is the first problem.
fn read(bytes: &[u8]) -> Result<BTreeMap<&'static str, usize>, String> {
    let mut counts = BTreeMap::new();
    let mut reader = Reader::new(bytes);
    while let Some(item) = reader.next().map_err(|error| error.to_string())? {
        let kind = match item.event {
            Event::Header { .. } => "Header",
            Event::Schema { .. } => "Schema",
            Event::Channel { .. } => "Channel",
            Event::Message { .. } => "Message",
            Event::Attachment { at: 0, .. } => "Attachment",
            Event::Attachment { .. } => continue,
            Event::Metadata { .. } => "Metadata",
            Event::Private { .. } => "Private",
            Event::Problem(problem) => return Err(problem.to_string()),
        };
        *counts.entry(kind).or_default() += 1;
    }
    Ok(counts)
}

/// The number of records of these kinds in the suite's description of a file.
fn expected(description: &Value) -> BTreeMap<&'static str, usize> {
    let records = description["records"].as_array().expect("records");
    let count = |kind: &str| records.iter().filter(|record| record["type"] == kind).count();
    let kinds = ["Header", "Schema", "Channel", "Message", "Attachment", "Metadata"];
    let counts = kinds.map(|kind| (kind, count(kind)));
    counts.into_iter().filter(|(_, count)| *count > 0).collect()
}

#[test]
fn reads_the_conformance_suite() {
    let Some(suite) = shared("corpus/mcap/conformance") else { return };
    let mut num_files = 0;
    for entry in walkdir::WalkDir::new(suite) {
        let path = entry.expect("a file").into_path();
        if path.extension().is_none_or(|extension| extension != "mcap") {
            continue;
        }
        num_files += 1;
        let name = path.display();
        let bytes = fs::read(&path).expect("a file");
        let description = fs::read(path.with_extension("json")).expect("a description");
        let expected = expected(&serde_json::from_slice(&description).expect("JSON"));
        assert_eq!(read(&bytes).as_ref(), Ok(&expected), "{name}");
        let result = checked(&bytes);
        let messages = expected.get("Message").copied().unwrap_or_default() as u64;
        assert_eq!((result.extent, result.records), (Extent::Whole, messages), "{name}");
        assert!(matches!(result.summary, Summary::Mcap(_)) && result.corruption.is_empty(), "{name}");
    }
    assert_eq!(num_files, FILES);
}
