//! Targets for captures.

use std::io::{Cursor, Read as _, Write as _};
use std::time::Duration;

use flate2::Compression;
use flate2::write::GzEncoder;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use uavspec_capture::input;
use uavspec_capture::rosbag::metadata::Metadata;
use uavspec_check::timeline::{Texts, Timeline};
use uavspec_check::{CaptureResult, check_bytes, check_capture};
use uavspec_model::Location;
use uavspec_report::timeline::{to_html, to_json, to_text};
use uavspec_report::{CheckedCapture, Settings, Subject, subject_text};
use uavspec_rules::flockwave::sample::Session;
use uavspec_rules::sample::{Encoding, Flight};
use uavspec_schema::translation::Translations;

use super::{DEFINITIONS, LIBRARY, Pieces};

/// The maximum number of decompressed bytes that are read.
const MAX_DECOMPRESSED: u64 = 1 << 16;

/// The number of messages in a seed.
const SEED_MESSAGES: usize = 3;

/// Checks a capture that starts with these bytes.
pub(super) fn starting_with(magic: &[u8], data: &[u8]) {
    if data.starts_with(magic) {
        capture(data);
    }
}

pub(super) fn sqlite_bag_seeds() -> Vec<Vec<u8>> {
    let bags = flights(Encoding::Mcap);
    bags.iter().map(|bag| uavspec_test_captures::rosbag::Content::of_mcap(bag).to_bytes()).collect()
}

/// Reads the metadata of a bag. No file may be listed twice in the result.
pub(super) fn bag_metadata(data: &[u8]) {
    let Some(metadata) = Metadata::parse(data) else { return };
    let mut names = metadata.files.clone();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), metadata.files.len(), "a file is listed twice");
    assert!(metadata.encodings.len() + names.len() <= data.len());
}

pub(super) fn bag_metadata_seeds() -> Vec<Vec<u8>> {
    let text = "rosbag2_bagfile_information:\n  version: 8\n  storage_identifier: sqlite3\n  message_count: 7\n  \
                topics_with_message_count:\n    - topic_metadata:\n        name: /wind\n        type: px4_msgs/msg/Wind\n        \
                serialization_format: cdr\n      message_count: 7\n  compression_format: \"\"\n  relative_file_paths:\n    \
                - a_0.db3\n    - 'a_1.db3'\n  files: [{path: a_0.db3, message_count: 3}, {path: &a a_1.db3}]\n  ros_distro: iron\n";
    vec![
        text.as_bytes().to_vec(),
        text.replace("  ", " ").into_bytes(),
        text.replace('\n', "\r\n").into_bytes(),
        uavspec_test_captures::rosbag::metadata("mcap", &["a_0.mcap"], 7).into_bytes(),
    ]
}

/// Checks JSON messages.
pub(super) fn json(data: &[u8]) {
    if matches!(data.trim_ascii_start(), [b'{' | b'[' | 0xef, ..]) {
        capture(data);
    }
}

/// Checks a capture, as a whole and in pieces. Each location must be within the capture.
fn capture(data: &[u8]) {
    let whole = result(check_capture(data, None, &DEFINITIONS));
    assert!(whole.checked <= whole.records, "{} checked of {}", whole.checked, whole.records);
    assert!(whole.bytes <= data.len() as u64, "{} bytes read of {}", whole.bytes, data.len());
    let lines = data.split(|byte| *byte == b'\n').count() as u64;
    let is_inside = |location: &Location| match location {
        Location::Byte(offset) => *offset <= data.len() as u64,
        Location::Line(number) => (1..=lines).contains(number),
        Location::Message(number) => (1..=data.len() as u64).contains(number),
        Location::Channel(_) | Location::Endpoint(_) => true,
    };
    for (location, text) in &whole.corruption {
        assert!(is_inside(location), "{text}: {location}");
    }
    for group in whole.findings.groups() {
        for (location, detail) in &group.examples {
            assert!(is_inside(location), "{detail}: {location}");
        }
    }
    timeline(data);
    let whole = rendered(whole);
    assert_eq!(rendered(result(check_capture(Pieces::new(data), None, &DEFINITIONS))), whole);
    // The release is chosen from the start of the capture.
    let chosen = check_bytes(data, &LIBRARY).unwrap_or_else(|error| panic!("bytes can be read: {error}"));
    for found in chosen.result.summary.releases() {
        assert!(found.matching + found.others.len() as u64 <= found.topics, "{found:?}");
    }
}

