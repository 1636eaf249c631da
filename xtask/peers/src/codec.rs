//! Decodes the same CDR payload many times.

use std::hint::black_box;

use byteorder::LittleEndian;
use serde::Deserialize;
use uavspec_types::px4::Event;
use uavspec_runtime::Message as _;
use uavspec_runtime::cdr::ByteOrder;

use crate::Result;

/// `Event`, with the derives that the peers require.
#[derive(Deserialize)]
#[allow(dead_code, reason = "only decoded")]
struct Derived {
    timestamp: u64,
    id: u32,
    event_sequence: u16,
    arguments: [u8; 25],
    log_levels: u8,
}

/// Decodes a message `count` times with a library. Returns `count`.
pub(crate) fn decode(library: &str, count: &str) -> Result<u64> {
    let count = count.parse()?;
    let event =
        Event { timestamp: 1_234_567_000, id: 1, arguments: [9; 25], log_levels: 51, event_sequence: 17 };
    let payload = event.to_cdr(ByteOrder::LittleEndian)?;
    let payload = || black_box(payload.as_slice());
    match library {
        "uavspec" => repeat(count, || Ok(Event::from_cdr(payload())?)),
        "cdr" => repeat(count, || Ok(cdr::deserialize::<Derived>(payload())?)),
        _ => repeat(count, || Ok(cdr_encoding::from_bytes::<Derived, LittleEndian>(&payload()[4..])?)),
    }
}

fn repeat<T>(count: u64, decode: impl Fn() -> Result<T>) -> Result<u64> {
    for _ in 0..count {
        black_box(decode()?);
    }
    Ok(count)
}
