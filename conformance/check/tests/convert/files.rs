//! Tests of the files that conversions write.

use std::collections::BTreeMap;

use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use uavspec_capture::mcap::{Event, Packing, Reader};
use uavspec_check::convert::{Action, ConversionReport, Settings};
use uavspec_test_captures::mcap::{self as file, FORMS, Form};
use uavspec_test_support::extent;

use super::{checked, checked_against, converted, release, try_converted};

/// The definition of `ArmingCheckRequest` in PX4 1.16.
const DEFINITION: &[u8] = b"uint32 MESSAGE_VERSION=0\nuint64 timestamp\nuint8 request_id\n";

/// The start of a zstd frame.
const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// A payload of `ArmingCheckRequest` with this id.
fn request(id: u8) -> Vec<u8> {
    [&[0, 1, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0][..], &[id]].concat()
}

/// The declarations of a channel with the id 5.
fn declarations() -> Vec<u8> {
    let schema = file::schema(9, "px4_msgs/msg/ArmingCheckRequest", "ros2msg", DEFINITION);
    [schema, file::channel(5, 9, "/fmu/out/arming_check_request", "cdr", &[])].concat()
}

/// An attachment with its name and data.
fn attachment(name: &str, data: &[u8]) -> Vec<u8> {
    let times = [7_u64.to_le_bytes(), 8_u64.to_le_bytes()].concat();
    let head = [times, file::text(name.as_bytes()), file::text(b"text/plain")].concat();
    let body = [&head[..], &(data.len() as u64).to_le_bytes(), data].concat();
    file::record(9, &[&body, &crc32fast::hash(&body).to_le_bytes()])
}

fn metadata(name: &str) -> Vec<u8> {
    let pair = [file::text(b"pilot"), file::text(b"Ada")].concat();
    file::record(12, &[&file::text(name.as_bytes()), &file::text(&pair)])
}

/// The records of an output other than messages, schemas and channels.
fn others(bytes: &[u8]) -> Vec<(u8, Vec<u8>)> {
    let mut found: Vec<(u8, Vec<u8>)> = Vec::new();
    let mut reader = Reader::new(bytes);
    while let Some(item) = reader.next().expect("memory") {
        match item.event {
            Event::Attachment { at, bytes, .. } if at > 0 => {
                found.last_mut().expect("the first part").1.extend_from_slice(bytes);
            }
            Event::Attachment { bytes, .. } => found.push((9, bytes.to_vec())),
            Event::Metadata { body } => found.push((12, body.to_vec())),
            Event::Private { opcode, body, .. } => found.push((opcode, body.to_vec())),
            Event::Problem(problem) => panic!("{problem}"),
            _ => {}
        }
    }
    found
}

#[test]
fn attachments_metadata_and_private_records_are_copied() {
    // The first attachment is too large to be kept in memory.
    let large = (0..=255).collect::<Vec<u8>>().repeat(17 << 12);
    let others_in = [
        attachment("notes.txt", &large),
        metadata("crew"),
        attachment("", b""),
        metadata(""),
        file::record(0x81, &[b"private"]),
    ];
    let messages = [declarations(), file::message(5, &request(1)), file::message(5, &request(2))].concat();
    let packed = file::chunk(Form::Lz4, &[messages, file::record(0xff, &[b"in a chunk"])].concat());
    let [first, rest @ ..] = &others_in;
    let bytes = file::file(&[first.clone(), packed, rest.concat()].concat());
    let (report, output) = converted(&bytes, "px4@1.17", Settings::default());
    assert!(report.is_complete(), "{:?}", report.problems);
    let found = others(&output);
    let bodies = others_in.iter().map(|record| (record[0], record[9..].to_vec()));
    let mut expected: Vec<(u8, Vec<u8>)> = bodies.collect();
    expected.insert(1, (0xff, b"in a chunk".to_vec()));
    assert!(found == expected);

    let summary = ::mcap::Summary::read(&output).expect("a summary").expect("a summary");
    let statistics = summary.stats.as_ref().expect("statistics");
    assert_eq!((statistics.attachment_count, statistics.metadata_count, statistics.message_count), (2, 2, 2));
    let notes = ::mcap::read::attachment(&output, &summary.attachment_indexes[0]).expect("an attachment");
    assert_eq!((notes.log_time, notes.create_time, notes.name.as_str()), (7, 8, "notes.txt"));
    assert!(*notes.data == large && notes.media_type == "text/plain");
    let crew = ::mcap::read::metadata(&output, &summary.metadata_indexes[0]).expect("metadata");
    let pilot = BTreeMap::from([("pilot".to_owned(), "Ada".to_owned())]);
    assert_eq!((crew.name.as_str(), crew.metadata), ("crew", pilot));
}

