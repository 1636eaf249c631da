//! Measures how fast three logs from the corpus are read, with their messages repeated, and how fast invalid bytes are
//! searched.
//!
//! `cargo bench -p uavspec --bench ulog`

use std::fs;
use std::io::Read;
use std::path::Path;

use divan::counter::BytesCount;
use divan::{Bencher, black_box};
use uavspec_capture::ulog::{Event, Log, Reader};

fn main() {
    divan::main();
}

const LOGS: [&str; 3] = ["sample", "sample_log_small", "sample_logging_tagged_and_default_params"];

/// The minimum size of a log, in bytes. The log is so large that caches and the start of the log have little effect.
const SIZE: usize = 64 << 20;

/// A log in which everything after the file header is repeated. `None` without the corpus.
fn log(name: &str) -> Option<Vec<u8>> {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/corpus");
    let corpus = std::env::var_os("UAVSPEC_CORPUS").map_or(default, Into::into);
    let log = fs::read(corpus.join(format!("ulog/{name}.ulg"))).ok()?;
    let (header, messages) = log.split_at_checked(16)?;
    let mut bytes = header.to_vec();
    while bytes.len() < SIZE {
        bytes.extend(messages);
    }
    Some(bytes)
}

/// Copies the bytes through a buffer as large as the reader's. The result is the maximum speed of any reader.
#[divan::bench(args = LOGS)]
fn copy(bencher: Bencher<'_, '_>, name: &str) {
    let Some(bytes) = log(name) else { return };
    let mut buffer = vec![0; Reader::<&[u8]>::CAPACITY];
    bencher.counter(BytesCount::of_slice(&bytes)).bench_local(|| {
        let mut input = &bytes[..];
        while input.read(&mut buffer).expect("a slice") > 0 {
            black_box(&buffer);
        }
    });
}

/// Splits a log into messages.
#[divan::bench(args = LOGS)]
fn messages(bencher: Bencher<'_, '_>, name: &str) {
    let Some(bytes) = log(name) else { return };
    bencher.counter(BytesCount::of_slice(&bytes)).bench_local(|| count_messages(&bytes));
}

/// Splits a log into messages, and determines the type of each data message.
#[divan::bench(args = LOGS)]
fn records(bencher: Bencher<'_, '_>, name: &str) {
    let Some(bytes) = log(name) else { return };
    bencher.counter(BytesCount::of_slice(&bytes)).bench_local(|| {
        let (mut reader, mut log) = (Reader::new(&bytes[..]), Log::default());
        let mut count = 0_u64;
        while let Some(item) = reader.next().expect("a slice") {
            if let Some(record) = log.take(&item, &mut |_, problem| drop(black_box(problem))) {
                count += record.message_type.view_uorb(record.payload).map_or(0, |_| 1);
            }
        }
        count
    });
}

/// Searches for messages in bytes that contain none.
#[divan::bench(args = ["zeros", "noise", "letters"])]
fn search(bencher: Bencher<'_, '_>, name: &str) {
    let mut bytes = b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0".to_vec();
    let mut state = 1_u64;
    bytes.extend((0..SIZE / 4).map(|_| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        match name {
            "zeros" => 0,
            "noise" => state.to_be_bytes()[0],
            // At every offset, the bytes could be the header of a log line.
            _ => b"L0"[usize::from(state & 2 != 0)],
        }
    }));
    bencher.counter(BytesCount::of_slice(&bytes)).bench_local(|| count_messages(&bytes));
}

fn count_messages(bytes: &[u8]) -> u64 {
    let mut reader = Reader::new(bytes);
    let mut count = 0;
    while let Some(item) = reader.next().expect("a slice") {
        if let Event::Data { id, payload } = item.event {
            count += u64::from(black_box(id)) + black_box(payload).len() as u64;
        }
    }
    count
}
