//! Property tests of the reader with arbitrary bytes.

use proptest::collection::vec;
use proptest::prelude::*;
use uavspec_test_support::{Pieces, Writer, typical};

use super::seen::{problems, read, read_from};

/// Bytes that resemble a log.
fn bytes() -> impl Strategy<Value = Vec<u8>> {
    let part = prop_oneof![
        3 => (vec(any::<u8>(), 0..40), prop::sample::select(b"BFIMPQARDLCSOXz\0".to_vec())).prop_map(|(payload, kind)| {
            let mut log = Writer { bytes: Vec::new() };
            log.message(kind, &[&payload]);
            log.bytes
        }),
        3 => Just(typical(1)[16..].to_vec()),
        1 => vec(any::<u8>(), 0..60),
        1 => (0_usize..200).prop_map(|count| vec![0; count]),
        1 => Just(vec![8, 0, b'S', 0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12]),
    ];
    (prop::bool::weighted(0.9), vec(part, 0..12)).prop_map(|(has_header, parts)| {
        let mut bytes = if has_header { Writer::new(1).bytes } else { Vec::new() };
        bytes.extend(parts.concat());
        bytes
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn accounts_for_each_byte_of_arbitrary_input(bytes in bytes()) {
        read(&bytes);
        problems(&bytes);
    }

    #[test]
    fn reads_random_bytes_to_the_end(bytes in vec(any::<u8>(), 0..3_000)) {
        let mut log = Writer::with_flags();
        log.bytes.extend(bytes);
        read(&log.bytes);
        problems(&log.bytes);
    }

    #[test]
    fn returns_the_same_items_for_any_split_of_the_input(
        bytes in bytes(),
        sizes in vec(prop_oneof![1_usize..9, 1_usize..4_000, Just(0)], 1..8),
    ) {
        let sizes = if sizes.iter().all(|size| *size == 0) { vec![1] } else { sizes };
        let pieces = Pieces { rest: &bytes, sizes, turn: 0 };
        prop_assert_eq!(read_from(pieces), read(&bytes));
    }
}
