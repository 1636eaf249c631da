//! Tests of each problem, with logs that have only that problem.

use uavspec_capture::ulog::{Event, Reader};
use uavspec_test_support::Writer;

use super::seen::{problems, read};

/// A log that defines one topic with trailing padding and contains one message.
pub(crate) fn definitions() -> Writer {
    let mut log = Writer::with_flags();
    log.format("wind:uint64_t timestamp;float speed;uint8_t[4] _padding0;");
    log.subscribe(1, 0, "wind");
    log
}

/// Asserts that a log has exactly these problems, given by offset and text.
#[track_caller]
pub(crate) fn check(bytes: &[u8], expected: &[(u64, &str)]) {
    read(bytes);
    let expected: Vec<String> = expected.iter().map(|(offset, text)| format!("{offset}: {text}")).collect();
    assert_eq!(problems(bytes).0, expected);
}

#[test]
fn reads_all_kinds_of_messages_without_problems() {
    let mut log = definitions();
    log.entry(b'I', &[], "char[3] sys_name", b"PX4");
    log.entry(b'M', &[1], "uint8_t[2] parts", &[1, 2]);
    log.entry(b'P', &[], "float GAIN", &1.5_f32.to_le_bytes());
    log.entry(b'Q', &[3], "int32_t MODE", &7_i32.to_le_bytes());
    log.data(1, &[0; 16]);
    log.data(1, &[0; 12]);
    log.line("Höhe".as_bytes());
    log.message(b'C', &[b"3", &[9, 1], &5_u64.to_le_bytes(), b"tagged"]);
    log.sync();
    log.dropout(260);
    log.unsubscribe(1);
    check(&log.bytes, &[]);

    let mut reader = Reader::new(&log.bytes[..]);
    let mut found = Vec::new();
    while let Some(item) = reader.next().expect("a slice") {
        found.push(match item.event {
            Event::Data { id, payload } => format!("Data {id} {}", payload.len()),
            event => format!("{event:?}"),
        });
    }
    let expected = [
        "Start { version: 1, timestamp: 1000 }",
        "FlagBits { compatible: [0, 0, 0, 0, 0, 0, 0, 0], incompatible: [0, 0, 0, 0, 0, 0, 0, 0], appended: [0, 0, 0] }",
        "Format { name: \"wind\", fields: \"uint64_t timestamp;float speed;uint8_t[4] _padding0;\" }",
        "Subscription { multi_id: 0, id: 1, name: \"wind\" }",
        "Information { key: \"sys_name\", ty: \"char[3]\", value: [80, 88, 52] }",
        "MultiInformation { is_continued: true, key: \"parts\", ty: \"uint8_t[2]\", value: [1, 2] }",
        "Parameter { key: \"GAIN\", ty: \"float\", value: [0, 0, 192, 63] }",
        "DefaultParameter { defaults: 3, key: \"MODE\", ty: \"int32_t\", value: [7, 0, 0, 0] }",
        "Data 1 16",
        "Data 1 12",
        "Logging { level: 54, tag: None, timestamp: 5, text: \"Höhe\" }",
        "Logging { level: 51, tag: Some(265), timestamp: 5, text: \"tagged\" }",
        "Synchronisation",
        "Dropout { milliseconds: 260 }",
        "Unsubscription { id: 1 }",
    ];
    assert_eq!(found, expected);
}

#[test]
fn stops_at_an_invalid_header() {
    check(b"", &[(0, "expected a header of 16 bytes, found 0")]);
    check(&Writer::new(1).bytes[..15], &[(0, "expected a header of 16 bytes, found 15")]);
    check(
        b"ULog\x01\x12\x36\x01 and more",
        &[(0, "expected the magic bytes of ULog, found ULog\\x01\\x126")],
    );
    check(&Writer::new(1).bytes, &[]);
}

#[test]
fn reports_newer_versions_and_missing_flag_bits() {
    let mut log = Writer::new(2);
    log.flag_bits([0; 8], [0; 3], 0);
    check(&log.bytes, &[(7, "the log has version 2; versions up to 1 are supported")]);
    let mut log = Writer::new(0);
    log.sync();
    check(&log.bytes, &[(16, "the log has no flag bits (version 0)")]);
    let late = log.flag_bits([0xff; 8], [100; 3], 0);
    log.sync();
    check(
        &log.bytes,
        &[
            (16, "the log has no flag bits (version 0)"),
            (late, "flag bits are ignored unless they are the first message"),
        ],
    );
}

