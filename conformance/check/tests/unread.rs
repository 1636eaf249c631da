//! Tests that unread data never counts as conforming: if a flipped bit hides data, the outcome shows it.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Write as _};
use std::path::Path;
use std::time::Duration;

use flate2::Compression;
use flate2::write::GzEncoder;
use mcap::records::{MessageHeader, op};
use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use uavspec_capture::input::decompressed;
use uavspec_capture::mcap::{Event, MAGIC, Packing, Reader, Writer, attachment_body, metadata_body};
use uavspec_check::{CaptureResult, Summary, check_capture, check_path};
use uavspec_report::{CheckedCapture, OutcomeKind, Settings, Subject};
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::sample::{Encoding, Flight};
use uavspec_test_support::{Random, extent};

/// A flight with the first messages of a few topics.
fn flight(definitions: &Definitions) -> Flight<'_> {
    let mut flight = Flight::new(definitions);
    let topics = flight.topics.len().min(3);
    flight.topics.truncate(topics);
    flight.messages.retain(|message| message.topic < topics);
    flight.messages.truncate(12);
    flight
}

/// The outcome, the number of messages, and the number of checked messages.
fn outcome(result: CaptureResult, definitions: &Definitions) -> (OutcomeKind, (u64, u64)) {
    let counts = (result.records, result.checked);
    let capture = CheckedCapture::new("capture".to_owned(), result, Duration::ZERO);
    (Subject::from_capture(capture, definitions, &Settings::default()).outcome.kind, counts)
}

fn outcome_of(bytes: &[u8], definitions: &Definitions) -> (OutcomeKind, (u64, u64)) {
    let checked = decompressed(Cursor::new(bytes.to_vec()))
        .and_then(|(input, _)| check_capture(input, None, definitions))
        .unwrap_or_else(|error| CaptureResult::unknown(error.to_string()));
    outcome(checked, definitions)
}