/// Renders the timeline of a capture in each format. The text must not contain control characters, except line ends.
fn timeline(data: &[u8]) {
    let texts = Texts::of(Translations::default());
    let Ok(timeline) = Timeline::of_bytes(data, &DEFINITIONS, &texts) else { return };
    for text in [to_text(&timeline, "en"), to_html(&timeline, "en", "uavspec"), to_json(&timeline)] {
        assert!(!text.contains(|character: char| character.is_control() && character != '\n'), "{text}");
    }
}

fn result(checked: std::io::Result<CaptureResult>) -> CaptureResult {
    checked.unwrap_or_else(|error| panic!("bytes in memory can be read: {error}"))
}

/// The result as JSON and as text. The text must not contain control characters, except line ends and colours.
fn rendered(result: CaptureResult) -> (String, String) {
    let capture = CheckedCapture::new("capture".to_owned(), result, Duration::ZERO);
    let subject = Subject::from_capture(capture, &DEFINITIONS, &Settings::default());
    let text = subject_text(&subject);
    let plain = anstream::adapter::strip_str(&text).to_string();
    let is_unsafe = |character: &char| character.is_control() && *character != '\n';
    assert!(!plain.contains(|character: char| is_unsafe(&character)), "{plain:?}");
    let json = serde_json::to_string(&subject).unwrap_or_else(|error| panic!("{error}"));
    (json, text)
}

/// Decompresses an input, as a whole and in pieces. Both must either succeed or fail.
pub(super) fn compressed(data: &[u8]) {
    let read = |input: Box<dyn std::io::Read + Send>| {
        let (input, is_unchanged) = input::decompressed(input).ok()?;
        let mut bytes = Vec::new();
        let is_whole = input.take(MAX_DECOMPRESSED).read_to_end(&mut bytes).is_ok();
        Some((is_unchanged, is_whole, if is_whole { bytes } else { Vec::new() }))
    };
    let whole = read(Box::new(Cursor::new(data.to_vec())));
    assert_eq!(read(Box::new(Pieces::new(data))), whole);
    if let Some((true, _, bytes)) = whole {
        assert!(data.starts_with(&bytes), "other data stays unchanged");
    }
}

/// A short flight for each topic, in this encoding.
pub(super) fn flights(encoding: Encoding) -> Vec<Vec<u8>> {
    let flight = Flight::new(&DEFINITIONS);
    let short = |topic: usize| {
        let mut short = flight.clone();
        short.topics = vec![flight.topics[topic].clone()];
        short.messages.retain(|message| message.topic == topic);
        short.messages.truncate(SEED_MESSAGES);
        short.messages.iter_mut().for_each(|message| message.topic = 0);
        encoding.write(&short)
    };
    (0..flight.topics.len()).filter_map(short).collect()
}

pub(super) fn json_seeds() -> Vec<Vec<u8>> {
    let mut seeds = flights(Encoding::Lines);
    seeds.extend(flights(Encoding::Rosbridge));
    seeds
}

pub(super) fn session_seeds() -> Vec<Vec<u8>> {
    let session = Session::new();
    let part = |lines: &[serde_json::Value]| {
        lines.iter().map(|line| format!("{line}\n")).collect::<String>().into_bytes()
    };
    session.lines.chunks(8).map(part).collect()
}

pub(super) fn compressed_seeds() -> Vec<Vec<u8>> {
    let text = b"{\"type\":\"px4/Event\"}\n".repeat(5);
    let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
    let packed = gzip.write_all(&text).and_then(|()| gzip.finish());
    let zstd = compress_to_vec(&text[..], CompressionLevel::Fastest);
    let skipped = [b"\x50\x2a\x4d\x18\x03\0\0\0abc", &zstd[..]].concat();
    packed.into_iter().chain([zstd, skipped, text]).collect()
}
