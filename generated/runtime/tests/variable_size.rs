//! Codecs for variable-size messages: strings, sequences, bounds, and messages without fields. The definitions in this
//! repository have no such messages. The message types in this file are hand-written and mirror what the generator
//! emits.

use proptest::collection::vec;
use proptest::prelude::*;
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::{Definition, Fault, Message};

macro_rules! sample {
    ($type:ident { $($field:ident: $field_type:ty),* }) => {
        #[derive(Clone, Default, PartialEq)]
        struct $type {
            $($field: $field_type,)*
        }

        impl Message for $type {
            const DEFINITION: Definition = Definition::new("samples", stringify!($type));
        }
    };
}

sample!(Sample {
    flag: bool,
    name: String,
    wide: String,
    numbers: Vec<f64>,
    few: Vec<u16>,
    points: Vec<Point>,
    pair: [Point; 2],
    empty: Empty,
    empties: Vec<Empty>,
    names: Vec<String>
});

sample!(Point { tag: u8, label: String, x: u64 });

sample!(Label { tag: u8, wide: String });

sample!(Empty {});

uavspec_runtime::record! {
    Sample[10];
    0 flag = bool("flag", 0);
    1 name = string("name", 0).at_most(5);
    2 wide = wstring("wide", 0);
    3 numbers = float64("numbers", 0).sequence();
    4 few = uint16("few", 0).bounded(3);
    5 points = message::<Point>("points", 0).sequence();
    6 pair = message::<Point>("pair", 0).array(2);
    7 empty = message::<Empty>("empty", 0);
    8 empties = message::<Empty>("empties", 0).sequence();
    9 names = string("names", 0).at_most(4).bounded(2);
}

uavspec_runtime::record! {
    Point[3];
    0 tag = uint8("tag", 0);
    1 label = string("label", 0);
    2 x = uint64("x", 0);
}

uavspec_runtime::record! {
    Label[2];
    0 tag = uint8("tag", 0);
    1 wide = wstring("wide", 0);
}

uavspec_runtime::record! {
    Empty[0];
}

const ORDERS: [ByteOrder; 2] = [ByteOrder::LittleEndian, ByteOrder::BigEndian];

fn text(length: usize) -> impl Strategy<Value = String> {
    vec(any::<char>().prop_filter("a NUL ends a string", |character| *character != '\0'), 0..=length)
        .prop_map(String::from_iter)
}

fn point() -> impl Strategy<Value = Point> {
    (any::<u8>(), text(6), any::<u64>()).prop_map(|(tag, label, x)| Point { tag, label, x })
}

fn sample() -> impl Strategy<Value = Sample> {
    let texts = (text(5), text(9), vec(text(4), 0..=2));
    let numbers = (any::<bool>(), vec(any::<f64>(), 0..9), vec(any::<u16>(), 0..=3));
    let points = (vec(point(), 0..4), [point(), point()], vec(Just(Empty {}), 0..9));
    (texts, numbers, points).prop_map(
        |((name, wide, names), (flag, numbers, few), (points, pair, empties))| Sample {
            flag,
            name,
            wide,
            numbers,
            few,
            points,
            pair,
            empty: Empty {},
            empties,
            names,
        },
    )
}

/// A payload with all kinds of fields.
fn payload(order: ByteOrder) -> Vec<u8> {
    let point = |label: &str| Point { tag: 1, label: label.to_owned(), x: 7 };
    let sample = Sample {
        flag: true,
        name: "größe".to_owned(),
        wide: "a\u{1F681}b".to_owned(),
        numbers: vec![1.5, -0.0],
        few: vec![1, 2, 3],
        points: vec![point("one"), point("")],
        pair: [point("left"), point("right")],
        empty: Empty {},
        empties: vec![Empty {}; 3],
        names: vec!["ab".to_owned()],
    };
    sample.to_cdr(order).expect("all within bounds")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn decodes_what_it_encoded(sample in sample()) {
        prop_assert!(sample.validate().is_empty());
        for order in ORDERS {
            let bytes = sample.to_cdr(order).expect("all within bounds");
            let read = Sample::from_cdr_strict(&bytes).expect("an encoded message");
            prop_assert_eq!(read.to_cdr(order).expect("all within bounds"), bytes);
            prop_assert_eq!(read.names, sample.names.clone());
        }
    }

    #[test]
    fn decodes_random_bytes_or_reports_an_offset_within_them(mut bytes in vec(any::<u8>(), 0..200), big: bool) {
        if let [first, second, ..] = bytes.as_mut_slice() {
            (*first, *second) = (0, u8::from(!big));
        }
        check_decoding(&bytes);
    }

    #[test]
    fn decodes_a_corrupt_payload_or_reports_an_offset_within_it(at in 4..300_usize, byte: u8, big: bool) {
        let mut bytes = payload(ORDERS[usize::from(big)]);
        let at = at % bytes.len();
        bytes[at] = byte;
        check_decoding(&bytes);
    }
}

