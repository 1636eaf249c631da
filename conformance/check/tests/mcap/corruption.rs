//! Tests of corrupt files: readable parts are checked, and unreadable parts are reported with their location.

use std::fs;
use std::io::{self, Read};

use uavspec_capture::mcap::{Event, Problem, Reader};
use uavspec_check::{Basis, CheckStatus, check_path};
use uavspec_model::Location;
use uavspec_rules::definitions::Library;
use uavspec_rules::sample::{Encoding, Flight};
use uavspec_test_captures::mcap::{
    FORMS, Form, MAGIC, channel, chunk, chunked, end, file, header, message, raw_chunk, record, schema,
    start, text,
};
use uavspec_test_support::{Pieces, Random, extent};

use super::{
    Glider, PERIOD, assert_conforms, checked, corrupt_count, declarations, declarations_of, good,
    records_with, violated,
};

fn glider(number: u64) -> Vec<u8> {
    message(3, &Glider::at(number * PERIOD).cdr())
}

/// Messages with these numbers.
fn gliders(numbers: std::ops::RangeInclusive<u64>) -> Vec<u8> {
    numbers.flat_map(glider).collect()
}

/// True if a location is within a file that has this length and contains sixty messages.
fn is_within(location: Location, length: usize) -> bool {
    match location {
        Location::Byte(offset) => offset <= length as u64,
        Location::Message(number) => (1..=60).contains(&number),
        Location::Channel(_) | Location::Endpoint(_) => true,
        Location::Line(_) => false,
    }
}

/// Asserts the reported corruption and the number of checked messages for a file that consists of these parts. An
/// expected problem consists of the index of the part at whose offset it must be reported, and of its text.
fn assert_corruption(parts: &[Vec<u8>], expected: &[(usize, &str)], checked_count: u64) {
    let result = checked(&parts.concat());
    let offset = |part: usize| parts[..part].iter().map(|part| part.len() as u64).sum();
    let expected: Vec<String> = expected
        .iter()
        .map(|(part, message)| format!("{}: {message}", Location::Byte(offset(*part))))
        .collect();
    assert_eq!(corrupt_count(&result), expected);
    assert_eq!((violated(&result), result.checked), (vec![], checked_count));
}

#[test]
fn skips_invalid_records() {
    let rest = [gliders(3..=4), end()].concat();
    let before = [start(), declarations(), gliders(1..=2)].concat();
    let huge = |opcode: u8| [&[opcode][..], &(1_u64 << 60).to_le_bytes(), &[7; 30]].concat();
    for (violated, message) in [
        (vec![0; 50], "a record of unknown kind 0x00 can't be 0 bytes long; skipped 50 bytes"),
        (huge(5), "a message can't be 1,152,921,504,606,846,976 bytes long; skipped 39 bytes"),
        (huge(3), "a schema can't be 1,152,921,504,606,846,976 bytes long; skipped 39 bytes"),
        (huge(6), "the field lengths in a chunk don't match its length; skipped 39 bytes"),
        (huge(9), "the field lengths in an attachment don't match its length; skipped 39 bytes"),
        (
            huge(0x99),
            "a record of unknown kind 0x99 can't be 1,152,921,504,606,846,976 bytes long; skipped 39 bytes",
        ),
        (record(2, &[&[0; 20]]), "the field lengths in a footer don't match its length; skipped 29 bytes"),
        (record(4, &[&[9; 40]]), "the field lengths in a channel don't match its length; skipped 49 bytes"),
        (
            [&[5][..], &5_000_u64.to_le_bytes(), &[3, 0, 1, 1]].concat(),
            "a message of 5,000 bytes is longer than the rest of the file; skipped 13 bytes",
        ),
        (
            [&[5][..], &100_u64.to_le_bytes(), &[3, 0, 1, 1]].concat(),
            "a message isn't followed by a valid record; skipped 13 bytes",
        ),
    ] {
        assert_corruption(&[before.clone(), violated, rest.clone()], &[(1, message)], 4);
    }
}