/// Flips bits, one at a time. If the outcome is still "conforms", all messages must have been checked.
fn assert_nothing_is_hidden(bytes: &[u8], definitions: &Definitions, name: &str) {
    let intact = outcome_of(bytes, definitions);
    assert_eq!(intact.0, OutcomeKind::Conforms, "{name}");
    let mut random = Random(41);
    for _ in 0..extent(4_000, 20) {
        let at = random.index(bytes.len());
        let bit = random.below(8);
        let mut flipped = bytes.to_vec();
        flipped[at] ^= 1 << bit;
        let (kind, counts) = outcome_of(&flipped, definitions);
        if kind == OutcomeKind::Conforms {
            assert_eq!(counts, intact.1, "{name}: bit {bit} of byte {at}");
        }
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
    gzip.write_all(bytes).expect("memory");
    gzip.finish().expect("memory")
}

/// A bag with the same messages as `bag`, and with statistics and indexes. Chunks have checksums unless `packing` omits
/// them.
fn indexed(bag: &[u8], packing: Option<Packing>) -> Vec<u8> {
    let mut reader = Reader::new(bag);
    let mut writer = Writer::new(Vec::new(), "ros2").expect("memory");
    writer.set_packing(packing).expect("memory");
    while let Some(item) = reader.next().expect("bytes can be read") {
        match item.event {
            Event::Schema { id, name, encoding, text } => {
                writer.schema(id, (&name, &encoding), text).expect("memory");
            }
            Event::Channel { id, schema, topic, encoding, metadata } => {
                writer.channel((id, schema), (&topic, &encoding), &metadata).expect("memory");
            }
            Event::Message { channel, time, publish_time, sequence, payload } => {
                let header = MessageHeader { channel_id: channel, sequence, log_time: time, publish_time };
                writer.message(&header, payload).expect("memory");
            }
            _ => {}
        }
    }
    let attachment = attachment_body("plan.txt", "text/plain", b"the plan of the flight");
    writer.attachment(attachment.len() as u64, &mut &attachment[..]).expect("memory");
    writer.metadata(&metadata_body("pilot", &BTreeMap::new())).expect("memory");
    writer.finish().expect("memory")
}

/// The records of a file outside of chunks: the opcode, the offset of the body, and its length.
fn records(bytes: &[u8]) -> Vec<(u8, usize, usize)> {
    let (mut at, mut found) = (MAGIC.len(), Vec::new());
    while at + 9 <= bytes.len() - MAGIC.len() {
        let length = u64::from_le_bytes(*bytes[at + 1..].first_chunk().expect("a length"));
        let length = usize::try_from(length).expect("a length");
        found.push((bytes[at], at + 9, length));
        at += 9 + length;
    }
    found
}

/// Without the checksums of the data and the summary, only statistics and indexes reveal a difference.
#[test]
fn each_statement_of_a_bag_is_compared() {
    let definitions = Definitions::built_in();
    let mut bag = indexed(&Encoding::Mcap.write(&flight(&definitions)).expect("a bag"), None);
    for (opcode, body, length) in records(&bag) {
        if matches!(opcode, op::DATA_END | op::FOOTER) {
            bag[body + length - 4..body + length].fill(0);
        }
    }
    assert_eq!(outcome_of(&bag, &definitions).0, OutcomeKind::Conforms);
    let mut compared = 0;
    for (opcode, body, length) in records(&bag) {
        let places: &[usize] = match opcode {
            // The counts of all kinds of records, and of the messages of a channel.
            op::STATISTICS => &[0, 8, 10, 14, 18, 22, 48],
            op::CHUNK_INDEX => &[16, 24],
            op::ATTACHMENT_INDEX | op::METADATA_INDEX => &[0, 8],
            // The log time of a message.
            op::MESSAGE_INDEX => &[6],
            op::FOOTER => &[0],
            // The data, and the checksum.
            op::ATTACHMENT => &[length - 5, length - 1],
            _ => &[],
        };
        for place in places {
            let mut changed = bag.clone();
            changed[body + place] ^= 1;
            let (kind, _) = outcome_of(&changed, &definitions);
            assert_ne!(kind, OutcomeKind::Conforms, "opcode {opcode}, byte {place}");
            compared += 1;
        }
    }
    assert!(compared > 15, "{compared}");
}

#[test]
fn a_flipped_bit_hides_no_message() {
    let definitions = Definitions::built_in();
    let flight = flight(&definitions);
    let (log, bag) = (Encoding::Ulog.write(&flight), Encoding::Mcap.write(&flight));
    let (log, bag) = (log.expect("a log"), bag.expect("a bag"));
    for (bytes, name) in [
        (indexed(&bag, None), "a bag"),
        (indexed(&bag, Some(Packing::Zstd)), "a compressed bag"),
        (gzip(&log), "gzip"),
        (compress_to_vec(&log[..], CompressionLevel::Fastest), "zstd"),
        (log, "a log"),
    ] {
        assert_nothing_is_hidden(&bytes, &definitions, name);
    }
}

/// Flips a bit of the kind of each message, which turns it into another kind.
#[test]
fn a_changed_kind_of_a_message_is_reported() {
    let definitions = Definitions::built_in();
    let log = Encoding::Ulog.write(&flight(&definitions)).expect("a log");
    let (_, intact) = outcome_of(&log, &definitions);
    let (mut at, mut changed) = (16, 0);
    while at + 3 <= log.len() {
        for bit in 0..8 {
            let mut flipped = log.clone();
            flipped[at + 2] ^= 1 << bit;
            let (kind, counts) = outcome_of(&flipped, &definitions);
            assert!(kind != OutcomeKind::Conforms || counts == intact, "bit {bit} of the kind at {at}");
            changed += 1;
        }
        at += 3 + usize::from(u16::from_le_bytes([log[at], log[at + 1]]));
    }
    assert!(changed > 100, "{changed}");
}

/// All messages before a wrong trailer, a missing trailer or trailing zeros are checked.
#[test]
fn compressed_captures_are_read_to_their_last_byte() {
    let library = Library::built_in();
    let definitions = Definitions::built_in();
    let flight = flight(&definitions);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("capture");
    let check = |bytes: &[u8]| {
        fs::write(&path, bytes).expect("a file");
        let checked = check_path(&path, None, &library, &|input| input).expect("the path can be opened");
        outcome(checked.result, &checked.definitions)
    };
    for encoding in [Encoding::Ulog, Encoding::Mcap, Encoding::Lines] {
        let bytes = encoding.write(&flight).expect("a capture");
        let (_, whole) = check(&bytes);
        assert!(whole.0 > 0);
        let (gzip, zstd) = (gzip(&bytes), compress_to_vec(&bytes[..], CompressionLevel::Fastest));
        for (packed, trailer) in [(&gzip, 8), (&zstd, 4)] {
            let zeros = [&packed[..], &[0; 513]].concat();
            assert_eq!(check(&zeros), (OutcomeKind::Conforms, whole), "zeros after {encoding:?}");
            let cut = &packed[..packed.len() - trailer];
            assert_eq!(check(cut), (OutcomeKind::Incomplete, whole), "no trailer after {encoding:?}");
            let mut wrong = packed.clone();
            *wrong.last_mut().expect("bytes") ^= 0x40;
            assert_eq!(check(&wrong), (OutcomeKind::Incomplete, whole), "a wrong trailer after {encoding:?}");
            let more = [&packed[..], b"more"].concat();
            assert_eq!(check(&more), (OutcomeKind::Incomplete, whole), "other data after {encoding:?}");
        }
    }
}

/// Checks the folder of a bag with this `metadata.yaml`.
fn check_bag(folder: &Path, metadata: &str, library: &Library) -> (OutcomeKind, (u64, u64)) {
    fs::write(folder.join("metadata.yaml"), metadata).expect("a file");
    let checked = check_path(folder, None, library, &|input| input).expect("the path can be opened");
    outcome(checked.result, library.base())
}

#[test]
fn each_number_in_the_metadata_of_a_bag_is_compared() {
    let library = Library::fixed(Definitions::built_in());
    let bag = indexed(&Encoding::Mcap.write(&flight(library.base())).expect("a bag"), None);
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("a_0.mcap"), &bag).expect("a file");
    let mut topics: BTreeMap<String, u64> = BTreeMap::new();
    let whole = check_path(&folder.path().join("a_0.mcap"), None, &library, &|input| input);
    let whole = whole.expect("a file").result;
    let Summary::Mcap(summary) = &whole.summary else { panic!("{:?}", whole.summary) };
    for channel in &summary.channels {
        *topics.entry(channel.topic.clone()).or_default() += channel.messages;
    }
    let rows: String = topics
        .iter()
        .map(|(topic, count)| {
            format!("    - message_count: {count}\n      topic_metadata:\n        name: {topic}\n")
        })
        .collect();
    let count = whole.records;
    let text = format!(
        "rosbag2_bagfile_information:\n  version: 8\n  storage_identifier: mcap\n  message_count: {count}\n  \
         topics_with_message_count:\n{rows}  relative_file_paths:\n    - a_0.mcap\n  files:\n    - path: a_0.mcap\n      \
         message_count: {count}\n"
    );
    assert_eq!(check_bag(folder.path(), &text, &library), (OutcomeKind::Conforms, (count, whole.checked)));
    let places: Vec<usize> =
        text.match_indices("message_count: ").map(|(at, found)| at + found.len()).collect();
    assert_eq!(places.len(), 2 + topics.len());
    for at in places {
        for number in ["1", "-1", "many", "99"] {
            let end = at + text[at..].find('\n').expect("a line");
            let changed = format!("{}{number}{}", &text[..at], &text[end..]);
            let (kind, counts) = check_bag(folder.path(), &changed, &library);
            assert_eq!((kind, counts.0), (OutcomeKind::Incomplete, count), "{changed}");
        }
    }
    for (from, to) in
        [("  message", " \tmessage"), ("    - a_0", "    - b_0"), ("storage_identifier", "storage")]
    {
        let (kind, counts) = check_bag(folder.path(), &text.replacen(from, to, 1), &library);
        let read = if to.contains("b_0") { 0 } else { count };
        assert_eq!((kind, counts.0), (OutcomeKind::Incomplete, read), "{to}");
    }
}

