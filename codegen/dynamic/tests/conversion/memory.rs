//! Compares conversions in memory with the reference, which converts JSON.

use proptest::prelude::*;
use uavspec_dynamic::conversion::{Conversion, Conversions, Converter, LossKind};
use uavspec_dynamic::limits::MAX_CONVERTED;
use uavspec_dynamic::{DynamicMessage, Types};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::Schema;
use uavspec_schema::msg::Dialect;
use uavspec_test_definitions::{config, extent};

use super::corpus::{CORPUS, releases};
use super::reference::convert_json;
use super::support::{Converted, convert, convert_dialect};

/// Decodes messages from random bytes, converts each in memory and as JSON, and compares the results.
/// Returns the number of compared messages.
fn compare(schema: &Schema, types: &Types, conversion: &Conversion, mut next: impl FnMut() -> u8) -> usize {
    let [source, target] = [conversion.from, conversion.to].map(|id| types.get(id));
    let (Some(size), initial) = (source.size(), target.default().to_json().expect("JSON")) else { return 0 };
    let converter = Converter::new(conversion, source, target);
    let mut count = 0;
    // The second mask excludes invalid text and infinite numbers, which JSON can't represent.
    for mask in [0xff, 0x3f] {
        let payload: Vec<u8> = (0..size.padded).map(|_| next() & mask).collect();
        let message = source.decode_uorb(&payload).expect("a message");
        let result = converter.convert(&message).expect("a message");
        assert!(
            result
                .to_uorb()
                .is_ok_and(|payload| Some(payload.len()) == target.size().map(|size| size.padded))
        );
        let (Ok(json), Ok(result)) = (message.to_json(), result.to_json()) else { continue };
        let expected = convert_json(schema, conversion, &json, &initial);
        assert_eq!(result, expected, "{}: {json}", source.name());
        count += 1;
    }
    count
}

#[test]
fn converts_messages_of_all_releases_like_the_reference() {
    let Some(corpus) = &*CORPUS else { return };
    let types = Types::new(&corpus.schema);
    let (mut state, mut count) = (7_u64, 0);
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        state.to_le_bytes()[5]
    };
    for (at, old) in releases().iter().enumerate() {
        for new in &releases()[at + 1..] {
            let further;
            let found = if let Some(found) = corpus.neighbours.get(&[*old, *new]) {
                found
            } else {
                let found = Conversions::within(&corpus.schema, old, new, &corpus.hints);
                further = found.expect("both packages");
                &further
            };
            for conversion in found.forward.iter().chain(&found.backward) {
                count += compare(&corpus.schema, &types, conversion, &mut next);
            }
        }
    }
    assert!(count > extent(7000, 400), "{count}");
}

const OLD: &str = "string name
string[] labels
string[<=2] few
Part[] parts
Part[2] pair
uint8[] bytes
float32[<=3] speeds
Part part
int32 number
wstring wide
";

const NEW: &str = "int16 number
Part[2] pair
uint8[] bytes
string<=3 name
wstring wide
string[] labels
string[<=2] few
string added \"as defined\"
int32[] numbers [1, 2, 3]
Part[<=2] parts
float32[<=2] speeds
Part part
";

const OLD_PART: &str = "uint8 id\nstring text\n";

const NEW_PART: &str = "string[] notes [\"one\", \"two\"]\nuint32 id\nstring text\nfloat64 weight 1.5\n";

fn varying() -> Converted {
    let hints = "[[hint]]\nmessage = \"Glider\"\nnarrow = { number = \"nearest\" }\n\
                 [[hint]]\nmessage = \"Part\"\nnarrow = { id = \"neutral\" }\n";
    convert_dialect(
        Dialect::Ros2,
        &[("Glider", OLD), ("Part", OLD_PART)],
        &[("Glider", NEW), ("Part", NEW_PART)],
        hints,
    )
}

