//! Tests of corrupt, hostile and huge event metadata.

use allocation_counter::measure;
use uavspec_runtime::Scalar;
use uavspec_schema::event::{decompress, scalar, scalar_name};
use uavspec_schema::limits::MAX_EVENTS_LEN;
use uavspec_schema::{Form, PackageInput, SourceMap, read_formats};
use uavspec_test_definitions::xz;

/// The memory that reading may take, in bytes.
const MAX_MEMORY: u64 = 30 << 20;

const VALID: &str = include_str!("fixtures/ok/events/b.json");

/// The mistakes in event metadata. Panics if reading takes too much memory.
fn mistakes(text: String) -> Vec<String> {
    let mut mistakes = Vec::new();
    let memory = measure(|| {
        let mut sources = SourceMap::default();
        let source = sources.add("a.json", text.into_bytes()).expect("a short text");
        let package = PackageInput::new("events", Form::Events, vec![source]);
        let (_, found) = read_formats(&sources, &[package]);
        mistakes = found.iter().map(|mistake| mistake.problem.to_string()).collect();
    });
    assert!(memory.bytes_max < MAX_MEMORY, "{} bytes", memory.bytes_max);
    mistakes
}

/// A component with events.
fn component(events: &str) -> String {
    format!(
        r#"{{"version": 2, "components": {{"0": {{"namespace": "common", "enums": {{}}, "event_groups": {{"default": {{
        "events": {{{events}}}}}}}}}}}}}"#
    )
}

/// Many members of an object: copies of a text, with a number in place of `~`.
fn numbered(count: usize, text: &str) -> String {
    let members: Vec<String> = (1..=count).map(|number| text.replace('~', &number.to_string())).collect();
    members.join(", ")
}

#[test]
fn a_damaged_compressed_file_is_never_read_as_another_text() {
    let bytes = xz(VALID.as_bytes());
    assert_eq!(decompress(&bytes).expect("valid"), VALID.as_bytes());
    for length in 0..bytes.len() {
        let error = decompress(&bytes[..length]).expect_err("truncated");
        assert_eq!(error.to_string(), "truncated xz data");
    }
    for at in 0..bytes.len() {
        let mut changed = bytes.clone();
        changed[at] ^= 1 << (at % 8);
        let error = decompress(&changed).expect_err("corrupt");
        assert!(error.to_string().contains("xz data"), "byte {at}: {error}");
    }
}

#[test]
fn a_small_file_that_unpacks_to_much_is_refused() {
    for (length, is_read) in [(MAX_EVENTS_LEN, true), (MAX_EVENTS_LEN + 1, false)] {
        let bytes = xz(&vec![b' '; length]);
        let mut read = Ok(Vec::new());
        let memory = measure(|| read = decompress(&bytes));
        assert!(memory.bytes_max < MAX_MEMORY && bytes.len() < 5_000, "{} bytes", memory.bytes_max);
        let expected = "more than 1048576 bytes after decompression";
        let read = read.map(|text| text.len()).map_err(|error| error.to_string());
        assert_eq!(read, if is_read { Ok(length) } else { Err(expected.to_owned()) });
    }
}

#[test]
fn a_text_of_many_values_is_refused() {
    for text in ["0,", "[],", "[0],", "{\"\":0},"] {
        let many = format!("[{}0]", text.repeat(70_000));
        assert_eq!(mistakes(many), ["the file has more than 65536 values"], "{text}");
    }
    let long = format!("[\"{}\"]", " ".repeat(MAX_EVENTS_LEN));
    assert_eq!(mistakes(long), ["the file is 1048580 bytes long; the limit is 1048576 bytes"]);
    let deep = "[".repeat(10_000) + &"]".repeat(10_000);
    assert_eq!(mistakes(deep), ["invalid JSON: maximum nesting depth exceeded"]);
}

#[test]
fn the_largest_metadata_takes_little_memory() {
    let event = r#""~": {"name": "kite_~", "message": "m"}"#;
    let name = r#"{"name": "kite", "type": "wind_t"}"#;
    let described =
        format!(r#""~": {{"name": "kite_~", "message": "m", "description": "{}"}}"#, "<a>".repeat(1_300));
    for (text, expected) in [
        (component(&numbered(16_000, event)), 0),
        (component(&numbered(10_000, event)).replace("default", &"x".repeat(255)), 0),
        // Each event would repeat the name of its group.
        (component(&numbered(4_000, event)).replace("default", &"x".repeat(500_000)), 1),
        // Each mistake would repeat the name of the first part.
        (
            format!(
                r#"{{"version": 2, "components": {{"0": {{"namespace": "{}"}}, {}}}}}"#,
                "x".repeat(500_000),
                numbered(3_000, r#""0": {"namespace": "n~"}"#)
            ),
            1_001,
        ),
        (
            component(&format!(
                r#""1": {{"name": "a", "message": "b", "arguments": [{}]}}"#,
                numbered(20_000, name)
            )),
            1_000,
        ),
        (component(&numbered(40, &described)), 40),
        (
            component("").replace(
                r#""enums": {}"#,
                &format!(
                    r#""enums": {{"wind_t": {{"type": "uint64_t", "entries": {{{}}}}}}}"#,
                    numbered(16_000, r#""~": {"name": "w~", "description": "d"}"#)
                ),
            ),
            0,
        ),
    ] {
        let found = mistakes(text);
        assert_eq!(found.len(), expected, "{:?}", found.first());
    }
}

#[test]
fn only_types_of_c_are_basic_types() {
    let basic = Scalar::ALL.into_iter().map(scalar_name).filter(|name| scalar(name).is_some());
    let expected = "int8_t uint8_t int16_t uint16_t int32_t uint32_t int64_t uint64_t float";
    assert_eq!(basic.collect::<Vec<_>>().join(" "), expected);
}

#[test]
fn each_mistake_in_a_text_is_reported() {
    for (text, expected) in [
        ("<a>", "`<` starts a tag that isn't closed"),
        ("<a><a>x</a></a>", "the tag `<a>` is in a tag of the same name"),
        ("<b>x</b>", "the tag `<b>` is unknown, so readers omit its content"),
        ("{999999999999}", "`{999999999999}` refers to none of the 0 arguments"),
        ("{99999999999999999999}", "`{` doesn't start a placeholder"),
        ("{1", "`{` doesn't start a placeholder"),
        (r#"<profile name=\"dev\">{1}</profile>"#, "`{1}` refers to none of the 0 arguments"),
        (r"\\", r"`\` is the last character"),
    ] {
        let found = mistakes(component(&format!(r#""1": {{"name": "kite", "message": "{text}"}}"#)));
        assert!(found.iter().any(|mistake| mistake.starts_with(expected)), "{text}: {found:?}");
    }
    let long = "x".repeat(1_000_000);
    let found = mistakes(component(&format!(r#""1": {{"name": "kite", "message": "{long}"}}"#)));
    assert_eq!(found, ["the message has 1000000 characters", "the text has 1000000 bytes"]);
}