/// Maximum number of allocated bytes per byte of payload.
///
/// A vector with one element has a capacity of four. The capacity of a longer vector is at most twice its length. The
/// worst case is therefore a list with one element: an empty string, which takes four bytes in CDR, or a point, which
/// takes at least 13 bytes. Numbers take as much memory as in CDR, and text takes less than twice as much as in CDR.
const MAX_ALLOCATION: usize = {
    let (string, point) = (4 * size_of::<String>() / 4, (4 * size_of::<Point>()).div_ceil(13));
    if string > point { string } else { point }
};

/// Number of bytes that a message allocates on the heap.
fn allocated(sample: &Sample) -> usize {
    let labels = sample.points.iter().chain(&sample.pair).map(|point| &point.label);
    let strings = [&sample.name, &sample.wide].into_iter().chain(&sample.names).chain(labels);
    capacity(&sample.numbers)
        + capacity(&sample.few)
        + capacity(&sample.points)
        + capacity(&sample.empties)
        + capacity(&sample.names)
        + strings.map(String::capacity).sum::<usize>()
}

/// Capacity of a vector in bytes. Zero for elements of zero size, although their capacity is unlimited.
fn capacity<T>(values: &Vec<T>) -> usize {
    values.capacity().saturating_mul(size_of::<T>())
}

/// Checks that a decoded message survives encoding and decoding, or that the offset of the error is within the payload.
fn check_decoding(bytes: &[u8]) {
    match Sample::from_cdr(bytes) {
        Ok(sample) => {
            let allocated = allocated(&sample);
            assert!(allocated <= MAX_ALLOCATION * bytes.len(), "{allocated} bytes for {}", bytes.len());
            assert!(sample.empties.len() <= bytes.len());
            let again = sample.to_cdr(ByteOrder::LittleEndian).expect("a decoded message can be encoded");
            let read = Sample::from_cdr(&again).expect("an encoded message can be decoded");
            assert_eq!(read.to_cdr(ByteOrder::LittleEndian), Ok(again));
        }
        Err(error) => assert!(error.offset <= bytes.len(), "{error}"),
    }
}

#[test]
fn decodes_and_encodes_at_any_alignment() {
    for order in ORDERS {
        let bytes = payload(order);
        let sample = Sample::from_cdr(&bytes).expect("a payload");
        for by in 0..8 {
            let mut buffer = [&[0xaa; 8][..by], &bytes].concat();
            assert_eq!(Sample::from_cdr(&buffer[by..]).as_ref(), Ok(&sample));
            assert_eq!(Sample::from_cdr_strict(&buffer[by..]).as_ref(), Ok(&sample));
            buffer.fill(0xaa);
            assert_eq!(sample.encode_cdr(order, &mut buffer[by..]), Ok(bytes.len()));
            assert_eq!(buffer[by..], bytes);
        }
    }
}

#[test]
fn reports_the_offset_of_each_truncation() {
    for order in ORDERS {
        let bytes = payload(order);
        for end in 0..bytes.len() {
            let error = Sample::from_cdr(&bytes[..end]).expect_err("too short");
            assert!(error.offset <= end, "{end}: {error}");
        }
    }
    let bytes = payload(ByteOrder::LittleEndian);
    let error = Sample::from_cdr(&bytes[..bytes.len() - 1]).expect_err("too short");
    assert_eq!(error.to_string(), "names[0] at byte 192: expected 3 more bytes, found 2");
}

#[test]
fn rejects_lengths_beyond_the_payload_before_allocating() {
    for order in ORDERS {
        let bytes = payload(order);
        for at in (4..bytes.len() - 3).step_by(4) {
            for length in [u32::MAX, i32::MAX.unsigned_abs(), 1 << 24] {
                let mut bytes = bytes.clone();
                let length =
                    if order == ByteOrder::BigEndian { length.to_be_bytes() } else { length.to_le_bytes() };
                bytes[at..at + 4].copy_from_slice(&length);
                check_decoding(&bytes);
            }
        }
    }
}