proptest! {
    #![proptest_config(config(200))]

    #[test]
    fn converts_strings_and_sequences_like_the_reference(
        name in ".{0,5}",
        labels in prop::collection::vec("[a-zé]{0,4}", 0..3),
        few in prop::collection::vec("[a-z]{0,4}", 0..3),
        parts in prop::collection::vec((any::<u8>(), "[a-zé]{0,4}"), 3..6),
        bytes in prop::collection::vec(any::<u8>(), 0..5),
        speeds in prop::collection::vec(-9.5_f32..9.5, 0..4),
        number in any::<i32>(),
    ) {
        let part = |(id, text): &(u8, String)| serde_json::json!({"id": id, "text": text});
        let parts: Vec<serde_json::Value> = parts.iter().map(part).collect();
        let message = serde_json::json!({
            "name": name, "labels": labels, "few": few, "parts": parts[2..], "pair": parts[..2],
            "bytes": bytes, "speeds": speeds, "part": parts[0], "number": number, "wide": name,
        });
        let found = varying();
        let (there, back) = (found.forward("Glider"), found.backward("Glider"));
        let types = Types::new(&found.schema);
        let message = types.get(there.from).from_json(&message).expect("a message").to_json().expect("JSON");
        // `run` compares each conversion with the reference.
        let converted = found.run(there, &message);
        found.run(back, &converted);
    }
}

#[test]
fn limits_counts_of_cut_arrays_whose_type_changes() {
    let count = |length: u32, ty: &str| format!("{ty} count  # [@count items]\nuint8[{length}] items\n");
    for (old, new, hint) in
        [("uint8", "uint32", ""), ("uint32", "uint8", "nearest"), ("uint32", "uint8", "neutral")]
    {
        let hints = format!("[[hint]]\nmessage = \"Tank\"\nnarrow = {{ count = \"{hint}\" }}\n");
        let hints = if hint.is_empty() { "" } else { &hints };
        let found = convert(&[("Tank", &count(5, old))], &[("Tank", &count(2, new))], hints);
        let converted =
            found.run(found.forward("Tank"), &serde_json::json!({"count": 4, "items": [1, 2, 3, 4, 0]}));
        assert_eq!(converted, serde_json::json!({"count": 2, "items": [1, 2]}));
    }
}

#[test]
fn the_neutral_value_of_a_count_is_not_limited() {
    let count = |length: u32, ty: &str| {
        format!("{ty} count  # [@count items] [@invalid 255]\nuint8[{length}] items\n")
    };
    let hints = "[[hint]]\nmessage = \"Tank\"\nnarrow = { count = \"neutral\" }\n";
    let found = convert(&[("Tank", &count(5, "uint32"))], &[("Tank", &count(2, "uint8"))], hints);
    let converted =
        found.run(found.forward("Tank"), &serde_json::json!({"count": 300, "items": [1, 2, 3, 4, 0]}));
    assert_eq!(converted, serde_json::json!({"count": 255, "items": [1, 2]}));
}

#[test]
fn special_values_of_a_count_are_not_limited() {
    let types = [
        ("uint8", "uint8", ""),
        ("uint8", "uint32", ""),
        ("uint32", "uint8", "nearest"),
        ("uint32", "uint8", "neutral"),
    ];
    let notes = [
        ("[@invalid 255]", "[@invalid 255]"),
        ("[@invalid 255.0]", ""),
        ("", "[@uncontrolled 255]"),
        ("[@invalid 0] [@uncontrolled 255]", "[@invalid 0]"),
    ];
    for (old, new, hint) in types {
        for (before, after) in notes {
            let count = |length: u32, ty: &str, note: &str| {
                format!("{ty} count  # [@count items] {note}\nuint8[{length}] items\n")
            };
            let hints = format!("[[hint]]\nmessage = \"Tank\"\nnarrow = {{ count = \"{hint}\" }}\n");
            let hints = if hint.is_empty() { "" } else { &hints };
            let texts = (count(5, old, before), count(2, new, after));
            let found = convert(&[("Tank", &texts.0)], &[("Tank", &texts.1)], hints);
            for (count, expected) in [(1, 1), (2, 2), (4, 2), (254, 2), (255, 255)] {
                let message = serde_json::json!({"count": count, "items": [1, 2, 3, 4, 0]});
                let converted = found.run(found.forward("Tank"), &message);
                assert_eq!(converted["count"], expected, "{count}: {old} {before}, {new} {after}");
            }
        }
    }
}

