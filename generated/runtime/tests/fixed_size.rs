//! Codecs for fixed-size messages. The messages are written like generated code.

use uavspec_runtime::cdr::{ByteOrder, HEADER, is_padding};
use uavspec_runtime::{DecodeError, Definition, Fault, Message, Scalar, UorbMessage};

macro_rules! sample {
    ($type:ident, $cdr:literal { $($field:ident: $field_type:ty),* }) => {
        #[derive(Clone, Default, PartialEq)]
        struct $type {
            $($field: $field_type,)*
        }

        impl Message for $type {
            const DEFINITION: Definition =
                Definition { cdr_size: Some($cdr), ..Definition::new("samples", stringify!($type)) };
        }
    };
}

sample!(Empty, 5 {});

sample!(Hollow, 6 { e: Empty, x: u8 });

sample!(Hollows, 12 { few: [Empty; 3], x: u16, last: Hollow });

sample!(In, 9 { x: u16, flags: [bool; 3] });

sample!(Keyword, 5 { r#type: u8 });

sample!(Out, 29 { time: u64, share: f32, last: bool, ins: [In; 2] });

uavspec_runtime::record! {
    In[2], InView, 8, 5;
    0 x: u16 = uint16("x", 0);
    1 flags: uavspec_runtime::view::Elements<'b, bool, 3> = bool("flags", 2).array(3);
}

uavspec_runtime::record! {
    Out[4], OutView, 32, 32;
    0 time: u64 = uint64("time", 0);
    1 share: f32 = float32("share", 8);
    2 last: bool = bool("last", 12);
    3 ins: uavspec_runtime::view::Elements<'b, InView<'b>, 2> = message::<In>("ins", 16).array(2);
}

uavspec_runtime::record! {
    Empty[0];
}

uavspec_runtime::record! {
    Hollow[2];
    0 e = message::<Empty>("e", 0);
    1 x = uint8("x", 0);
}

uavspec_runtime::record! {
    Hollows[3];
    0 few = message::<Empty>("few", 0).array(3);
    1 x = uint16("x", 0);
    2 last = message::<Hollow>("last", 0);
}

uavspec_runtime::record! {
    Keyword[1];
    0 r#type = uint8("type", 0);
}

const ORDERS: [ByteOrder; 2] = [ByteOrder::LittleEndian, ByteOrder::BigEndian];

#[test]
fn the_debug_form_is_that_of_the_derive() {
    let message = Hollow { e: Empty {}, x: 7 };
    assert_eq!(format!("{message:?}"), "Hollow { e: Empty, x: 7 }");
    assert_eq!(format!("{message:#?}"), "Hollow {\n    e: Empty,\n    x: 7,\n}");
    let message = In { x: 1, flags: [true, false, true] };
    assert_eq!(format!("{message:?}"), "In { x: 1, flags: [true, false, true] }");
    // Fields have their names in the definition.
    assert_eq!(format!("{:?}", Keyword { r#type: 3 }), "Keyword { type: 3 }");
}

/// The decoding errors for a payload of zeros, truncated to each length that includes the header.
fn truncation_errors<T: Message + std::fmt::Debug>() -> Vec<String> {
    let size = T::CDR_SIZE.expect("a fixed size");
    let error = |order: ByteOrder, end: usize| {
        let payload = T::default().to_cdr(order).expect("a payload");
        assert_eq!(payload.len(), size);
        T::from_cdr(&payload[..end]).expect_err("too short").to_string()
    };
    let [little, big] = ORDERS.map(|order| (HEADER..size).map(|end| error(order, end)).collect::<Vec<_>>());
    assert_eq!(little, big);
    little
}

#[test]
fn decodes_messages_without_fields_as_one_byte() {
    let hollows = Hollows { x: 0x1112, last: Hollow { x: 9, ..Hollow::default() }, ..Hollows::default() };
    for order in ORDERS {
        let payload = hollows.to_cdr(order).expect("a payload");
        assert_eq!(Hollows::from_cdr(&payload).as_ref(), Ok(&hollows));
        assert_eq!(Hollows::from_cdr_strict(&payload).as_ref(), Ok(&hollows));
    }
}

#[test]
fn locates_truncation_in_messages_without_fields() {
    assert_eq!(truncation_errors::<Empty>(), ["Empty at byte 4: expected 1 more byte, found 0"]);
    assert_eq!(
        truncation_errors::<Hollow>(),
        ["e at byte 4: expected 1 more byte, found 0", "x at byte 5: expected 1 more byte, found 0"]
    );
    assert_eq!(
        truncation_errors::<Hollows>(),
        [
            "few[0] at byte 4: expected 1 more byte, found 0",
            "few[1] at byte 5: expected 1 more byte, found 0",
            "few[2] at byte 6: expected 1 more byte, found 0",
            "x at byte 7: expected 2 more bytes, found 0",
            "x at byte 8: expected 2 more bytes, found 0",
            "x at byte 8: expected 2 more bytes, found 1",
            "last.e at byte 10: expected 1 more byte, found 0",
            "last.x at byte 11: expected 1 more byte, found 0",
        ]
    );
}

fn out() -> Out {
    Out {
        time: 0x0102_0304_0506_0708,
        share: 0.3,
        last: true,
        ins: [In { x: 0x1112, flags: [true, false, true] }, In { x: 0x2122, flags: [false, true, true] }],
    }
}

/// The payload, preceded by `by` bytes. Prefixes of 0 to 7 bytes cover all alignments.
fn shifted(payload: &[u8], by: usize) -> Vec<u8> {
    [&[0xaa; 8][..by], payload].concat()
}

#[test]
fn decodes_and_encodes_at_any_alignment() {
    let out = out();
    for by in 0..8 {
        let buffer = shifted(&out.to_uorb(), by);
        assert_eq!(Out::from_uorb(&buffer[by..]).as_ref(), Ok(&out));
        assert_eq!(Out::from_uorb_strict(&buffer[by..]).as_ref(), Ok(&out));
        check_view(&out, &buffer[by..]);
        for order in ORDERS {
            let payload = out.to_cdr(order).expect("a payload");
            let mut buffer = shifted(&payload, by);
            assert_eq!(Out::from_cdr(&buffer[by..]).as_ref(), Ok(&out));
            assert_eq!(Out::from_cdr_strict(&buffer[by..]).as_ref(), Ok(&out));
            buffer.fill(0xaa);
            assert_eq!(out.encode_cdr(order, &mut buffer[by..]), Ok(payload.len()));
            assert_eq!(buffer[by..], payload);
        }
    }
}

#[cfg(not(feature = "views"))]
fn check_view(_: &Out, _: &[u8]) {}

/// Checks that the view of `payload` returns the fields of `out`.
#[cfg(feature = "views")]
#[allow(clippy::float_cmp)] // exact comparison is intended
fn check_view(out: &Out, payload: &[u8]) {
    let view = Out::view(payload).expect("a payload");
    assert_eq!((view.time(), view.share(), view.last()), (out.time, out.share, out.last));
    assert_eq!((view.ins().len(), view.ins().is_empty()), (out.ins.len(), false));
    for (seen, expected) in view.ins().iter().zip(&out.ins) {
        assert_eq!(seen.x(), expected.x);
        assert!(seen.flags().iter().eq(expected.flags));
        assert!((0..3).all(|index| seen.flags().get(index) == Some(expected.flags[index])));
        assert_eq!(seen.flags().get(3), None);
        assert_eq!(format!("{:?}", seen.flags()), format!("{:?}", expected.flags));
    }
    assert_eq!(view.ins().get(1).map(InView::x), Some(out.ins[1].x));
    assert_eq!(&Out::from_view(view), out);
}

/// The path of each `bool`, and its byte offsets in memory and in CDR.
const BOOLS: [(&str, usize, usize); 7] = [
    ("last", 12, 16),
    ("ins[0].flags[0]", 18, 20),
    ("ins[0].flags[1]", 19, 21),
    ("ins[0].flags[2]", 20, 22),
    ("ins[1].flags[0]", 26, 26),
    ("ins[1].flags[1]", 27, 27),
    ("ins[1].flags[2]", 28, 28),
];

/// An invalid byte for a `bool`, different for each offset.
fn invalid_bool(at: usize) -> u8 {
    2 + u8::try_from(at).expect("few bytes")
}

#[test]
fn strict_decoding_reports_path_and_offset_of_an_invalid_bool() {
    for (index, (path, in_memory, in_cdr)) in BOOLS.into_iter().enumerate() {
        // The error reports the first invalid `bool`.
        let after = &BOOLS[index..];
        let mut payload = out().to_uorb();
        for (_, at, _) in after {
            payload[*at] = invalid_bool(*at);
        }
        check_invalid(Out::from_uorb_strict(&payload), path, in_memory);
        check_true(&Out::from_uorb(&payload), after);
        for order in ORDERS {
            let mut payload = out().to_cdr(order).expect("a payload");
            for (_, _, at) in after {
                payload[*at] = invalid_bool(*at);
            }
            check_invalid(Out::from_cdr_strict(&payload), path, in_cdr);
            check_true(&Out::from_cdr(&payload), after);
        }
    }
}

fn check_invalid(read: Result<Out, DecodeError>, path: &str, offset: usize) {
    let error = read.expect_err("an invalid bool");
    assert_eq!((error.path.to_string().as_str(), error.offset), (path, offset));
    assert_eq!(error.fault, Fault::Bool(invalid_bool(offset)));
}

/// Checks that lenient decoding reads each invalid `bool` as true and leaves other values unchanged.
fn check_true(read: &Result<Out, DecodeError>, invalid: &[(&str, usize, usize)]) {
    let mut expected = out();
    let flags = expected.ins.iter_mut().flat_map(|part| &mut part.flags);
    let all = [&mut expected.last].into_iter().chain(flags);
    all.skip(BOOLS.len() - invalid.len()).for_each(|flag| *flag = true);
    assert_eq!(read, &Ok(expected));
}

#[test]
fn padding_ends_at_a_multiple_of_four_bytes() {
    let max = |end: usize| (0..9).filter(|left| is_padding(end, *left)).max();
    assert_eq!([8, 9, 10, 11].map(max), [Some(0), Some(3), Some(2), Some(1)]);
}

#[test]
fn integer_types_have_bounds() {
    for (name, bounds) in [
        ("bool", None),
        ("byte", Some((0, 255))),
        ("char", Some((0, 255))),
        ("int8", Some((-128, 127))),
        ("uint8", Some((0, 255))),
        ("int16", Some((-32_768, 32_767))),
        ("uint16", Some((0, 65_535))),
        ("int32", Some((-0x8000_0000, 0x7fff_ffff))),
        ("uint32", Some((0, 0xffff_ffff))),
        ("int64", Some((i64::MIN.into(), i64::MAX.into()))),
        ("uint64", Some((0, u64::MAX.into()))),
        ("float32", None),
        ("float64", None),
    ] {
        let scalar = Scalar::from_name(name).expect("a type");
        assert_eq!((scalar.name(), scalar.integer_bounds()), (name, bounds));
    }
}