/// Flips each bit of a bag's `metadata.yaml`.
#[test]
fn a_flipped_bit_in_the_metadata_hides_no_file() {
    let definitions = Definitions::built_in();
    let bag = indexed(&Encoding::Mcap.write(&flight(&definitions)).expect("a bag"), None);
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["a_0.mcap", "a_1.mcap"] {
        fs::write(folder.path().join(name), &bag).expect("a file");
    }
    let (_, (count, _)) = outcome_of(&bag, &definitions);
    let text = uavspec_test_captures::rosbag::metadata(
        "mcap",
        &["a_0.mcap", "a_1.mcap"],
        usize::try_from(2 * count).expect("a number"),
    );
    let library = Library::fixed(Definitions::built_in());
    let mut random = Random(42);
    for _ in 0..extent(4_000, 75) {
        let mut flipped = text.as_bytes().to_vec();
        let at = random.index(flipped.len());
        flipped[at] ^= 1 << random.below(8);
        fs::write(folder.path().join("metadata.yaml"), &flipped).expect("a file");
        let checked = check_path(folder.path(), None, &library, &|input| input).expect("a folder");
        let (kind, counts) = outcome(checked.result, &definitions);
        let is_complete = counts.0 == 2 * count;
        assert!(kind != OutcomeKind::Conforms || is_complete, "{}", String::from_utf8_lossy(&flipped));
    }
}