#[test]
fn the_neutral_value_replaces_special_values_of_a_count_that_do_not_fit() {
    for (ty, value) in [("uint32", 65535), ("int16", -1)] {
        let old = format!("{ty} count  # [@count items] [@uncontrolled {value}]\nuint8[5] items\n");
        for policy in ["nearest", "neutral"] {
            for (note, expected) in [("", 0), ("[@invalid 255]", 255)] {
                let new = format!("uint8 count  # [@count items] {note}\nuint8[2] items\n");
                let hints = format!("[[hint]]\nmessage = \"Tank\"\nnarrow = {{ count = \"{policy}\" }}\n");
                let found = convert(&[("Tank", &old)], &[("Tank", &new)], &hints);
                let message = format!(r#"{{"count": {value}}}"#);
                let converted = found.converted(found.forward("Tank"), &message);
                assert_eq!(converted["count"], expected, "{ty} {policy} {note}");
            }
        }
    }
}

#[test]
fn a_count_that_is_special_only_in_the_target_is_limited() {
    for (before, after, expected) in [("", "[@invalid 150]", 100), ("[@invalid 150]", "", 150)] {
        let count =
            |length: u8, note: &str| format!("uint8 count  # [@count items] {note}\nuint8[{length}] items\n");
        let (old, new) = (count(200, before), count(100, after));
        let found = convert(&[("Tank", &old)], &[("Tank", &new)], "");
        let converted = found.converted(found.forward("Tank"), r#"{"count": 150}"#);
        assert_eq!(converted["count"], expected, "{before} {after}");
    }
}

#[test]
fn named_values_of_a_count_are_not_limited() {
    let text = |unknown: u8, length: u8| {
        format!(
            "uint8 COUNT_MOST = 4\nuint8 COUNT_UNKNOWN = {unknown}\n\
             uint8 count  # [@count items] [@enum COUNT]\nuint8[{length}] items\n"
        )
    };
    for unknown in [255, 254] {
        let found = convert(&[("Tank", &text(255, 5))], &[("Tank", &text(unknown, 2))], "");
        for (count, expected) in [(1, 1), (4, 2), (255, unknown)] {
            let converted = found.converted(found.forward("Tank"), &format!(r#"{{"count": {count}}}"#));
            assert_eq!(converted["count"], expected, "{count}: {unknown}");
        }
    }
}

/// The losses that a conversion counts in a message, each with its number.
fn losses(found: &Converted, conversion: &Conversion, fields: &str) -> Vec<(LossKind, u64)> {
    let types = Types::new(&found.schema);
    let [source, target] = [conversion.from, conversion.to].map(|id| types.get(id));
    let message = source.from_json(&found.message(conversion.from, fields)).expect("a message");
    let mut counts = vec![0; conversion.losses.len()];
    Converter::new(conversion, source, target).count_losses(&message, &mut counts);
    conversion.losses.iter().map(|loss| loss.kind).zip(counts).collect()
}

#[test]
fn counts_only_data_that_is_lost() {
    let old = "uint8 kept\nfloat32 speed\nuint16[3] marks\nuint32 number\nchar[8] text\n";
    let new = "uint8 kept\nuint16[1] marks\nuint8 number\nchar[4] text\n";
    let hints = "[[hint]]\nmessage = \"Tank\"\nnarrow = { number = \"nearest\" }\n";
    let found = convert(&[("Tank", old)], &[("Tank", new)], hints);
    let conversion = found.forward("Tank");
    let counted =
        |fields: &str| losses(&found, conversion, fields).iter().map(|(_, count)| count).sum::<u64>();
    assert_eq!(counted("{}"), 0);
    assert_eq!(counted(r#"{"kept": 3, "marks": [9, 0, 0], "number": 255, "text": "four"}"#), 0);
    assert_eq!(counted(r#"{"speed": null}"#), 0);
    for lost in [r#"{"speed": 1.5}"#, r#"{"marks": [0, 0, 1]}"#, r#"{"number": 256}"#, r#"{"text": "fours"}"#]
    {
        assert_eq!(counted(lost), 1, "{lost}");
    }
}

#[test]
fn counts_lost_strings_and_sequences() {
    let found = varying();
    let forward = found.forward("Glider");
    let counted = |fields: &str| losses(&found, forward, fields).iter().map(|(_, count)| count).sum::<u64>();
    let part = r#"{"id": 0, "text": ""}"#;
    assert_eq!(counted(&format!(r#"{{"name": "abc", "speeds": [0, 0], "parts": [{part}, {part}]}}"#)), 0);
    for lost in [
        r#"{"name": "abcd"}"#.to_owned(),
        r#"{"speeds": [0, 0, 0]}"#.to_owned(),
        format!(r#"{{"parts": [{part}, {part}, {part}]}}"#),
    ] {
        assert_eq!(counted(&lost), 1, "{lost}");
    }
}

/// JSON can't represent strings that are not Unicode, so the reference can't convert them.
#[test]
fn copies_strings_that_are_not_unicode() {
    let found = convert_dialect(
        Dialect::Ros2,
        &[("Glider", "string name\nstring text\nwstring wide\n")],
        &[("Glider", "wstring wide\nstring<=2 name\nstring text\n")],
        "",
    );
    let conversion = found.forward("Glider");
    let types = Types::new(&found.schema);
    let [source, target] = [conversion.from, conversion.to].map(|id| types.get(id));
    let header = ByteOrder::LittleEndian.header();
    // A string with its length, padded so that the next length is aligned.
    let string = |text: &[u8]| {
        let length = u32::try_from(text.len() + 1).expect("a length");
        let mut bytes = [&length.to_le_bytes()[..], text, &[0]].concat();
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        bytes
    };
    // An unpaired surrogate.
    let wide: [u8; 8] = [1, 0, 0, 0, 0, 0xd8, 0, 0];
    let payload = [&header[..], &string(b"a\xff\xfe"), &string(b"\xe9t\xe9"), &wide].concat();
    let message = source.decode_cdr(&payload).expect("a message");
    let converted = Converter::new(conversion, source, target).convert(&message).expect("a message");
    let expected = [&header[..], &wide, &string(b"a\xff"), &string(b"\xe9t\xe9")].concat();
    assert_eq!(converted.to_cdr(ByteOrder::LittleEndian).as_deref(), Ok(&*expected));
}

#[test]
fn recognizes_payloads_that_stay_the_same() {
    let keeps = |old: &str, new: &str| {
        let found = convert(&[("Tank", old)], &[("Tank", new)], "");
        let types = Types::new(&found.schema);
        let conversion = found.forward("Tank");
        Converter::new(conversion, types.get(conversion.from), types.get(conversion.to)).keeps_cdr()
    };
    assert!(keeps("uint8 id\nuint16 NONE = 0\n", "uint8 id\n"));
    for new in [
        "uint16 id\nuint8[2] marks\n",
        "uint8[2] marks\nuint8 id\n",
        "uint8 id\nuint8[3] marks\n",
        "uint8 id\n",
    ] {
        assert!(!keeps("uint8 id\nuint8[2] marks\n", new), "{new}");
    }
}

/// Converts a sequence whose elements take one byte each in the payload, but 8 kB each in the target.
#[test]
fn limits_the_size_of_converted_messages() {
    let part = "uint8 id\nfloat64[1000] added\n";
    let found = convert_dialect(
        Dialect::Ros2,
        &[("Glider", "Part[] parts\n"), ("Part", "uint8 id\n")],
        &[("Glider", "Part[] parts\n"), ("Part", part)],
        "",
    );
    let conversion = found.forward("Glider");
    let types = Types::new(&found.schema);
    let [source, target] = [conversion.from, conversion.to].map(|id| types.get(id));
    let converter = Converter::new(conversion, source, target);
    let message = |count: u32| -> DynamicMessage<'_> {
        let mut payload = ByteOrder::LittleEndian.header().to_vec();
        payload.extend(count.to_le_bytes());
        payload.resize(payload.len() + count as usize, 1);
        source.decode_cdr(&payload).expect("a message")
    };
    assert!(converter.convert(&message(10)).is_ok_and(|message| message.size_in_memory() > 80_000));
    let count = u32::try_from(MAX_CONVERTED / 8008 + 1).expect("a count");
    assert!(converter.convert(&message(count)).is_err());
}
