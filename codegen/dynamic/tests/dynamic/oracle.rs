//! Comparison with the CDR and JSON of other tools, in both directions.

use std::fs;

use serde_json::Value as Json;
use uavspec_dynamic::{MessageType, Types};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Form, Schema};
use uavspec_test_definitions as support;
use uavspec_test_definitions::shared;

#[test]
fn cdr_of_px4_matches_other_tools() {
    let (Some(folder), Some(oracle)) = (shared("corpus/px4/main"), shared("oracle/cdr/px4-main.json")) else {
        return;
    };
    let (_, schema, _) = support::px4(&folder);
    assert_eq!(check(&schema, &fs::read_to_string(oracle).expect("an oracle")), 783);
}

#[test]
fn cdr_of_ros2_matches_other_tools() {
    let (Some(folder), Some(oracle)) = (shared("corpus/ros2"), shared("oracle/cdr/ros2.json")) else {
        return;
    };
    let (_, schema, _) = support::ros2(&folder);
    assert_eq!(check(&schema, &fs::read_to_string(oracle).expect("an oracle")), 282);
}

/// No corpus contains a `wstring`, so these bytes were assembled by hand in the format of
/// `rosidl_typesupport_fastrtps`.
#[test]
fn wide_strings_match_ros2() {
    let (_, schema, _) =
        support::texts(Form::Msg(Dialect::Ros2), &[("Label.msg", "uint8 tag\nwstring wide\n")]);
    let types = Types::new(&schema);
    let ty = types.find("demo", "Label").expect("the type");
    let text = r#"{"tag":7,"wide":"a🚁"}"#;
    for (order, hex) in [
        (ByteOrder::LittleEndian, "00010000 07000000 03000000 61000000 3dd80000 81de0000"),
        (ByteOrder::BigEndian, "00000000 07000000 00000003 00000061 0000d83d 0000de81"),
    ] {
        let payload = bytes(&hex.replace(' ', ""));
        let message = ty.from_json_text(text).expect("a message");
        assert_eq!(message.to_cdr(order).as_deref(), Ok(&*payload));
        let message = ty.decode_cdr(&payload).expect("a message");
        assert_eq!(message.view().to_json_text().as_deref(), Ok(text));
        // After a bit flip, a unit may have more than 16 bits, or the surrogates may be unpaired.
        for at in 12..payload.len() {
            let mut payload = payload.clone();
            payload[at] ^= 0x80;
            let (halves, unpaired) = match order {
                ByteOrder::LittleEndian => ([0, 1], [17, 21]),
                ByteOrder::BigEndian => ([2, 3], [18, 22]),
            };
            let is_read = halves.contains(&(at % 4));
            let is_text = is_read && !unpaired.contains(&at);
            assert_eq!(ty.decode_cdr_strict(&payload).is_ok(), is_text, "{at}");
            let message = ty.decode_cdr(&payload);
            assert_eq!(message.is_ok(), is_read, "{at}");
            if let Ok(message) = message {
                assert_eq!(message.to_cdr(order).as_deref(), Ok(&*payload), "{at}");
                assert_eq!(message.to_json().is_ok(), is_text, "{at}");
                assert_eq!(message.validate().is_empty(), is_text, "{at}");
            }
        }
    }
}

/// Checks all cases of an oracle, and counts them.
fn check(schema: &Schema, oracle: &str) -> usize {
    let types = Types::new(schema);
    let cases: Vec<Json> = serde_json::from_str(oracle).expect("a list of cases");
    for case in &cases {
        let name = case["type"].as_str().expect("a type");
        let (package, name) = name.split_once("/msg/").expect("a package and a name");
        let package = if package == "px4_msgs" { "px4" } else { package };
        check_case(types.find(package, name).expect("the type"), case);
    }
    cases.len()
}

fn check_case(ty: MessageType<'_>, case: &Json) {
    let what = format!("{} {}", case["type"], case["case"]);
    let json = &case["json"];
    let from_json = ty.from_json(json).unwrap_or_else(|error| panic!("{what}: {error}"));
    for (order, key) in [(ByteOrder::LittleEndian, "cdr_le_hex"), (ByteOrder::BigEndian, "cdr_be_hex")] {
        let payload = bytes(case[key].as_str().expect("hexadecimal digits"));
        let message = ty.decode_cdr_strict(&payload).unwrap_or_else(|error| panic!("{what}: {error}"));
        let found = message.to_json().unwrap_or_else(|error| panic!("{what}: {error}"));
        assert!(same(&found, json), "{what}\n{found}\n{json}");
        assert_eq!(message.to_cdr(order).as_deref(), Ok(&*payload), "{what}");
        assert_eq!(from_json.to_cdr(order).as_deref(), Ok(&*payload), "{what} from JSON");
    }
    if ty.size().is_some() {
        let payload = from_json.to_uorb().unwrap_or_else(|error| panic!("{what}: {error}"));
        let message = ty.decode_uorb_strict(&payload).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert!(same(&message.to_json().expect("JSON"), json), "{what} by uORB");
    }
}

fn bytes(hexadecimal: &str) -> Vec<u8> {
    let digits = hexadecimal.as_bytes().chunks_exact(2);
    digits
        .map(|pair| {
            u8::from_str_radix(std::str::from_utf8(pair).expect("digits"), 16).expect("hexadecimal digits")
        })
        .collect()
}

/// True if the values are equal. A float may be written as a 32-bit float, a 64-bit float or an integer.
pub(crate) fn same(left: &Json, right: &Json) -> bool {
    match (left, right) {
        (Json::Array(left), Json::Array(right)) => {
            left.len() == right.len() && left.iter().zip(right).all(|(left, right)| same(left, right))
        }
        (Json::Object(left), Json::Object(right)) => {
            left.keys().eq(right.keys()) && left.iter().all(|(key, value)| same(value, &right[key]))
        }
        (Json::Number(l), Json::Number(r)) if l.is_f64() || r.is_f64() => {
            let (l, r) = (l.as_f64().unwrap_or(f64::NAN), r.as_f64().unwrap_or(f64::NAN));
            #[allow(clippy::cast_possible_truncation)] // the value may have been rounded to float32
            let as_f32 = (l as f32).to_bits() == (r as f32).to_bits();
            l.to_bits() == r.to_bits() || as_f32
        }
        _ => left == right,
    }
}