#[test]
fn reports_or_refuses_unknown_flag_bits() {
    let mut log = Writer::new(1);
    log.flag_bits([0; 8], [0; 3], 5);
    log.sync();
    check(&log.bytes, &[(16, "expected 40 bytes of flag bits, found 45; the rest are ignored")]);
    let mut log = Writer::new(1);
    log.flag_bits([1, 0, 4, 0, 0, 0, 0, 0], [0; 3], 0);
    log.sync();
    check(
        &log.bytes,
        &[(16, "the log uses unsupported features: incompatible bits [00, 00, 04, 00, 00, 00, 00, 00]")],
    );
}

#[test]
fn reports_a_log_that_ends_within_a_message() {
    let mut log = definitions();
    let last = log.data(1, &[0; 16]);
    let bytes = &log.bytes;
    check(
        &bytes[..bytes.len() - 1],
        &[(last, "the log is truncated within a `D` message, after 17 of 18 bytes")],
    );
    let cut = usize::try_from(last).expect("an offset") + 2;
    check(&bytes[..cut], &[(last, "the log is truncated within a message header, after 2 of 3 bytes")]);
}

#[test]
fn reads_appended_data() {
    let write = |offsets: [u64; 3], flag| {
        let mut log = Writer::new(1);
        log.flag_bits([flag, 0, 0, 0, 0, 0, 0, 0], offsets, 0);
        log.format("wind:uint64_t timestamp;float speed;uint8_t[4] _padding0;");
        log.subscribe(1, 0, "wind");
        log.data(1, &[0; 16]);
        let straddling = log.data(1, &[0; 16]);
        log.bytes.truncate(log.bytes.len() - 3);
        let first = log.offset();
        log.data(1, &[0; 16]);
        let second = log.offset();
        log.line(b"the second part");
        log.data(1, &[0; 12]);
        (log, straddling, first, second)
    };
    let (log, straddling, first, second) = write([0; 3], 0);
    // Without an offset of appended data, the message's size counts as wrong.
    check(
        &log.bytes,
        &[(straddling, &format!("no valid messages up to byte {first}, where valid messages follow"))],
    );
    let (log, ..) = write([first, second, 0], 1);
    check(
        &log.bytes,
        &[(straddling, &format!("a message is truncated by the data appended at byte {first}"))],
    );
    assert_eq!(problems(&log.bytes).1, 3);

    let (log, ..) = write([first, first, 5], 1);
    check(
        &log.bytes,
        &[
            (16, &format!("ignored an invalid offset of appended data: {first}")),
            (16, "ignored an invalid offset of appended data: 5"),
            (straddling, &format!("a message is truncated by the data appended at byte {first}")),
        ],
    );
    let (log, ..) = write([first, 100_000, u64::MAX], 1);
    check(
        &log.bytes,
        &[
            (16, "ignored an invalid offset of appended data: 18446744073709551615"),
            (straddling, &format!("a message is truncated by the data appended at byte {first}")),
            (log.offset(), "the log ends before the data appended at byte 100000"),
        ],
    );
    let (log, ..) = write([first, 0, 0], 0);
    assert_eq!(problems(&log.bytes).0[0], format!("16: ignored an invalid offset of appended data: {first}"));
}

#[test]
fn reports_data_lost_before_appended_data() {
    let mut log = Writer::new(1);
    log.flag_bits([1, 0, 0, 0, 0, 0, 0, 0], [100, 0, 0], 0);
    let noise = log.offset();
    log.bytes.resize(100, 0xff);
    log.dropout(1);
    check(&log.bytes, &[(noise, "no valid messages up to byte 100, where appended data starts")]);
}

#[test]
fn reports_unknown_kinds_once() {
    let mut log = definitions();
    log.data(1, &[0; 16]);
    let first = log.message(b'x', &[b"of the future"]);
    log.data(1, &[0; 16]);
    log.message(b'x', &[]);
    log.data(1, &[0; 16]);
    let other = log.message(0xc4, &[b"a kind that is no letter"]);
    log.data(1, &[0; 16]);
    log.message(b'x', &[b"at the end"]);
    check(
        &log.bytes,
        &[(first, "`x` is an unknown message kind"), (other, "`\\xc4` is an unknown message kind")],
    );
    assert_eq!(problems(&log.bytes).1, 4);
}

