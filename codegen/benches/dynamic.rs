//! Benchmarks of `dynamic` messages, compared with generated types on the same bytes.
//!
//! Run with `cargo bench -p uavspec-codegen --bench dynamic`.

use std::sync::LazyLock;

use divan::counter::BytesCount;
use divan::{Bencher, black_box};
use serde::Serialize;
use uavspec_dynamic::{DynamicView, MessageType, Types};
use uavspec_runtime::UorbMessage;
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Form, PackageInput, SourceMap, read};
use uavspec_types::px4::{ArmingCheckReply, BatteryStatus, FailsafeFlags};

fn main() {
    divan::main();
}

static TYPES: LazyLock<Types> = LazyLock::new(|| {
    let mut sources = SourceMap::default();
    let mut package = PackageInput::new("px4", Form::Msg(Dialect::Px4), Vec::new());
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../definitions/px4");
    for entry in std::fs::read_dir(folder).expect("the definitions") {
        let path = entry.expect("a file").path();
        let text = std::fs::read(&path).expect("a readable file");
        package.sources.push(sources.add(path.to_string_lossy(), text).expect("a valid text"));
    }
    Types::new(&read(&sources, &[package]).0)
});

/// The type of a message, and a payload that contains no zero values.
fn input<T: UorbMessage>() -> (MessageType<'static>, Vec<u8>) {
    let of = TYPES.find(T::PACKAGE, T::NAME).expect("the type");
    // Floats are between 1 and 2, and text is ASCII.
    let payload: Vec<u8> = (0..T::SIZE).map(|at| [0x41, 0x42, 0xa5, 0x3f][at % 4]).collect();
    let payload = T::from_uorb(&payload).expect("a message").to_uorb();
    (of, payload.as_ref().to_vec())
}

/// Measures `$typed` and `$dynamic` on the same bytes.
macro_rules! pair {
    ($name:ident: $input:expr; $typed:expr, $dynamic:expr) => {
        mod $name {
            use super::*;

            #[divan::bench(types = [FailsafeFlags, BatteryStatus, ArmingCheckReply])]
            fn typed<T: UorbMessage + Serialize>(bencher: Bencher<'_, '_>) {
                let payload = $input(input::<T>());
                bencher
                    .counter(BytesCount::of_slice(&payload))
                    .bench_local(|| $typed(black_box(&payload[..])));
            }

            #[divan::bench(types = [FailsafeFlags, BatteryStatus, ArmingCheckReply])]
            fn dynamic<T: UorbMessage>(bencher: Bencher<'_, '_>) {
                let of = input::<T>().0;
                let payload = $input(input::<T>());
                bencher
                    .counter(BytesCount::of_slice(&payload))
                    .bench_local(|| $dynamic(of, black_box(&payload[..])));
            }
        }
    };
}

fn uorb((_, payload): (MessageType<'_>, Vec<u8>)) -> Vec<u8> {
    payload
}

fn cdr(order: ByteOrder) -> impl Fn((MessageType<'_>, Vec<u8>)) -> Vec<u8> {
    move |(of, payload)| of.view_uorb(&payload).and_then(|view| view.to_cdr(order)).expect("a payload")
}

const LITTLE: ByteOrder = ByteOrder::LittleEndian;
const BIG: ByteOrder = ByteOrder::BigEndian;

pair!(uorb_decode: uorb; T::from_uorb, MessageType::decode_uorb);
pair!(uorb_view: uorb; T::view, MessageType::view_uorb);
pair!(uorb_encode: uorb;
    |payload| T::from_uorb(payload).map(|message| message.to_uorb()),
    |of: MessageType<'static>, payload| of.view_uorb(payload).and_then(DynamicView::to_uorb));
pair!(cdr_decode: cdr(LITTLE); T::from_cdr, MessageType::decode_cdr);
pair!(cdr_decode_big_endian: cdr(BIG); T::from_cdr, MessageType::decode_cdr);
pair!(cdr_transcode: cdr(LITTLE);
    |payload| T::from_cdr(payload).map(|message| message.to_cdr(BIG)),
    |of: MessageType<'static>, payload| of.decode_cdr(payload).map(|message| message.to_cdr(BIG)));
pair!(cdr_encode_from_uorb: uorb;
    |payload| T::from_uorb(payload).map(|message| message.to_cdr(LITTLE)),
    |of: MessageType<'static>, payload| of.view_uorb(payload).and_then(|view| view.to_cdr(LITTLE)));
pair!(json_from_uorb: uorb;
    |payload| serde_json::to_string(&T::from_uorb(payload).expect("a message")),
    |of: MessageType<'static>, payload| of.view_uorb(payload).and_then(DynamicView::to_json_text));
pair!(validate_uorb: uorb;
    |payload| T::from_uorb(payload).expect("a message").validate().len(),
    |of: MessageType<'static>, payload| of.view_uorb(payload).expect("a message").validate().len());
