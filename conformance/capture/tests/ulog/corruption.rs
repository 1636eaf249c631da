//! Tests of corrupt logs: all messages before the corruption and most messages after it are read.

use std::collections::HashSet;
use std::fs;

use uavspec_capture::ulog::{Problem, Resync};
use uavspec_test_support::{Random, Writer, extent, shared as corpus, typical};

use super::seen::{Seen, problems, read};

/// The messages of a log.
fn messages(bytes: &[u8]) -> Vec<Seen> {
    read(bytes).into_iter().filter(Seen::is_message).collect()
}

/// The offsets at which messages end.
fn ends(bytes: &[u8], messages: &[Seen]) -> Vec<u64> {
    messages.iter().skip(1).map(|message| message.offset).chain([bytes.len() as u64]).collect()
}

/// The number of messages that appear both in `before` and, `shift` bytes later, in `after`.
fn shared(before: &[Seen], after: &[Seen], shift: u64) -> usize {
    let after: HashSet<(u64, u64)> = after.iter().map(|seen| (seen.offset, seen.digest)).collect();
    before.iter().filter(|seen| after.contains(&(seen.offset + shift, seen.digest))).count()
}

#[test]
fn reads_a_truncated_log_to_its_end() {
    let log = typical(20);
    let whole = messages(&log);
    let ends = ends(&log, &whole);
    for cut in (16..log.len()).step_by(97) {
        let seen = read(&log[..cut]);
        let complete = ends.iter().take_while(|end| **end <= cut as u64).count();
        let position = complete.checked_sub(1).map_or(16, |last| ends[last]);
        let left = cut as u64 - position;
        let found: Vec<&Seen> = seen.iter().filter(|seen| seen.is_message()).collect();
        assert_eq!(found, whole[..complete].iter().collect::<Vec<_>>(), "cut at {cut}");
        let last = seen.last().expect("an item");
        match (&last.problem, left) {
            (None, 0) => {}
            (Some(Problem::EndsInHeader { found }), 1..3) => assert_eq!(*found as u64, left),
            (Some(Problem::EndsInPayload { found, .. }), _) => assert_eq!(*found as u64 + 3, left),
            // If the cut is in the first message, the reader reports missing flag bits.
            (Some(Problem::NoFlagBits { .. }), _) if complete == 0 => {}
            other => panic!("cut at {cut}: {other:?}"),
        }
        assert!(left == 0 || last.offset == position, "cut at {cut}: {last:?}");
    }
}

#[test]
fn finds_most_messages_after_a_flipped_bit() {
    let log = typical(12);
    let whole = messages(&log);
    let ends = ends(&log, &whole);
    let mut random = Random(20);
    let mut lost = 0;
    let flips = extent(1_000, 200);
    for _ in 0..flips {
        let at = 16 + random.index(log.len() - 16);
        let mut corrupt = log.clone();
        corrupt[at] ^= 1 << random.below(8);
        let found = messages(&corrupt);
        let before = ends.iter().take_while(|end| **end <= at as u64).count();
        // The message before the corruption may be uncertain.
        let certain = before.saturating_sub(1);
        assert_eq!(found[..certain], whole[..certain], "flipped at {at}");
        let missing = whole.len() - shared(&whole, &found, 0);
        assert!(missing >= 1, "flipped at {at}");
        assert!(missing <= 12, "flipped at {at}: {missing} messages missing");
        lost += missing;
        problems(&corrupt);
    }
    assert!(lost < extent(1_200, 400), "{lost} messages were lost by {flips} flipped bits");
}

#[test]
fn finds_most_messages_of_corrupt_real_logs() {
    let Some(logs) = corpus("corpus/ulog") else { return };
    let mut random = Random(25);
    let names = ["sample", "sample_log_small", "sample_logging_tagged_and_default_params"];
    for (at, name) in names.into_iter().enumerate() {
        let log = fs::read(logs.join(format!("{name}.ulg"))).expect("a log");
        let whole = messages(&log);
        // Corrupts forty places after the definitions. Each of these changes affects one or two messages.
        let first = log.len() / 8;
        let step = (log.len() - first) / 40;
        for round in 0..4 {
            let mut corrupt = log.clone();
            for part in 0..40 {
                let start = first + part * step + random.index(step - 40);
                let noise = if round == 3 { vec![0; 25] } else { random.bytes(4 + 13 * round) };
                corrupt[start..start + noise.len()].copy_from_slice(&noise);
            }
            // In quick mode, only one corrupt copy of each log is read. The length of the noise differs between the
            // logs.
            if round != extent(round, at) {
                continue;
            }
            let missing = whole.len() - shared(&whole, &messages(&corrupt), 0);
            assert!((30..=70).contains(&missing), "{name}: {missing} of {} are missing", whole.len());
        }
    }
}

#[test]
fn finds_most_messages_after_inserted_bytes() {
    let log = typical(12);
    let whole = messages(&log);
    let mut random = Random(21);
    let mut lost = 0;
    let rounds = extent(300, 90);
    for round in 0..rounds {
        let at = 16 + random.index(log.len() - 16);
        let size = 1 + random.index(if round % 10 == 0 { 200_000 } else { 2_000 });
        let mut corrupt = log[..at].to_vec();
        corrupt.extend(random.bytes(size));
        corrupt.extend(&log[at..]);
        let found = messages(&corrupt);
        let before = whole.partition_point(|message| message.offset < at as u64);
        let kept = shared(&whole[..before], &found, 0) + shared(&whole[before..], &found, size as u64);
        assert!(whole.len() - kept <= 12, "{size} bytes at {at}: {} messages", whole.len() - kept);
        lost += whole.len() - kept;
        problems(&corrupt);
    }
    // Most insertions split a message, which can't be recovered.
    let expected = extent(280..330, 60..140);
    assert!(expected.contains(&lost), "{lost} messages were lost by {rounds} insertions");
}