#[test]
fn drops_malformed_messages() {
    let cases: [(u8, &[u8], &str); 11] = [
        (b'F', b"no colon", "expected a name and a colon"),
        (b'F', b":uint8_t a;", "its name is empty"),
        (b'F', b"caf\xe9:uint8_t a;", "invalid UTF-8 at byte 3 of its payload"),
        (b'I', b"\x10int32_t a", "expected a key of 16 bytes, found 9 bytes"),
        (b'I', b"\x08int32_ta1234", "expected a type, a space and a name"),
        (b'P', b"\x08int32_t 1234", "its name is empty"),
        (b'M', b"\x00\x05int8\xff a", "invalid UTF-8 at byte 6 of its payload"),
        (b'A', b"\x00\x01\x00\xff", "invalid UTF-8 at byte 3 of its payload"),
        (b'L', b"6\0\0", "expected at least 9 bytes, found 3"),
        (b'O', b"", "expected at least 2 bytes, found 0"),
        (b'S', b"8 bytes.", "expected the magic bytes of a sync message"),
    ];
    for (kind, payload, text) in cases {
        let mut log = definitions();
        let at = log.message(kind, &[payload]);
        log.data(1, &[0; 16]);
        log.data(1, &[0; 16]);
        let kind = char::from(kind);
        check(&log.bytes, &[(at, &format!("skipped a `{kind}` message of {} bytes: {text}", payload.len()))]);
    }
}

#[test]
fn returns_unusual_messages_with_a_problem() {
    let mut log = definitions();
    let value = log.entry(b'I', &[], "int32_t a", b"12345");
    let text = log.entry(b'I', &[], "char[2] a", b"\xff\xfe");
    log.entry(b'M', &[1], "char[2] a", b"\xff\xfe");
    log.entry(b'I', &[], "wind_s[3] a", b"any");
    let line = log.line(b"caf\xe9 and more");
    log.sync();
    check(
        &log.bytes,
        &[
            (value, "`I` message: expected a value of 4 bytes, found 5"),
            (text, "`I` message: its string value is invalid UTF-8"),
            (line, "`L` message: invalid UTF-8 at byte 12 of its payload"),
        ],
    );
    let mut reader = Reader::new(&log.bytes[..]);
    let mut lines = Vec::new();
    while let Some(item) = reader.next().expect("a slice") {
        if let Event::Logging { text, .. } = item.event {
            lines.push(text.to_owned());
        }
    }
    assert_eq!(lines, ["caf"]);
}

#[test]
fn loses_no_messages_after_a_wrong_size() {
    let mut log = definitions();
    log.data(1, &[0; 16]);
    let wrong = log.data(1, &[0; 16]);
    let next = log.data(1, &[0; 16]);
    for _ in 0..300 {
        log.data(1, &[0; 16]);
    }
    let at = usize::try_from(wrong).expect("an index");
    // The size 18 becomes 4,114, so the message claims to contain the next 195 messages.
    log.bytes[at + 1] ^= 0x10;
    let skipped = format!("no valid messages up to byte {next}, where valid messages follow");
    check(&log.bytes, &[(wrong, &skipped)]);
    assert_eq!(problems(&log.bytes).1, 302);
    log.bytes[at + 1] ^= 0x10;
    // One more than the actual size.
    log.bytes[at] += 1;
    check(&log.bytes, &[(wrong, &skipped)]);
    // The size is one less, so one byte between messages remains.
    log.bytes[at] -= 2;
    check(
        &log.bytes,
        &[
            (wrong, "expected 16 or 12 bytes of data for id 1, found 15"),
            (next - 1, &format!("no valid messages up to byte {next}, where valid messages follow")),
        ],
    );
}

#[test]
fn reads_the_largest_messages() {
    let mut log = Writer::with_flags();
    log.format("block:uint8_t[65533] bytes;");
    log.subscribe(1, 0, "block");
    for round in 0..40 {
        log.data(1, &vec![round; 65_533]);
    }
    check(&log.bytes, &[]);
    assert_eq!(problems(&log.bytes).1, 40);
}

/// The size of a topic's messages may change, for example if only some are written with padding.
#[test]
fn returns_data_of_another_size_as_uncertain() {
    let mut log = definitions();
    for round in 0..40_usize {
        log.data(1, &[0; 16][..if round / 5 % 2 == 0 { 12 } else { 16 }]);
        log.line(b"between");
    }
    check(&log.bytes, &[]);
    assert_eq!(problems(&log.bytes).1, 40);
}
