//! Round trips of arbitrary values with arbitrary definitions.

use std::fmt::Write as _;

use proptest::prelude::*;
use proptest::sample::select;
use serde_json::Value as Json;
use uavspec_dynamic::{MessageType, Types};
use uavspec_runtime::cdr::{ByteOrder, HEADER};
use uavspec_schema::diagnostic::has_errors;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Form, Message, Schema, render};
use uavspec_test_definitions as support;

use super::values::Draw;

const SCALARS: [&str; 13] = [
    "bool", "char", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32",
    "float64", "Inner",
];
const STRINGS: [&str; 6] = ["byte", "string", "wstring", "string<=3", "wstring<=4", "Empty"];

/// The type of a field. Nested types are `Inner` and `Empty`.
fn field(dialect: Dialect) -> impl Strategy<Value = String> {
    let elements: Vec<&str> = match dialect {
        Dialect::Px4 => SCALARS.to_vec(),
        Dialect::Ros2 => SCALARS.iter().chain(&STRINGS).copied().collect(),
    };
    let shapes: &[&str] = match dialect {
        Dialect::Px4 => &["", "", "[1]", "[3]"],
        Dialect::Ros2 => &["", "", "[1]", "[3]", "[]", "[<=3]"],
    };
    (select(elements), select(shapes)).prop_map(|(element, shape)| format!("{element}{shape}"))
}

/// The definition of a message.
fn definition(dialect: Dialect, min: usize) -> impl Strategy<Value = String> {
    proptest::collection::vec(field(dialect), min..12).prop_map(|fields| {
        fields.iter().enumerate().fold(String::new(), |mut text, (index, ty)| {
            let _ = writeln!(text, "{ty} x{index}");
            text
        })
    })
}

fn schema(dialect: Dialect, outer: &str, inner: &str) -> Result<Schema, TestCaseError> {
    // `Outer` contains `Inner`, and `Inner` contains `Innermost`.
    let inner = inner.replace("Inner", "Innermost");
    let innermost = "uint8 a\nfloat64 b\nbool c\n";
    let files =
        [("Outer.msg", outer), ("Inner.msg", &inner), ("Innermost.msg", innermost), ("Empty.msg", "")];
    let (sources, schema, diagnostics) = support::texts(Form::Msg(dialect), &files);
    prop_assert!(!has_errors(&diagnostics), "{}", render::render(&diagnostics, &sources, false));
    Ok(schema)
}

fn check(schema: &Schema, seed: u64) -> Result<(), TestCaseError> {
    let types = Types::new(schema);
    for message in &schema.messages {
        let ty = types.find("demo", &message.name).expect("the type");
        let mut draw = Draw(seed);
        check_json(ty, &draw.message(schema, message))?;
        check_bytes(ty, message, &draw.message(schema, message))?;
        let default = ty.default();
        let read = ty.from_json(&default.to_json().expect("JSON")).expect("a message");
        prop_assert_eq!(read.to_json(), default.to_json());
    }
    Ok(())
}

/// Checks that a JSON tree, its text, and the text with reordered fields decode to the same message.
fn check_json(ty: MessageType<'_>, json: &Json) -> Result<(), TestCaseError> {
    let message = ty.from_json(json).map_err(|error| TestCaseError::fail(error.to_string()))?;
    prop_assert_eq!(&message.to_json().expect("JSON"), json);
    let view = ty.view_memory(message.memory()).expect("a message");
    prop_assert_eq!(&view.to_json().expect("JSON"), json);
    prop_assert_eq!(
        message.view().to_json_text().expect("JSON"),
        serde_json::to_string(&message).expect("JSON")
    );
    let payload = message.to_cdr(ByteOrder::LittleEndian).expect("a payload");
    let text = json.to_string();
    prop_assert!(message.size_in_memory() <= 8 * text.len(), "{} of {text}", message.size_in_memory());
    for text in [text, reversed(json).to_string()] {
        let message = ty.from_json_text(&text).map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert_eq!(message.to_cdr(ByteOrder::LittleEndian).expect("a payload"), &payload[..]);
    }
    Ok(())
}

/// Reverses the fields of all objects.
fn reversed(json: &Json) -> Json {
    match json {
        Json::Array(values) => values.iter().map(reversed).collect(),
        Json::Object(fields) => {
            fields.iter().rev().map(|(key, value)| (key.clone(), reversed(value))).collect()
        }
        other => other.clone(),
    }
}