#[test]
fn encoding_decoding_and_validation_enforce_bounds() {
    let long = |few: usize, name: &str, names: &[&str]| Sample {
        few: vec![0; few],
        name: name.to_owned(),
        names: names.iter().map(|name| (*name).to_owned()).collect(),
        ..Sample::default()
    };
    for (sample, path, bound, found) in [
        (long(4, "", &[]), "few", 3, 4),
        (long(0, "sechs!", &[]), "name", 5, 6),
        (long(0, "", &["a", "b", "c"]), "names", 2, 3),
        (long(0, "", &["a", "fünf!"]), "names[1]", 4, 5),
    ] {
        let error = sample.to_cdr(ByteOrder::LittleEndian).expect_err("over the bound");
        assert_eq!((error.fault, error.path.to_string().as_str()), (Fault::TooLong { bound, found }, path));
        let violations = sample.validate();
        assert_eq!(violations.len(), 1, "{violations:?}");
        assert_eq!((violations[0].rule.id(), violations[0].path.to_string().as_str()), ("PX-CDR-02", path));
    }
    let mut bytes = long(0, "five5", &[]).to_cdr(ByteOrder::LittleEndian).expect("within the bound");
    assert_eq!(bytes[8..12], [6, 0, 0, 0], "the length of the name");
    bytes[8] = 7;
    bytes.splice(17..18, [b'!', 0]);
    let error = Sample::from_cdr(&bytes).expect_err("over the bound");
    assert_eq!(error.to_string(), "name at byte 8: expected at most 5, found 6");
}

/// The expected bytes follow the encoding of `rosidl_typesupport_fastrtps`.
#[test]
fn encodes_code_units_of_wide_strings_in_four_bytes() {
    let label = Label { tag: 7, wide: "a\u{1F681}".to_owned() };
    let little =
        [[0, 1, 0, 0], [7, 0, 0, 0], [3, 0, 0, 0], [0x61, 0, 0, 0], [0x3d, 0xd8, 0, 0], [0x81, 0xde, 0, 0]];
    let big =
        [[0, 0, 0, 0], [7, 0, 0, 0], [0, 0, 0, 3], [0, 0, 0, 0x61], [0, 0, 0xd8, 0x3d], [0, 0, 0xde, 0x81]];
    for (order, bytes) in ORDERS.into_iter().zip([little, big]) {
        assert_eq!(label.to_cdr(order).as_deref(), Ok(bytes.as_flattened()));
        assert_eq!(Label::from_cdr(bytes.as_flattened()).as_ref(), Ok(&label));
    }
    // An unpaired surrogate, and three code units instead of four.
    for (count, error) in [
        (2, "wide at byte 8: expected a Unicode string, found invalid bytes"),
        (4, "wide at byte 12: expected 16 more bytes, found 12"),
    ] {
        let mut bytes = little;
        bytes[2][0] = count;
        assert_eq!(Label::from_cdr(bytes.as_flattened()).expect_err("an invalid string").to_string(), error);
    }
}

#[test]
fn rejects_invalid_strings() {
    let bytes = payload(ByteOrder::LittleEndian);
    for (at, byte, expected) in [
        (12, 0xff, "name at byte 8: expected a Unicode string, found invalid bytes"),
        (13, 0, "name at byte 8: expected a string with a single NUL at the end"),
        (29, 0xdc, "wide at byte 20: expected a Unicode string, found invalid bytes"),
        (33, 0xd8, "wide at byte 20: expected a Unicode string, found invalid bytes"),
        (26, 1, "wide at byte 20: expected a Unicode string, found invalid bytes"),
        (35, 1, "wide at byte 20: expected a Unicode string, found invalid bytes"),
    ] {
        let mut bytes = bytes.clone();
        bytes[at] = byte;
        assert_eq!(Sample::from_cdr(&bytes).expect_err("an invalid string").to_string(), expected);
    }
    let sample = Sample { name: "a\0b".to_owned(), ..Sample::default() };
    assert_eq!(sample.to_cdr(ByteOrder::LittleEndian).expect_err("an invalid string").fault, Fault::Nul);
}

#[test]
fn reports_the_required_size_of_a_buffer() {
    let bytes = payload(ByteOrder::LittleEndian);
    let sample = Sample::from_cdr(&bytes).expect("a payload");
    let mut buffer = vec![0xaa; bytes.len() - 1];
    let error = sample.encode_cdr(ByteOrder::LittleEndian, &mut buffer).expect_err("too small");
    assert_eq!(error.fault, Fault::Buffer { needed: bytes.len(), room: bytes.len() - 1 });
    buffer = vec![0xaa; bytes.len() + 1];
    assert_eq!(sample.encode_cdr(ByteOrder::LittleEndian, &mut buffer), Ok(bytes.len()));
    assert_eq!(buffer[..bytes.len()], bytes, "padding is zero");
}