/// A record of an unknown kind may be a message whose kind was corrupted.
#[test]
fn reports_unknown_and_misplaced_records() {
    let mut longer = declarations();
    let added = channel(4, 0, "/other", "cdr", &[]);
    let body = [&added[9..], b"more"].concat();
    longer.extend(record(4, &[&body]));
    let private = record(0x81, &[&vec![0; 100_000]]);
    assert_corruption(&[start(), longer.clone(), private, glider(1), end()], &[], 1);
    let (unknown, header) = (record(0x42, &[b"what"]), header("ros2"));
    let inside = chunk(Form::Zstd, &[glider(2), unknown.clone(), glider(3)].concat());
    let known = "a record of unknown kind 0x42 isn't expected in this part of the file";
    for (violated, message, count) in [
        (unknown, known, 2),
        (inside, known, 4),
        (header, "a header isn't expected in this part of the file", 2),
        (record(0x0b, &[&[0; 60]]), "statistics isn't expected in this part of the file", 2),
        (
            chunk(Form::Plain, &record(7, &[&[3, 0], &[0; 4]])),
            "an index isn't expected in this part of the file",
            2,
        ),
    ] {
        let is_plain_chunk = message.starts_with("an index");
        let before = [start(), longer.clone(), glider(1)].concat();
        let result = checked(&[&before[..], &violated, &glider(4), &end()].concat());
        let found = corrupt_count(&result);
        let at = before.len() as u64 + if is_plain_chunk { 9 + 40 } else { 0 };
        assert_eq!(found, [format!("{}: {message}", Location::Byte(at))]);
        assert_eq!(result.checked, count, "{message}");
    }
    // Data after its end.
    let late = [record(15, &[&[0; 4]]), glider(2), record(2, &[&[0; 20]]), MAGIC.to_vec()].concat();
    let parts = [start(), longer, glider(1), late[..13].to_vec(), late[13..].to_vec()];
    assert_corruption(&parts, &[(4, "a message isn't expected in this part of the file")], 2);
}

/// One file may follow another. Their channels are independent.
#[test]
fn reads_files_that_follow_each_other() {
    let other = [channel(3, 0, "/rope", "cdr", &[]), declarations_of(7)].concat();
    let second = [other, message(7, &Glider::at(2 * PERIOD).cdr())].concat();
    let first = file(&[declarations(), glider(1)].concat());
    let result = checked(&[first.clone(), file(&second)].concat());
    assert_eq!((corrupt_count(&result), violated(&result)), (vec![], vec![]));
    assert_eq!((result.records, result.checked), (2, 2));
    let cut = file(&second);
    let result = checked(&[first, cut[..cut.len() - 30].to_vec()].concat());
    assert!(!result.corruption.is_empty());
    assert_eq!((result.records, result.checked), (2, 2));
}

#[test]
fn all_files_that_follow_each_other_show_the_release() {
    let release = Library::release("px4@1.15").expect("a release");
    let mut flight = Flight::new(release.base());
    // In quick mode, the flight contains only the first messages of a few topics.
    let topics = flight.topics.len().min(extent(usize::MAX, 40));
    flight.topics.truncate(topics);
    flight.messages.retain(|sent| sent.topic < topics);
    flight.messages.truncate(extent(usize::MAX, topics));
    let flight = Encoding::Mcap.write(&flight).expect("a bag");
    // In the flight, the same schema ids denote other types.
    let others = (1..20).map(|id| schema(id, "club_msgs/msg/Rope", "ros2msg", b"uint8 length\n"));
    let first = file(&others.collect::<Vec<_>>().concat());
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("flight.mcap");
    let library = Library::built_in();
    for bytes in [flight.clone(), [first, flight].concat()] {
        fs::write(&path, bytes).expect("a file");
        let found = check_path(&path, None, &library, &|input| input).expect("a bag");
        assert_eq!((found.definitions.name.as_str(), violated(&found.result)), ("PX4 1.15", vec![]));
    }
}