#[test]
fn a_truncated_attachment_is_left_out() {
    let whole = attachment("notes.txt", &[5].repeat(300_000));
    let records = [declarations(), file::message(5, &request(1))].concat();
    for length in [40, 200_000, whole.len() - 1] {
        let bytes = [file::start(), records.clone(), whole[..length].to_vec()].concat();
        let (report, output) = converted(&bytes, "px4@1.17", Settings::default());
        assert!(!report.is_complete());
        assert_eq!(others(&output), [], "{length}");
        assert_eq!(checked(&output).result.records, 1);
    }
}

#[test]
fn chunks_keep_their_compression() {
    let messages: Vec<u8> = (0..200_u8).flat_map(|id| file::message(5, &request(id))).collect();
    let records = [declarations(), messages].concat();
    for form in FORMS {
        let input = file::file(&file::chunked(form, std::slice::from_ref(&records)));
        let (report, output) = converted(&input, "px4@1.17", Settings::default());
        assert!(report.is_complete(), "{:?}", report.problems);
        let summary = ::mcap::Summary::read(&output).expect("a summary").expect("a summary");
        let (name, packing) = match form {
            Form::Unchunked | Form::Plain => ("", None),
            Form::Zstd => ("zstd", Some(Packing::Zstd)),
            Form::Lz4 => ("lz4", Some(Packing::Lz4)),
        };
        assert_eq!(summary.chunk_indexes.len(), 1);
        let chunk = &summary.chunk_indexes[0];
        assert_eq!(chunk.compression, name);
        assert_eq!(chunk.compressed_size < chunk.uncompressed_size / 2, packing.is_some());
        let (mut reader, mut ids) = (Reader::new(&*output), Vec::new());
        while let Some(item) = reader.next().expect("memory") {
            if let Event::Message { payload, .. } = item.event {
                assert_eq!(item.packing, packing);
                ids.push(payload[12]);
            }
        }
        assert_eq!(ids, (0..200).collect::<Vec<u8>>());
        assert_eq!(checked(&output).result.corruption.len(), 0);
    }
}

#[test]
fn the_indexes_lead_to_each_message() {
    // More than one chunk.
    let long = [&b"\0\x01\0\0"[..], &b"x".repeat(1_000_000)].concat();
    let messages: Vec<Vec<u8>> = (0..10).map(|_| file::message(6, &long)).collect();
    let rope = file::channel(6, 0, "/rope", "cdr", &[]);
    let records = [declarations(), rope, messages.concat(), file::message(5, &request(4))].concat();
    let (_, output) = converted(&file::file(&records), "px4@1.17", Settings::default());
    let summary = ::mcap::Summary::read(&output).expect("a summary").expect("a summary");
    assert!(summary.chunk_indexes.len() > 2);
    let mut found: BTreeMap<String, usize> = BTreeMap::new();
    for chunk in &summary.chunk_indexes {
        let indexes = summary.read_message_indexes(&output, chunk).expect("indexes");
        for (channel, entries) in indexes {
            for entry in entries {
                let message = summary.seek_message(&output, chunk, &entry).expect("a message");
                assert_eq!((&message.channel.topic, message.log_time), (&channel.topic, entry.log_time));
                *found.entry(channel.topic.clone()).or_default() += 1;
            }
        }
    }
    let expected = [("/fmu/out/arming_check_request_v1", 1), ("/rope", 10)];
    assert_eq!(found, expected.map(|(topic, count)| (topic.to_owned(), count)).into());
    let statistics = summary.stats.expect("statistics");
    assert_eq!(statistics.channel_message_counts.into_iter().collect::<Vec<_>>(), [(5, 1), (6, 10)]);
    assert_eq!((statistics.message_start_time, statistics.message_end_time), (7, 7));
}

/// The only message of an output, with the metadata of its channel and its schema.
fn only(output: &[u8]) -> (String, BTreeMap<String, String>, (String, String, String)) {
    let message = ::mcap::MessageStream::new(output).expect("a bag").next().expect("a message").expect("CDR");
    let schema = message.channel.schema.as_ref().expect("a schema");
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("text");
    let names = (schema.name.clone(), schema.encoding.clone(), text(&schema.data));
    (text(&message.data), message.channel.metadata.clone(), names)
}

