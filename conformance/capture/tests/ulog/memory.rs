//! Tests that memory doesn't grow with the log.

use std::io::{self, Read};

use uavspec_capture::ulog::{Event, Log, Problem, Reader};
use uavspec_test_support::{Writer, extent, typical};

/// The number of bytes that a test reads. These bytes fill the buffer many times.
fn size() -> u64 {
    extent(64 << 20, 6 << 20)
}

/// The largest buffer, which has room to look ahead.
const MAX_CAPACITY: usize = 4 * Reader::<&[u8]>::CAPACITY;

/// A reader that returns some bytes and then repeats a pattern, up to a size.
struct Endless {
    start: Vec<u8>,
    pattern: Vec<u8>,
    position: u64,
    size: u64,
    largest_request: usize,
}

impl Read for &mut Endless {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.largest_request = self.largest_request.max(buffer.len());
        let start = self.start.len() as u64;
        let rest = if self.position < start {
            &self.start[usize::try_from(self.position).expect("an index")..]
        } else {
            let at = (self.position - start) % self.pattern.len() as u64;
            &self.pattern[usize::try_from(at).expect("an index")..]
        };
        let left = usize::try_from(self.size - self.position).expect("a size");
        let count = rest.len().min(buffer.len()).min(left);
        buffer[..count].copy_from_slice(&rest[..count]);
        self.position += count as u64;
        Ok(count)
    }
}

/// Reads a log that starts with `start` and then repeats `pattern`. Returns the number of data messages, and the
/// problems.
fn count(start: Vec<u8>, pattern: &[u8]) -> (u64, Vec<Problem>) {
    let pattern = pattern.repeat((1 << 20) / pattern.len());
    let mut input = Endless { start, pattern, position: 0, size: size(), largest_request: 0 };
    let mut reader = Reader::new(&mut input);
    let mut log = Log::default();
    let (mut records, mut problems) = (0, Vec::new());
    while let Some(item) = reader.next().expect("bytes") {
        if let Event::Problem(problem) = &item.event {
            problems.push(problem.clone());
        }
        records += u64::from(log.take(&item, &mut |_, problem| panic!("{problem}")).is_some());
    }
    assert!(reader.capacity() <= MAX_CAPACITY, "{} bytes", reader.capacity());
    assert!(input.largest_request <= MAX_CAPACITY);
    assert_eq!(input.position, size());
    (records, problems)
}

#[test]
fn reads_endless_data_in_constant_memory() {
    let mut log = Writer::with_flags();
    log.format("block:uint64_t timestamp;uint8_t[992] bytes;");
    log.subscribe(3, 0, "block");
    let mut message = Writer { bytes: Vec::new() };
    message.data(3, &[7; 1000]);
    let start = log.bytes.len() as u64;
    let (records, problems) = count(log.bytes, &message.bytes);
    assert_eq!(records, (size() - start) / 1005);
    assert!(matches!(problems[..], [Problem::EndsInPayload { kind: b'D', size: 1002, .. }]), "{problems:?}");
}

#[test]
fn searches_endless_zeros_in_constant_memory() {
    let (records, problems) = count(Writer::with_flags().bytes, &[0; 4096]);
    assert_eq!(records, 0);
    assert!(matches!(problems[..], [Problem::Skipped { to, .. }] if to == size()), "{problems:?}");
}

/// A reader that fails at regular intervals, and returns one byte at a time.
struct Failing<'b> {
    rest: &'b [u8],
    is_failing: bool,
}

impl Read for Failing<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.is_failing = !self.is_failing && self.rest.len().is_multiple_of(100);
        if self.is_failing {
            return Err(io::ErrorKind::TimedOut.into());
        }
        let Some((byte, rest)) = self.rest.split_first() else { return Ok(0) };
        buffer[0] = *byte;
        self.rest = rest;
        Ok(1)
    }
}

#[test]
fn continues_after_an_input_error() {
    let mut log = typical(3);
    // Bytes that require a search.
    log.extend([0xff; 300]);
    let mut expected = Vec::new();
    let mut reader = Reader::new(&log[..]);
    while let Some(item) = reader.next().expect("a slice") {
        expected.push(format!("{item:?}"));
    }
    let mut reader = Reader::new(Failing { rest: &log, is_failing: false });
    let (mut found, mut errors) = (Vec::new(), 0);
    loop {
        match reader.next() {
            Ok(Some(item)) => found.push(format!("{item:?}")),
            Ok(None) => break,
            Err(error) => {
                assert_eq!(error.kind(), io::ErrorKind::TimedOut);
                errors += 1;
            }
        }
    }
    assert_eq!(found, expected);
    assert!(errors >= log.len() / 100, "{errors} errors");
}

#[test]
fn returns_messages_of_a_slow_input_without_delay() {
    let log = typical(3);
    // The input fails after the bytes that have arrived.
    let arrived = &log[..1_000];
    let mut reader = Reader::new(arrived.chain(Failing { rest: &[], is_failing: false }));
    let mut end = 0;
    while let Ok(Some(item)) = reader.next() {
        end = item.offset;
    }
    // The last message is returned only after the next header has arrived.
    assert!(end > 850, "the last message starts at {end}");
}