#[test]
fn skips_corrupt_chunks() {
    let rest = [gliders(5..=6), end()].concat();
    let before = [start(), declarations(), glider(1)].concat();
    let inner = gliders(2..=4);
    let checksum = crc32fast::hash(&inner);
    let length = inner.len() as u64;
    let packed = chunk(Form::Zstd, &inner);
    let packed = packed[9 + 40 + 4..].to_vec();
    let cut = &packed[..packed.len() - 10];
    let spoiled = [&inner[..], &[5, 255, 255, 255, 255, 255, 255, 255, 127, 1, 2]].concat();
    let whole = (packed.len() as u64, &packed[..]);
    let (short, long) = (length - 9, length + 9);
    let bytes_left = format!("a chunk contains {length} bytes, but its header says {long}");
    let wrong = format!(
        "a chunk has the checksum {checksum:08x}, but its header says 00000007: its content was changed"
    );
    for (violated, message, count) in [
        (
            raw_chunk("brotli", length, checksum, whole.0, whole.1),
            "a chunk uses the unknown compression `brotli`: expected zstd, lz4 or none",
            3,
        ),
        (raw_chunk("zstd", length, 7, whole.0, whole.1), &wrong, 6),
        (raw_chunk("", length, 7, length, &inner), &wrong, 6),
        (raw_chunk("zstd", long, checksum, whole.0, whole.1), &bytes_left, 6),
        (raw_chunk("zstd", short, 0, whole.0, whole.1), "a chunk has an invalid record after 214 bytes", 5),
        (
            raw_chunk("zstd", length, checksum, cut.len() as u64, cut),
            "decompression of a chunk fails after ",
            3,
        ),
        (
            raw_chunk("lz4", length, checksum, whole.0, whole.1),
            "decompression of a chunk fails after 0 bytes: ",
            3,
        ),
        (chunk(Form::Lz4, &spoiled), "a chunk has an invalid record after 321 bytes", 6),
        (
            raw_chunk("zstd", length, checksum, whole.0 + 5, whole.1),
            "the field lengths in a chunk don't match its length; ",
            3,
        ),
        (
            raw_chunk("", length + 1, checksum, length, &inner),
            "the field lengths in a chunk don't match its length; ",
            6,
        ),
    ] {
        let result = checked(&[&before[..], &violated, &rest].concat());
        let found = corrupt_count(&result);
        let location = Location::Byte(before.len() as u64);
        assert!(
            found.len() == 1 && found[0].starts_with(&format!("{location}: {message}")),
            "{message}: {found:#?}"
        );
        assert_eq!(result.checked, count, "{message}");
    }
}

#[test]
fn reads_a_truncated_chunk_to_its_end() {
    let mut endless = raw_chunk("", 1 << 60, 0, 1 << 60, &gliders(1..=5));
    endless[1..9].copy_from_slice(&((1_u64 << 60) + 40).to_le_bytes());
    let missing = (1_u64 << 60) - gliders(1..=5).len() as u64;
    let result = checked(&[start(), declarations(), endless].concat());
    let found = corrupt_count(&result);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("the file is truncated within a record"), "{found:?} {missing}");
    assert_eq!(result.checked, 5);
}

#[test]
fn reports_contradicting_declarations() {
    let other = channel(3, 0, "/glider", "json", &[]);
    let other_schema = schema(1, "Mark", "ros2msg", b"int16 height\n");
    let none = schema(0, "Mark", "ros2msg", b"int16 height\n");
    let lost = channel(8, 77, "/rope", "cdr", &[]);
    let large = schema(9, "Rope", "ros2msg", &b"#".repeat((1 << 20) + 1));
    let long = channel(10, 0, &"x".repeat(300), "cdr", &[]);
    let twice = [text(b"key"), text(b"1"), text(b"key"), text(b"2")].concat();
    let twice = record(4, &[&[12, 0, 0, 0], &text(b"/a"), &text(b"cdr"), &text(&twice)]);
    let no_text = record(4, &[&[12, 0, 0, 0], &text(b"/\xff"), &text(b"cdr"), &text(b"")]);
    let parts = [
        start(),
        declarations(),
        other,
        other_schema,
        none,
        message(4, b"what").repeat(3),
        lost,
        large,
        long,
        twice,
        no_text,
        declarations(),
        glider(1),
        end(),
    ];
    let unreadable =
        "a channel is unreadable: it is too short, or contains invalid UTF-8 or a duplicate key (2 times)";
    let expected = [
        (2, "channel 3 is declared again with different content; the first declaration is used"),
        (3, "schema 1 is declared again with different content; the first declaration is used"),
        (4, "a schema has the reserved id 0"),
        (5, "a message refers to channel 4, which hasn't been declared yet"),
        (6, "channel 8 refers to schema 77, which hasn't been declared yet"),
        (
            7,
            "schema 9 is too long to compare: it has 1048577 bytes; the limit is 1048576 bytes per schema \
             and 8388608 bytes in total",
        ),
        (8, "channel 10: the topic or the encoding is longer than 256 bytes"),
        (9, unreadable),
    ];
    assert_corruption(&parts, &expected, 1);
}