#[test]
fn json_messages_are_converted() {
    // A CDR message indicates the release.
    let hash = [("topic_type_hash", "RIHS01_0")];
    for (encoding, content, metadata) in [
        ("jsonschema", &b"{}"[..], &[][..]),
        ("jsonschema", b"", &[]),
        ("ros2msg", DEFINITION, &hash),
        ("other", b"text", &[]),
    ] {
        let name = if encoding == "ros2msg" {
            "px4_msgs/msg/ArmingCheckRequest"
        } else {
            "px4.arming_check_request"
        };
        let records = [
            file::schema(7, "px4_msgs/msg/ArmingCheckRequest", "ros2msg", DEFINITION),
            file::channel(7, 7, "/fmu/out/arming_check_request", "cdr", &[]),
            file::schema(9, name, encoding, content),
            file::channel(5, 9, "/ns/fmu/out/arming_check_request", "json", metadata),
            file::message(5, br#"{"timestamp": 9, "request_id": 3}"#),
        ];
        let (report, output) = converted(&file::file(&records.concat()), "px4@1.17", Settings::default());
        assert!(report.is_complete() && report.count(Action::Converted) == 2, "{}", report.to_text());
        let (payload, metadata_out, (name, encoding_out, text)) = only(&output);
        assert_eq!(payload, r#"{"timestamp":9,"request_id":3,"valid_registrations_mask":4294967295}"#);
        assert_eq!((name.as_str(), encoding_out.as_str()), ("px4_msgs/msg/ArmingCheckRequest", encoding));
        assert_eq!(metadata_out.contains_key("topic_type_hash"), !metadata.is_empty());
        assert_ne!(metadata_out.get("topic_type_hash").map(String::as_str), Some("RIHS01_0"));
        match (encoding, content.is_empty()) {
            ("jsonschema", false) => {
                let schema: serde_json::Value = serde_json::from_str(&text).expect("JSON");
                assert_eq!(schema["properties"]["valid_registrations_mask"]["type"], "integer");
                assert_eq!(schema["required"][2], "valid_registrations_mask");
            }
            ("ros2msg", _) => assert!(text.contains("uint32 valid_registrations_mask"), "{text}"),
            _ => assert_eq!(text, ""),
        }
        let found = checked(&output);
        assert_eq!(found.result.corruption.len(), 0);
        assert_eq!(found.result.findings.groups().count(), 0);
    }
}

#[test]
fn unreadable_json_messages_are_left_out() {
    let channel = file::channel(6, 0, "/fmu/out/arming_check_request", "json", &[]);
    for payload in [
        &b"{\"timestamp\": 9}"[..],
        b"{\"timestamp\": 9, \"request_id\": 3, \"winch\": 1}",
        b"{\"timestamp\": 9, \"request_id\": 300}",
        b"{\"timestamp\": 9,",
        b"\xff",
        b"",
    ] {
        let records = [declarations(), channel.clone(), file::message(6, payload)].concat();
        let (report, output) = converted(&file::file(&records), "px4@1.17", Settings::default());
        assert!(!report.is_complete(), "{}", report.to_text());
        assert_eq!(checked(&output).result.records, 0);
    }
}

/// The payloads of an output, as text.
fn payloads(output: &[u8]) -> Vec<String> {
    let messages = ::mcap::MessageStream::new(output).expect("a bag");
    let texts = messages.map(|message| String::from_utf8(message.expect("a message").data.into_owned()));
    texts.map(|text| text.expect("text")).collect()
}

/// Other programs use the names of PX4 topics for other types.
#[test]
fn names_of_json_channels_outside_of_px4_need_the_keys_of_the_type() {
    let (robot, px4) = ("/robot/arming_check_request", "/robot/fmu/out/arming_check_request");
    let sent = r#"{"timestamp":9,"request_id":3}"#;
    let other = r#"{"robot":"Ada","request_id":3}"#;
    let new = r#"{"timestamp":9,"request_id":3,"valid_registrations_mask":4294967295}"#;
    for (topic, ty, messages, expected, action) in [
        (robot, "Request", &[other, sent][..], &[other, sent][..], Action::Copied),
        (robot, "Request", &[sent, sent], &[new, new], Action::Converted),
        (robot, "Request", &[sent, other], &[new], Action::Converted),
        // Empty messages decide nothing.
        (robot, "Request", &["{}", "[1]", "{", sent], &[new], Action::Converted),
        (robot, "Request", &["{}", "[1]", "{", other], &["{}", "[1]", "{", other], Action::Copied),
        (robot, "Request", &["{}", "{}"], &["{}", "{}"], Action::Copied),
        (robot, "Request", &[], &[], Action::Copied),
        // If there is a schema, or the topic is in one of PX4's folders, the type isn't a guess.
        (robot, "px4/ArmingCheckRequest", &[other], &[], Action::Converted),
        (px4, "Request", &[other], &[], Action::Converted),
    ] {
        let records: Vec<u8> = messages.iter().flat_map(|sent| file::message(5, sent.as_bytes())).collect();
        let schema = file::schema(9, ty, "jsonschema", b"{}");
        let bytes = file::file(&[schema, file::channel(5, 9, topic, "json", &[]), records].concat());
        let library = release("px4@1.16");
        let conversion = try_converted(&bytes, library, "px4@1.17", Settings::default());
        let (report, output) = conversion.expect("a conversion");
        assert_eq!(payloads(&output), expected, "{topic} {ty} {messages:?}");
        let [found] = &report.topics[..] else { panic!("{:?}", report.topics) };
        let (count, lost) = (messages.len() as u64, (messages.len() - expected.len()) as u64);
        assert_eq!((found.action, found.messages, found.unreadable), (action, count, lost), "{messages:?}");
        assert_eq!((report.is_complete(), &found.reason), (lost == 0, &None), "{messages:?}");
        let is_converted = action == Action::Converted;
        let summary = ::mcap::Summary::read(&output).expect("a summary").expect("a summary");
        let schema = summary.channels.values().find_map(|channel| channel.schema.as_ref());
        let expected = if is_converted { "px4_msgs/msg/ArmingCheckRequest" } else { ty };
        assert_eq!(schema.map(|schema| schema.name.as_str()), Some(expected), "{messages:?}");
        let is_checked = checked_against(&bytes, library).result.checked > 0;
        assert_eq!(is_checked, is_converted, "`check` and `convert` must agree: {messages:?}");
    }
}

/// Messages that waited for a decision are written after the messages of other channels, and the statistics count them.
#[test]
fn messages_without_keys_wait_for_a_decision() {
    let sent = r#"{"timestamp":9,"request_id":3}"#;
    let records = [
        file::channel(5, 0, "/robot/arming_check_request", "json", &[]),
        file::channel(6, 0, "/rope", "json", &[]),
        file::message(5, b"{}"),
        file::message(6, b"{\"length\":1}"),
        file::message(5, b"{\"robot\":2}"),
        file::message(6, b"{\"length\":3}"),
        file::message(5, sent.as_bytes()),
    ];
    let bytes = file::file(&records.concat());
    let conversion = try_converted(&bytes, release("px4@1.16"), "px4@1.17", Settings::default());
    let (report, output) = conversion.expect("a conversion");
    assert!(report.is_complete() && report.count(Action::Copied) == 2, "{}", report.to_text());
    let expected = ["{\"length\":1}", "{}", "{\"robot\":2}", "{\"length\":3}", sent];
    assert_eq!(payloads(&output), expected);
    let summary = ::mcap::Summary::read(&output).expect("a summary").expect("a summary");
    let counts = summary.stats.expect("statistics").channel_message_counts;
    assert_eq!(counts.into_iter().collect::<Vec<_>>(), [(5, 3), (6, 2)]);
}

#[test]
fn the_size_of_waiting_messages_is_limited() {
    let (blank, sent) = (vec![b' '; 17 << 20], br#"{"timestamp":9,"request_id":3}"#);
    let channel = |id, topic| file::channel(id, 0, topic, "json", &[]);
    let records = [
        channel(5, "/robot/arming_check_request"),
        channel(6, "/drone/arming_check_request"),
        file::message(5, &blank),
        file::message(5, sent),
        // The room is free again.
        file::message(6, b"{}"),
        file::message(6, sent),
    ];
    let bytes = file::file(&records.concat());
    let conversion = try_converted(&bytes, release("px4@1.16"), "px4@1.17", Settings::default());
    let (report, output) = conversion.expect("a conversion");
    let found: Vec<_> =
        report.topics.iter().map(|topic| (&*topic.topic, topic.action, topic.messages)).collect();
    let expected = [
        ("/drone/arming_check_request", Action::Converted, 2),
        ("/robot/arming_check_request", Action::Copied, 2),
    ];
    assert_eq!(found, expected);
    let reason = report.topics[1].reason.as_deref();
    assert_eq!(reason, Some("more than 16 MiB of messages precede the first non-empty one"));
    let lengths: Vec<usize> = payloads(&output).iter().map(String::len).collect();
    assert_eq!(lengths[..2], [blank.len(), sent.len()]);
    assert_eq!(lengths.len(), 3);
}

/// The problems in a report, without their offsets.
fn problems(report: &ConversionReport) -> Vec<&str> {
    report.problems.iter().filter_map(|problem| Some(problem.split_once(": ")?.1)).collect()
}

#[test]
fn the_first_declaration_of_an_id_is_used() {
    let records = [
        declarations(),
        file::message(5, &request(1)),
        // Chunks and the summary repeat declarations.
        declarations(),
        file::schema(9, "px4_msgs/msg/ArmingCheckRequest", "ros2msg", b"uint8 id\n"),
        file::channel(5, 9, "/winch", "cdr", &[]),
        file::message(5, &request(2)),
    ];
    let (report, output) = converted(&file::file(&records.concat()), "px4@1.17", Settings::default());
    let again = "is declared again with different content; the first declaration is used";
    assert_eq!(problems(&report), [format!("schema 9 {again}"), format!("channel 5 {again}")]);
    let found = checked(&output);
    assert_eq!((found.result.records, found.result.findings.groups().count()), (2, 0));
}

#[test]
fn names_are_limited() {
    let long = "x".repeat(257);
    let records = [
        declarations(),
        file::message(5, &request(1)),
        file::schema(2, &long, "ros2msg", b"uint8 id\n"),
        file::schema(3, "club_msgs/msg/Winch", &long, b"uint8 id\n"),
        file::channel(6, 0, &long, "cdr", &[]),
        file::channel(7, 0, "/winch", &long, &[]),
        file::message(6, &request(2)),
        file::message(7, &request(3)),
        metadata(&long),
        attachment(&long, b"text"),
    ];
    let (report, output) = converted(&file::file(&records.concat()), "px4@1.17", Settings::default());
    let name = "the topic or the encoding is longer than 256 bytes";
    let expected = [
        "schema 2: the name or the encoding is longer than 256 bytes",
        "schema 3: the name or the encoding is longer than 256 bytes",
        &format!("channel 6: {name}"),
        &format!("channel 7: {name}"),
    ];
    assert_eq!(problems(&report), expected);
    let found: Vec<_> = left_out(&report).map(|(topic, reason)| (topic.len(), reason)).collect();
    assert_eq!(found, [("/winch".len(), name), (256 + "…".len(), name)]);
    assert_eq!((checked(&output).result.records, others(&output).len()), (1, 2));
}

/// The topics whose only message was left out, with the reasons.
fn left_out(report: &ConversionReport) -> impl Iterator<Item = (&str, &str)> {
    let topics = report.topics.iter().filter(|topic| topic.action == Action::LeftOut && topic.messages == 1);
    topics.map(|topic| (&*topic.topic, topic.reason.as_deref().unwrap_or_default()))
}

#[test]
fn channels_without_their_schema_are_left_out() {
    let long = "x".repeat(257);
    let declare = |id: u16, schema: u16| {
        let topic = format!("/vehicle_{id}/fmu/out/arming_check_request");
        [file::channel(id, schema, &topic, "cdr", &[]), file::message(id, &request(1))].concat()
    };
    // Summaries repeat schemas.
    let schema = file::schema(2, &long, "ros2msg", b"uint8 id\n");
    let records = [declarations(), schema.clone(), declare(6, 2), declare(7, 77), schema];
    for keeps_unconverted in [false, true] {
        let settings = Settings { keeps_unconverted, ..Settings::default() };
        let (report, output) = converted(&file::file(&records.concat()), "px4@1.17", settings);
        let expected = [
            "schema 2: the name or the encoding is longer than 256 bytes",
            "channel 6: its schema 2 is left out",
            "channel 7: its schema 77 hasn't been declared yet",
        ];
        assert_eq!(problems(&report), expected);
        let expected = [
            ("/vehicle_6/fmu/out/arming_check_request", "its schema 2 is left out"),
            ("/vehicle_7/fmu/out/arming_check_request", "its schema 77 hasn't been declared yet"),
        ];
        assert_eq!(left_out(&report).collect::<Vec<_>>(), expected);
        assert_eq!(checked(&output).result.records, 0);
    }
}

#[test]
fn the_size_of_channels_and_names_is_limited() {
    let count = extent(10_001, 1_001);
    let channels = (0..count).map(|id| file::channel(id, 0, &format!("/winch_{id}"), "cdr", &[]));
    let (report, _) =
        converted(&file::file(&channels.collect::<Vec<_>>().concat()), "px4@1.17", Settings::default());
    assert_eq!((problems(&report), report.topics.len()), (Vec::new(), usize::from(count)));

    let large = "x".repeat(33 << 20);
    let channel = |id: u16| file::channel(id, 0, &format!("/winch_{id}"), "cdr", &[("text", large.as_str())]);
    let records = [channel(1), channel(2), file::message(2, &request(1)), metadata(&large)];
    let (report, output) = converted(&file::file(&records.concat()), "px4@1.17", Settings::default());
    let excess = "the schemas, channels and names take more than 64 MiB";
    let expected = [format!("channel 2: {excess}"), format!("a metadata record is left out: {excess}")];
    assert_eq!(problems(&report), expected);
    assert_eq!(left_out(&report).collect::<Vec<_>>(), [("/winch_2", excess)]);
    assert!(others(&output).is_empty());
}

#[test]
fn large_schemas_end_a_chunk() {
    let text = [&b"uint8 id\n#"[..], &b"x".repeat(3 << 20)].concat();
    let declare = |id: u16| {
        let schema = file::schema(id, &format!("club_msgs/msg/Winch{id}"), "ros2msg", &text);
        [schema, file::channel(id, id, &format!("/winch_{id}"), "cdr", &[])].concat()
    };
    let bytes = file::file(&(1..5).map(declare).collect::<Vec<_>>().concat());
    let (report, output) = converted(&bytes, "px4@1.17", Settings::default());
    assert_eq!((problems(&report), report.topics.len()), (Vec::new(), 4));
    let summary = ::mcap::Summary::read(&output).expect("a summary").expect("a summary");
    assert!(summary.chunk_indexes.len() > 1);
    assert_eq!(summary.channels.len(), 4);
}

/// PX4 1.14 and 1.15 have different failsafe flags of the same size.
#[test]
fn messages_of_an_unknown_release_are_left_out() {
    let payload = [&[0, 1, 0, 0][..], &[0; 85]].concat();
    let idl = &b"module px4_msgs { module msg { struct FailsafeFlags { uint64 timestamp; }; }; };"[..];
    for (encoding, text) in [("ros2msg", &b""[..]), ("ros2idl", idl), ("ros2msg", &b"Rope rope\n"[..])] {
        let records = [
            file::schema(9, "px4_msgs/msg/FailsafeFlags", encoding, text),
            file::channel(5, 9, "/failsafe_flags", "cdr", &[]),
            file::message(5, &payload),
        ];
        let bytes = file::file(&records.concat());
        let found = checked(&bytes).result;
        assert_eq!((found.records, found.checked, found.findings.groups().count()), (1, 0, 0), "{encoding}");
        let (report, output) = converted(&bytes, "px4@1.15", Settings::default());
        assert_eq!(report.count(Action::LeftOut), 1, "{}", report.to_text());
        assert!(report.to_text().contains("specify it with --from"), "{}", report.to_text());
        assert_eq!(checked(&output).result.records, 0);
        let (kept, _) =
            converted(&bytes, "px4@1.15", Settings { keeps_unconverted: true, ..Settings::default() });
        assert_eq!(kept.count(Action::Copied), 1, "{}", kept.to_text());
        let named = try_converted(&bytes, release("px4@1.15"), "px4@1.15", Settings::default());
        let (report, output) = named.expect("a conversion");
        assert_eq!(report.count(Action::Converted), 1, "{}", report.to_text());
        assert_eq!(checked(&output).result.records, 1);
    }
}

/// rosbag2 can compress each message.
#[test]
fn separately_compressed_messages_stay_compressed() {
    let packed = |id| compress_to_vec(&request(id)[..], CompressionLevel::Fastest);
    let records = [declarations(), file::message(5, &packed(1)), file::message(5, &packed(2))].concat();
    let (report, output) = converted(&file::file(&records), "px4@1.17", Settings::default());
    assert!(report.is_complete(), "{}", report.to_text());
    let messages = ::mcap::MessageStream::new(&output).expect("a bag");
    assert!(messages.into_iter().all(|message| message.expect("a message").data.starts_with(&ZSTD)));
    let found = checked(&output);
    assert_eq!((found.result.checked, found.result.findings.groups().count()), (2, 0));
}