#[test]
fn finds_most_messages_after_removed_bytes() {
    let log = typical(12);
    let whole = messages(&log);
    let mut random = Random(22);
    for _ in 0..300 {
        let from = 16 + random.index(log.len() - 3_000);
        let size = 1 + random.index(2_500);
        let corrupt = [&log[..from], &log[from + size..]].concat();
        let found = messages(&corrupt);
        let before = whole.partition_point(|message| message.offset < from as u64);
        let after = whole.partition_point(|message| message.offset < (from + size) as u64);
        let kept = shared(&whole[..before], &found, 0);
        let moved: Vec<Seen> =
            found.into_iter().map(|seen| Seen { offset: seen.offset + size as u64, ..seen }).collect();
        let kept = kept + shared(&whole[after..], &moved, 0);
        let missing = before + whole.len() - after - kept;
        assert!(missing <= 12, "{size} bytes from {from}: {missing} messages");
    }
}

#[test]
fn reads_sections_in_the_wrong_order() {
    let log = typical(6);
    let whole = messages(&log);
    let first_data = whole.iter().find(|message| message.kind == "data").expect("data").offset;
    let middle = usize::try_from(first_data).expect("an offset");
    let swapped = [&log[..16], &log[middle..], &log[16..middle]].concat();
    let seen = read(&swapped);
    // All messages are read, except for the flag bits, which are only valid at the start.
    assert_eq!(seen.iter().filter(|seen| seen.is_message()).count(), whole.len());
    let odd: Vec<_> = seen.iter().filter_map(|seen| seen.problem.as_ref()).collect();
    assert_eq!(odd, [&Problem::NoFlagBits { version: 1 }, &Problem::FlagBitsNotFirst]);
    let (found, records) = problems(&swapped);
    assert_eq!(records, 0);
    assert_eq!(found.iter().filter(|found| found.contains("which isn't subscribed")).count(), 120);
    assert_eq!(found.iter().filter(|found| found.contains("6 messages with id")).count(), 20);
}

#[test]
fn finds_a_log_surrounded_by_noise() {
    let log = typical(10);
    let mut random = Random(23);
    let size = extent(3_000_000, 800_000);
    for (name, noise) in
        [("random", random.bytes(size)), ("zeros", vec![0; size]), ("ones", vec![0xff; size])]
    {
        let mut bytes = Writer::with_flags().bytes;
        let start = bytes.len();
        bytes.extend(&noise);
        bytes.extend(&log[start..]);
        bytes.extend(&noise);
        let found = messages(&bytes);
        let whole = messages(&log);
        let kept = shared(&whole[1..], &found, noise.len() as u64);
        assert!(whole.len() - 1 - kept <= 2, "{name}: {kept} of {}", whole.len() - 1);
    }
}

/// The inputs maximize the work of the search, or contain uncertain messages.
#[test]
fn reads_hostile_bytes_in_linear_time() {
    let size = extent(1_000_000, 80_000);
    let mut doubtful = Writer { bytes: Vec::new() };
    doubtful.message(b'D', &[&vec![b'F'; 60_000]]);
    doubtful.bytes.push(0);
    let mut unknown = Writer { bytes: Vec::new() };
    unknown.message(b'x', &[]);
    let mut violated = Writer { bytes: Vec::new() };
    for _ in 0..3 {
        violated.message(b'O', &[&[0; 2]]);
    }
    violated.bytes.push(0xff);
    let patterns: [(&str, Vec<u8>); 9] = [
        ("random", Random(24).bytes(10 * size)),
        ("zeros", vec![0; 10 * size]),
        ("overlapping headers of formats", vec![b'F']),
        ("overlapping headers of data", vec![b'D']),
        ("overlapping headers of lines", b"L0".to_vec()),
        ("overlapping small headers", b"\x00\x00D".to_vec()),
        ("uncertain sizes", doubtful.bytes),
        ("unknown kinds", unknown.bytes),
        ("sequences that are too short", violated.bytes),
    ];
    for (name, pattern) in patterns {
        let mut bytes = Writer::with_flags().bytes;
        bytes.extend(pattern.iter().cycle().take(pattern.len().max(size)));
        // A quadratic search would take hours.
        eprintln!("{name}: {} items", read(&bytes).len());
    }
}

#[test]
fn reports_how_reading_resumed() {
    let mut log = Writer::with_flags();
    let noise = log.offset();
    log.bytes.extend([0xff; 50]);
    let sync = log.sync();
    let more_noise = log.offset();
    log.bytes.extend([0xff; 70]);
    let run = log.format("a:uint8_t a;");
    for _ in 0..3 {
        log.dropout(1);
    }
    let last_noise = log.offset();
    log.bytes.extend([0xff; 90]);
    let seen = read(&log.bytes);
    let skipped: Vec<_> = seen.iter().filter_map(|seen| Some((seen.offset, seen.problem.clone()?))).collect();
    let expected = [
        (noise, Problem::Skipped { to: sync, resync: Resync::Synchronisation }),
        (more_noise, Problem::Skipped { to: run, resync: Resync::Messages }),
        (last_noise, Problem::Skipped { to: log.offset(), resync: Resync::End }),
    ];
    assert_eq!(skipped, expected);
}