#[test]
fn reports_missing_headers_and_footers() {
    let body = [declarations(), glider(1)].concat();
    let ends_early = "the file ends without a footer: it is truncated, or its writer didn't finish";
    assert_corruption(&[start(), body.clone()], &[(2, ends_early)], 1);
    assert_corruption(
        &[MAGIC.to_vec(), body.clone(), end()],
        &[(1, "the file doesn't start with a header record")],
        1,
    );
    let mut no_magic = end();
    no_magic.truncate(no_magic.len() - 3);
    assert_corruption(
        &[start(), body.clone(), no_magic[..42].to_vec(), no_magic[42..].to_vec()],
        &[(3, ends_early), (3, "5 bytes follow the closing magic bytes")],
        1,
    );
    assert_corruption(
        &[start(), body.clone(), end(), vec![7; 7]],
        &[(3, "7 bytes follow the closing magic bytes")],
        1,
    );
    // Some storage adds zeros.
    assert_corruption(&[start(), body.clone(), end(), vec![0; 100_000]], &[], 1);
    let mut checksum = crc32fast::Hasher::new();
    checksum.update(&[start(), body.clone()].concat());
    let checksum = checksum.finalize();
    let closed =
        |stated: u32| [record(15, &[&stated.to_le_bytes()]), record(2, &[&[0; 20]]), MAGIC.to_vec()].concat();
    assert_corruption(&[start(), body.clone(), closed(checksum)], &[], 1);
    let message = format!(
        "the data has the checksum {checksum:08x}, but the file says {:08x}: its content was changed",
        checksum ^ 1
    );
    assert_corruption(&[start(), body, closed(checksum ^ 1)], &[(2, &message)], 1);
    assert_corruption(&[MAGIC.to_vec(), header("")], &[(2, ends_early)], 0);
}

/// Wherever a file is truncated, all messages before that point are checked. In a compressed chunk, the messages in
/// complete blocks are checked.
#[test]
fn checks_truncated_files_to_their_end() {
    for form in FORMS {
        let whole = file(&chunked(form, &records_with(&good().cdr())));
        let all = checked(&whole);
        assert_conforms(&all, &form);
        let mut last = 0;
        for cut in (8..whole.len() - 1).step_by(extent(97, 485)).chain([whole.len() - 1]) {
            let result = checked(&whole[..cut]);
            assert_eq!(violated(&result), [], "{form:?} {cut}");
            assert!(!result.corruption.is_empty(), "{form:?} {cut}");
            assert!(
                result.corruption.iter().all(|(location, _)| is_within(*location, cut)),
                "{form:?} {cut}"
            );
            assert!(result.checked >= last && result.checked == result.records, "{form:?} {cut}");
            last = result.checked;
        }
        assert!(last >= 29, "{form:?} {last}");
    }
}

/// A flipped bit causes the loss of at most a few messages or one chunk. If a checksum covers the bit, the corruption
/// is always reported.
#[test]
fn flipped_bits_lose_few_messages_and_fail_checksums() {
    let mut random = Random(11);
    for form in FORMS {
        let whole = file(&chunked(form, &records_with(&good().cdr())));
        let min = if form == Form::Unchunked { 50 } else { 29 };
        for _ in 0..extent(600, 45) {
            let mut bytes = whole.clone();
            let at = random.index(bytes.len() - 8) + 8;
            bytes[at] ^= 1 << random.below(8);
            let result = checked(&bytes);
            let is_declared = result.checked > 0;
            assert!(!is_declared || result.records >= min, "{form:?} {at} {}", result.records);
            for (location, message) in &result.corruption {
                assert!(is_within(*location, whole.len()), "{form:?} {at} {message}");
            }
            // Within a chunk, all data is covered by a checksum.
            let is_covered = form != Form::Unchunked && !violated(&result).is_empty();
            assert!(!is_covered || !result.corruption.is_empty(), "{form:?} {at} {:?}", violated(&result));
        }
    }
}

#[test]
fn noise_after_the_magic_is_corruption_only() {
    let mut random = Random(5);
    for round in 0..400 {
        let length = random.index(5_000);
        let mut noise = random.bytes(length);
        if round % 2 == 0 {
            // Small numbers result in plausible lengths.
            for byte in &mut noise {
                *byte = if *byte < 128 { 0 } else { *byte % 16 };
            }
        }
        let result = checked(&[MAGIC, &noise].concat());
        assert!(!result.corruption.is_empty());
        assert_eq!(result.checked, 0);
    }
}