fn check_bytes(ty: MessageType<'_>, message: &Message, json: &Json) -> Result<(), TestCaseError> {
    let value = ty.from_json(json).expect("a message");
    for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
        let payload = value.to_cdr(order).map_err(|error| TestCaseError::fail(error.to_string()))?;
        let size = payload.len() as u64;
        let min = message.cdr.min;
        prop_assert!(size == min || !message.cdr.is_fixed && size > min);
        for decoded in [ty.decode_cdr(&payload), ty.decode_cdr_strict(&payload)] {
            let decoded = decoded.map_err(|error| TestCaseError::fail(error.to_string()))?;
            prop_assert_eq!(&decoded.to_json().expect("JSON"), json);
            prop_assert_eq!(&decoded.to_cdr(order).expect("a payload"), &payload);
            let max = 8 * (payload.len() - HEADER);
            prop_assert!(decoded.size_in_memory() <= max, "{} of {max}", decoded.size_in_memory());
        }
        for end in 0..payload.len() {
            prop_assert!(ty.decode_cdr(&payload[..end]).is_err(), "{end} of {}", payload.len());
        }
    }
    prop_assert_eq!(ty.size().is_some(), message.uorb.is_some());
    let Some(layout) = &message.uorb else {
        prop_assert!(value.to_uorb().is_err() && ty.decode_uorb(&[]).is_err());
        return Ok(());
    };
    let payload = value.to_uorb().expect("a payload");
    prop_assert_eq!(payload.len(), layout.size);
    for payload in [&payload[..], &payload[..layout.size_no_padding]] {
        let decoded =
            ty.decode_uorb_strict(payload).map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert_eq!(&decoded.to_json().expect("JSON"), json);
        prop_assert_eq!(&ty.view_uorb(payload).expect("a message").to_json().expect("JSON"), json);
        prop_assert_eq!(decoded.to_uorb().expect("a payload").len(), layout.size);
    }
    Ok(())
}

/// A long message is encoded without a precomputed list of copies. Its `bool`s and padding must still be normalized as
/// in a short message.
#[test]
fn encodes_long_messages_like_short_ones() {
    let files = [
        ("Few.msg", "Pair[3] all\n"),
        ("Many.msg", "Pair[300] all\n"),
        ("Pair.msg", "uint64 a\nbool b\nbool c\n"),
    ];
    let (_, schema, _) = support::texts(Form::Msg(Dialect::Px4), &files);
    let types = Types::new(&schema);
    let [few, many] = ["Few", "Many"].map(|name| types.find("demo", name).expect("the type"));
    let payload = Draw(1).bytes(16 * 3);
    let few = few.decode_uorb(&payload).expect("a message");
    let many = many.decode_uorb(&payload.repeat(100)).expect("a message");
    let expected = few.to_uorb().expect("a payload");
    assert!(expected.chunks(16).all(|pair| pair[8] < 2 && pair[9] < 2 && pair[10..] == [0; 6]));
    assert_eq!(many.to_uorb().expect("a payload"), expected.repeat(100));
    for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
        let few = few.to_cdr(order).expect("a payload");
        // The padding that aligns the next pair.
        let filled = [&few[HEADER..], &[0; 6]].concat();
        let payload = many.to_cdr(order).expect("a payload");
        let end = HEADER + 99 * filled.len();
        assert_eq!(payload[..end], [&few[..HEADER], &filled.repeat(99)].concat());
        assert_eq!(payload[end..], few[HEADER..]);
        let ty = many.message_type();
        assert_eq!(ty.decode_cdr(&payload).expect("a message").to_uorb(), many.to_uorb());
        assert!(ty.decode_cdr(&payload[..payload.len() - 1]).is_err());
    }
}

proptest! {
    #![proptest_config(support::config(1000))]

    #[test]
    fn messages_of_px4_are_read_as_they_were_written(
        outer in definition(Dialect::Px4, 1), inner in definition(Dialect::Px4, 1), seed: u64
    ) {
        check(&schema(Dialect::Px4, &outer, &inner)?, seed)?;
    }

    #[test]
    fn messages_of_ros2_are_read_as_they_were_written(
        outer in definition(Dialect::Ros2, 0), inner in definition(Dialect::Ros2, 0), seed: u64
    ) {
        check(&schema(Dialect::Ros2, &outer, &inner)?, seed)?;
    }
}
