//! Tests of files that change while they are read.

use std::fs;
use std::io::Read;

use tempfile::TempDir;
use uavspec_check::{CaptureResult, check_path};
use uavspec_model::Extent;
use uavspec_report::{CheckedCapture, OutcomeKind, Settings, Subject};
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::sample::Flight;

/// Checks a file that another program overwrites directly after it was opened.
fn checked(name: &str, before: &[u8], after: &[u8], library: &Library) -> CaptureResult {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join(name);
    let write = |bytes: &[u8]| fs::write(&path, bytes).expect("a file");
    write(before);
    let reading = |input: Box<dyn Read + Send>| {
        if after != before {
            write(after);
        }
        input
    };
    check_path(&path, None, library, &reading).expect("the path can be opened").result
}

#[test]
fn a_file_that_grows_is_checked_up_to_its_end_at_the_start() {
    let library = Library::fixed(Definitions::built_in());
    let flight = Flight::new(library.base());
    for (name, bytes) in [
        ("log.ulg", flight.log().to_bytes()),
        ("bag.mcap", flight.bag().to_bytes()),
        ("messages.jsonl", flight.lines().to_bytes()),
    ] {
        let expected = checked(name, &bytes, &bytes, &library);
        assert!(expected.checked > 0 && expected.cut_short.is_empty(), "{name}: {:?}", expected.cut_short);
        // The end of the file is neither a message nor a record of any kind.
        let longer = [&bytes[..], b"{\"timestamp\": 7, \"not complete"].concat();
        let result = checked(name, &bytes, &longer, &library);
        let read = (result.records, result.checked, result.bytes, result.extent, result.corruption.len());
        assert_eq!(read, (expected.records, expected.checked, expected.bytes, Extent::Whole, 0), "{name}");
        assert_eq!(result.findings.groups().count(), 0, "{name}");
        let [reason] = &result.cut_short[..] else { panic!("{name}: {:?}", result.cut_short) };
        assert!(
            reason.starts_with("the file grew from ") && reason.ends_with("may not have been read"),
            "{reason}"
        );
        let capture = CheckedCapture {
            path: name.to_owned(),
            result,
            notes: Vec::new(),
            requests: Vec::new(),
            cut_short: Vec::new(),
            elapsed: 0,
        };
        let outcome = Subject::from_capture(capture, library.base(), &Settings::default()).outcome;
        assert_eq!(outcome.kind, OutcomeKind::Incomplete, "{name}: {}", outcome.text);
        assert!(outcome.text.starts_with("Incomplete: the file grew from "), "{name}: {}", outcome.text);
    }
}

#[test]
fn a_file_that_changes_otherwise_is_incomplete() {
    let library = Library::fixed(Definitions::built_in());
    let bytes = Flight::new(library.base()).log().to_bytes();
    let result = checked("log.ulg", &bytes, &bytes[..bytes.len() / 2], &library);
    assert_eq!(result.cut_short, ["the file changed while it was read"]);
}