/// The result doesn't depend on how the input is split.
#[test]
fn reads_the_same_from_any_split_of_the_input() {
    // A message that ends within another message: only the bytes after the other message show whether it is valid.
    let head = [&[5][..], &40_u64.to_le_bytes(), &[3, 0], &[0; 18]].concat();
    let nested = [start(), declarations(), gliders(1..=2), head, gliders(3..=4), end()].concat();
    let truncated = FORMS.map(|form| {
        let mut whole = file(&chunked(form, &records_with(&good().cdr())));
        whole.truncate(whole.len() - 60);
        whole
    });
    for whole in truncated.into_iter().chain([nested]) {
        let seen = |input: &mut dyn Read| -> Vec<String> {
            let mut reader = Reader::new(input);
            let mut seen = Vec::new();
            while let Some(item) = reader.next().expect("bytes") {
                seen.push(format!("{item:?}"));
            }
            seen
        };
        let expected = seen(&mut &whole[..]);
        for sizes in [vec![1], vec![0, 7, 3, 0, 1_000], vec![63]] {
            assert_eq!(seen(&mut Pieces { rest: &whole, sizes, turn: 0 }), expected);
        }
    }
}

/// A reader that returns some bytes, and then repeats a pattern endlessly. It records the size of the largest read
/// request.
struct Endless {
    start: Vec<u8>,
    pattern: Vec<u8>,
    position: usize,
    size: usize,
    largest_request: usize,
}

impl Read for &mut Endless {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.largest_request = self.largest_request.max(buffer.len());
        let rest = match self.position.checked_sub(self.start.len()) {
            None => &self.start[self.position..],
            Some(behind) => &self.pattern[behind % self.pattern.len()..],
        };
        let count = rest.len().min(buffer.len()).min(self.size - self.position);
        buffer[..count].copy_from_slice(&rest[..count]);
        self.position += count;
        Ok(count)
    }
}

/// Skipped records aren't stored. A stated length doesn't allocate memory before the bytes arrive.
#[test]
fn skips_records_in_constant_memory() {
    let length = |opcode: u8, length: u64| [&[opcode][..], &length.to_le_bytes()].concat();
    let data: u64 = 1 << 50;
    let attachment =
        [length(9, 16 + 4 + 4 + 8 + data + 4), vec![0; 24], data.to_le_bytes().to_vec()].concat();
    let mut plain = raw_chunk("", 1 << 50, 0, 1 << 50, b"");
    plain[1..9].copy_from_slice(&((1_u64 << 50) + 40).to_le_bytes());
    let zeros = vec![0; 1 << 16];
    let messages = gliders(1..=1).repeat(500);
    for (head, pattern, largest) in [
        (attachment, zeros.clone(), 1 << 17),
        (length(0, 0), zeros.clone(), 1 << 18),
        (length(5, 1 << 40), zeros.clone(), 1 << 18),
        (plain, messages.clone(), 1 << 17),
        (vec![], messages, 1 << 17),
        // A message of the maximum length is stored.
        (length(5, uavspec_capture::limits::MAX_RECORD), zeros, 3 * (64 << 20)),
    ] {
        // The size exceeds the maximum stored size, or suffices to fill the buffer many times.
        let size = if largest > 1 << 20 { extent(80 << 20, 66 << 20) } else { extent(8 << 20, 1 << 20) };
        let start = [start(), declarations(), head].concat();
        let mut input = Endless { start, pattern, position: 0, size, largest_request: 0 };
        let mut reader = Reader::new(&mut input);
        while let Some(item) = reader.next().expect("bytes") {
            if let Event::Problem(Problem::Skipped { length, .. }) = item.event {
                assert!(length <= size as u64);
            }
        }
        assert_eq!(reader.bytes(), size as u64);
        assert!(input.largest_request <= largest, "{}", input.largest_request);
    }
}

/// Channels beyond a limit are reported but not checked, because each channel needs memory and time.
#[test]
fn does_not_check_channels_beyond_the_limit() {
    let marks = "Mark[3000] more\nMark[3] marks\nbool[3] flags\n";
    let text = super::ros2msg(marks).replace("int16 height", "int16 height\nbool is_there");
    let (name, _) = super::ros("Glider");
    let mut records = schema(1, &name, "ros2msg", text.as_bytes());
    for id in 0..extent(2_000, 200) {
        records.extend(channel(id, 1, &format!("/tow/{id}/rope"), "cdr", &[]));
    }
    let result = checked(&file(&records));
    let statuses = super::source(&result).channels.iter().map(|channel| &channel.status);
    let refused = statuses.filter(|status| **status == CheckStatus::Checked(Basis::TooMany)).count();
    assert!(extent(1_500..2_000, 150..200).contains(&refused), "{refused}");
}
