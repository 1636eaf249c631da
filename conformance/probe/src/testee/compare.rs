//! Compares responses with expected responses.
//!
//! Numbers are compared as values of the field's type, for example as float32 in float32 fields. NaN equals NaN, and 0
//! equals -0, because not every JSON writer can represent NaN or -0. Bytes are compared exactly, except for the bits of
//! a NaN that was encoded from JSON, because JSON doesn't contain them.

use std::fmt;

use serde_json::Value;
use uavspec_dynamic::{MessageType, Types};
use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Shape};

use super::case::{Case, ExpectedResponse, Input, UNLIKE_NAN, decode, encode};
use super::protocol::{Op, Response};
use super::wire::{float, from_base64, from_wire, integer};

/// The maximum number of characters of a value that a message shows.
const MAX_SHOWN: usize = 400;

/// A difference between a response and the expected response.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The location in the value, such as `/events/2/id`; empty for the whole value.
    pub path: String,
    /// The expected value.
    pub expected: String,
    /// The actual value.
    pub actual: String,
}

impl Difference {
    fn new(path: &str, expected: impl fmt::Display, actual: impl fmt::Display) -> Self {
        Self { path: path.to_owned(), expected: shorten(&expected), actual: shorten(&actual) }
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let colon = if self.path.is_empty() { "" } else { ": " };
        write!(f, "{}{colon}expected {}, got {}", self.path, self.expected, self.actual)
    }
}

/// Compares a response with the expected response.
pub(crate) fn compare(case: &Case, answer: &Response, types: &Types) -> Result<(), Difference> {
    let expected = &case.expected;
    match (answer, &expected.ok) {
        (Response::Rejected(_), _) if expected.rejection => Ok(()),
        (Response::Ok(_), ExpectedResponse::Anything) => Ok(()),
        (Response::Ok(value), ExpectedResponse::Message(wanted)) => match case.message_type(types) {
            Some(message) => compare_message(message, wanted, value, ""),
            None => compare_json(wanted, value, ""),
        },
        (Response::Ok(value), ExpectedResponse::Bytes(right)) => {
            let compared = compare_bytes(right, value);
            if compared.is_err() && has_other_nans(case, right, value, types) { Ok(()) } else { compared }
        }
        (Response::Ok(value), ExpectedResponse::Exactly(wanted)) => compare_json(wanted, value, ""),
        (other, _) => Err(Difference::new("", describe(case), describe_answer(other))),
    }
}

/// A description of the expected responses.
fn describe(case: &Case) -> String {
    let or = if case.expected.rejection { " or a rejection" } else { "" };
    let violated = case.rule.as_ref().map(|rule| format!(" ({rule})")).unwrap_or_default();
    match &case.expected.ok {
        ExpectedResponse::Nothing => format!("a rejection{violated}"),
        ExpectedResponse::Anything => "acceptance".to_owned() + or,
        ExpectedResponse::Message(value) | ExpectedResponse::Exactly(value) => format!("{value}{or}"),
        ExpectedResponse::Bytes(right) => {
            format!("{}{or}", right.first().map_or_else(String::new, |bytes| hex(bytes)))
        }
    }
}

fn describe_answer(answer: &Response) -> String {
    match answer {
        Response::Ok(value) => format!("ok: {value}"),
        Response::Rejected(reason) => format!("rejected: {reason}"),
        Response::Unsupported => "unsupported".to_owned(),
        Response::Error(error) => format!("error: {error}"),
    }
}

fn compare_bytes(right: &[Vec<u8>], actual: &Value) -> Result<(), Difference> {
    let wanted = right.first().map(Vec::as_slice).unwrap_or_default();
    let Some(bytes) = actual.as_str().and_then(from_base64) else {
        return Err(Difference::new("", "base64", actual));
    };
    if right.contains(&bytes) {
        return Ok(());
    }
    let at = wanted.iter().zip(&bytes).position(|(left, right)| left != right);
    let at = at.unwrap_or(wanted.len().min(bytes.len()));
    // Sixteen bytes from the first difference on, and the total length.
    let excerpt = |bytes: &[u8]| {
        let part = bytes.get(at..).unwrap_or_default();
        format!("{} of {} bytes", hex(part.get(..16).unwrap_or(part)), bytes.len())
    };
    Err(Difference::new(&format!("byte {at}"), excerpt(wanted), excerpt(&bytes)))
}

/// True if the bytes of a response are right except for the bit patterns of NaNs. The request doesn't contain the bits
/// of a NaN, and languages differ: most write the `float32` `7fc00000`, but C# writes `ffc00000`. All other bytes must
/// be exactly as expected.
fn has_other_nans(case: &Case, right: &[Vec<u8>], actual: &Value, types: &Types) -> bool {
    let bytes = actual.as_str().and_then(from_base64);
    let (Op::Encode, Some(format), Input::Value(value), Some(message), Some(bytes)) =
        (case.op, case.format, &case.input, case.message_type(types), bytes)
    else {
        return false;
    };
    let wanted = from_wire(value);
    // These two encodings differ in all bytes of the NaNs, and in no other bytes.
    let Some((plain, marked)) = right.first().zip(encode(message, format, &without_nans(&wanted))) else {
        return false;
    };
    let is_in_nan = |at: usize| plain.get(at) != marked.get(at);
    let is_right = |right: &Vec<u8>| {
        let mut pairs = right.iter().zip(&bytes).enumerate();
        right.len() == bytes.len() && pairs.all(|(at, (right, actual))| right == actual || is_in_nan(at))
    };
    let is_same = || {
        let actual = decode(message, format, &bytes).and_then(|decoded| decoded.to_json().ok());
        actual.is_some_and(|actual| compare_message(message, &wanted, &actual, "").is_ok())
    };
    right.iter().any(is_right) && is_same()
}

/// Replaces each NaN in a message. In encodable messages, null always means NaN.
fn without_nans(value: &Value) -> Value {
    match value {
        Value::Null => UNLIKE_NAN.into(),
        Value::Array(items) => items.iter().map(without_nans).collect(),
        Value::Object(members) => {
            let members = members.iter().map(|(name, value)| (name.clone(), without_nans(value)));
            Value::Object(members.collect())
        }
        other => other.clone(),
    }
}

fn compare_message(
    message_type: MessageType<'_>,
    wanted: &Value,
    actual: &Value,
    path: &str,
) -> Result<(), Difference> {
    compare_members(wanted, actual, path, |name, wanted, actual, path| {
        let field = message_type.field(name);
        field.map_or_else(
            || compare_json(wanted, actual, path),
            |field| compare_shaped((message_type, field.element), field.shape, wanted, actual, path),
        )
    })
}

/// Compares the values of a field.
fn compare_shaped(
    (message_type, element): (MessageType<'_>, Element),
    shape: Shape,
    wanted: &Value,
    actual: &Value,
    path: &str,
) -> Result<(), Difference> {
    if shape != Shape::Single && wanted.is_array() {
        return compare_items(wanted, actual, path, |wanted, actual, path| {
            compare_shaped((message_type, element), Shape::Single, wanted, actual, path)
        });
    }
    match element {
        Element::Message(id) => compare_message(message_type.nested(id), wanted, actual, path),
        Element::Scalar(scalar) if scalar.is_float() => compare_float(scalar, wanted, actual, path),
        _ => compare_json(wanted, actual, path),
    }
}

#[allow(clippy::cast_possible_truncation, clippy::float_cmp)] // exact comparison in the precision of the field
fn compare_float(scalar: Scalar, wanted: &Value, actual: &Value, path: &str) -> Result<(), Difference> {
    let is_equal = |left: f64, right: f64| match scalar {
        Scalar::Float32 => left as f32 == right as f32,
        _ => left == right,
    };
    match (float(wanted), float(actual)) {
        (Some(left), Some(right)) if is_equal(left, right) || left.is_nan() && right.is_nan() => Ok(()),
        (Some(left), _) if left.is_nan() => Err(Difference::new(path, "NaN", actual)),
        _ => Err(Difference::new(path, wanted, actual)),
    }
}

fn compare_json(wanted: &Value, actual: &Value, path: &str) -> Result<(), Difference> {
    match wanted {
        Value::Array(_) => compare_items(wanted, actual, path, compare_json),
        Value::Object(_) => compare_members(wanted, actual, path, |_, wanted, actual, path| {
            compare_json(wanted, actual, path)
        }),
        Value::Number(_) if integer(wanted).is_some() && integer(wanted) == integer(actual) => Ok(()),
        // Outside of messages, the only floats are the arguments of events, which are float32.
        Value::Number(number) if number.is_f64() => compare_float(Scalar::Float32, wanted, actual, path),
        _ if wanted == actual => Ok(()),
        _ => Err(Difference::new(path, wanted, actual)),
    }
}

fn compare_items(
    wanted: &Value,
    actual: &Value,
    path: &str,
    mut compare: impl FnMut(&Value, &Value, &str) -> Result<(), Difference>,
) -> Result<(), Difference> {
    let (Some(left), Some(right)) = (wanted.as_array(), actual.as_array()) else {
        return Err(Difference::new(path, wanted, actual));
    };
    if left.len() != right.len() {
        return Err(Difference::new(
            path,
            format_args!("{} elements", left.len()),
            format_args!("{}: {actual}", right.len()),
        ));
    }
    let mut items = left.iter().zip(right).enumerate();
    items.try_for_each(|(index, (wanted, actual))| compare(wanted, actual, &format!("{path}/{index}")))
}

fn compare_members(
    wanted: &Value,
    actual: &Value,
    path: &str,
    mut compare: impl FnMut(&str, &Value, &Value, &str) -> Result<(), Difference>,
) -> Result<(), Difference> {
    let (Some(left), Some(right)) = (wanted.as_object(), actual.as_object()) else {
        return Err(Difference::new(path, wanted, actual));
    };
    for (name, wanted) in left {
        let path = format!("{path}/{name}");
        let Some(actual) = right.get(name) else {
            return Err(Difference::new(&path, wanted, "no member"));
        };
        compare(name, wanted, actual, &path)?;
    }
    match right.iter().find(|(name, _)| !left.contains_key(*name)) {
        Some((name, value)) => Err(Difference::new(&format!("{path}/{name}"), "no member", value)),
        None => Ok(()),
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn shorten(value: &impl fmt::Display) -> String {
    let text = value.to_string();
    match text.char_indices().nth(MAX_SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;
    use uavspec_rules::definitions::Definitions;
    use uavspec_schema::msg::Dialect;
    use uavspec_schema::{Form, PackageInput, SourceMap, read};

    use super::*;
    use crate::testee::case::Expected;
    use crate::testee::case::tests::{CASES, DEFINITIONS};
    use crate::testee::protocol::Format;
    use crate::testee::wire::{to_base64, to_wire};

    fn with(mut value: Value, field: &str, other: Value) -> Value {
        value[field] = other;
        value
    }

    #[test]
    fn compares_numbers_as_values_of_the_field_type() {
        let definitions = Definitions::built_in();
        let types = Types::new(&definitions.schema);
        let battery = types.find("px4", "BatteryStatus").expect("a type");
        let zero = battery.default().to_json().expect("JSON");
        let compare = |field: &str, wanted: Value, actual: Value| {
            let (wanted, actual) = (with(zero.clone(), field, wanted), with(zero.clone(), field, actual));
            compare_message(battery, &wanted, &actual, "").is_ok()
        };
        // The two values are equal as float32.
        assert!(compare("voltage_v", json!(0.1), json!(0.100_000_001_490_116_12)));
        assert!(!compare("voltage_v", json!(0.1), json!(0.100_000_01)));
        assert!(compare("voltage_v", json!(-0.0), json!(0)));
        assert!(compare("voltage_v", Value::Null, json!({ "$f": "NaN" })));
        assert!(compare("voltage_v", Value::Null, Value::Null));
        assert!(!compare("voltage_v", Value::Null, json!("NaN")));
        assert!(!compare("voltage_v", json!(0.0), Value::Null));
        assert!(!compare("voltage_v", json!(1.0), json!({ "$f": "inf" })));
        assert!(compare("timestamp", json!(u64::MAX), json!({ "$u64": "18446744073709551615" })));
        assert!(!compare("timestamp", json!(u64::MAX), json!(18_446_744_073_709_551_615.0)));
        assert!(compare("timestamp", json!(7), json!(7.0)));
        assert!(!compare("connected", json!(true), json!(1)));
        assert!(!compare("connected", json!(true), json!("true")));
    }

    /// True if these bytes are a correct response to a case.
    fn accepts(case: &Case, bytes: &[u8], types: &Types) -> bool {
        compare(case, &Response::Ok(to_base64(bytes).into()), types).is_ok()
    }

    /// Copies bytes, and replaces those that start at `at`.
    fn replaced(bytes: &[u8], at: usize, part: &[u8]) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        bytes[at..at + part.len()].copy_from_slice(part);
        bytes
    }

    #[test]
    fn accepts_any_bits_of_an_encoded_nan() {
        let types = DEFINITIONS.types();
        for format in ["uorb", "cdr"] {
            let find = |op: &str| {
                let name = format!("{op}-{format}/px4/BatteryStatus/average_power-nan");
                CASES.iter().find(|case| case.name() == name).expect("a case")
            };
            let (encode, roundtrip) = (find("encode"), find("roundtrip"));
            let ExpectedResponse::Bytes(right) = &encode.expected.ok else { panic!("{encode:?}") };
            let nan = f32::NAN.to_le_bytes();
            let at = right[0].windows(4).position(|window| window == nan).expect("a NaN");
            for right in right {
                for nan in [0xffc0_0000_u32, 0x7fc0_0001, 0x7f80_0001] {
                    let other = replaced(right, at, &nan.to_le_bytes());
                    assert!(accepts(encode, &other, types), "{format} {nan:x}");
                    // A copy preserves the bits.
                    assert!(!accepts(roundtrip, &other, types), "{format} {nan:x}");
                    for (changed, byte) in other.iter().enumerate() {
                        if !(at..at + 4).contains(&changed) {
                            let wrong = replaced(&other, changed, &[byte ^ 0x80]);
                            assert!(!accepts(encode, &wrong, types), "{format} {nan:x} byte {changed}");
                        }
                    }
                }
                for number in [0.0, 1.1, f32::INFINITY, f32::from_bits(0x0000_c07f)] {
                    let wrong = replaced(right, at, &number.to_le_bytes());
                    assert!(!accepts(encode, &wrong, types), "{format} {number}");
                }
            }
        }
    }

    #[test]
    fn accepts_any_bits_of_a_nan_after_strings_and_in_sequences() {
        let mut sources = SourceMap::default();
        let text = "string name\nfloat64[] speeds\nuint8 last\n";
        let file = sources.add("Wind.msg", text.into()).expect("a file");
        let package = PackageInput::new("demo", Form::Msg(Dialect::Ros2), vec![file]);
        let (schema, _) = read(&sources, &[package]);
        let types = Types::new(&schema);
        let wind = types.find("demo", "Wind").expect("a type");
        let json = json!({ "name": "föhn", "speeds": [1.5, null, 2.5], "last": 7 });
        let right = encode(wind, Format::Cdr, &json).expect("a payload");
        let case = Case {
            op: Op::Encode,
            format: Some(Format::Cdr),
            type_name: "demo/Wind".to_owned(),
            id: String::new(),
            description: String::new(),
            rule: None,
            input: Input::Value(to_wire(&json, Some(wind))),
            expected: Expected { ok: ExpectedResponse::Bytes(vec![right.clone()]), rejection: false },
        };
        let nan = f64::NAN.to_le_bytes();
        let at = right.windows(8).position(|window| window == nan).expect("a NaN");
        // Go writes this NaN.
        let other = replaced(&right, at, &0x7ff8_0000_0000_0001_u64.to_le_bytes());
        assert!(accepts(&case, &right, &types) && accepts(&case, &other, &types));
        assert!(!accepts(&case, &replaced(&other, at - 1, &[0]), &types));
        assert!(!accepts(&case, &other[..other.len() - 1], &types));
        assert!(!accepts(&case, &replaced(&right, at, &f64::INFINITY.to_le_bytes()), &types));
    }

    #[test]
    fn reports_missing_and_additional_members() {
        let location =
            |wanted: Value, actual: Value| compare_json(&wanted, &actual, "").expect_err("a difference").path;
        assert_eq!(location(json!({ "a": { "b": 1 } }), json!({ "a": {} })), "/a/b");
        assert_eq!(location(json!({ "a": 1 }), json!({ "a": 1, "c": 1 })), "/c");
        assert_eq!(location(json!([1, 2]), json!([1, 3])), "/1");
        assert_eq!(location(json!([1, 2]), json!([1])), "");
    }

    #[test]
    fn reports_the_first_byte_that_differs() {
        let right = [vec![1, 2, 0], vec![1, 2]];
        assert_eq!(compare_bytes(&right, &json!("AQIA")), Ok(()));
        assert_eq!(compare_bytes(&right, &json!("AQI=")), Ok(()));
        let wrong = compare_bytes(&right, &json!("AQMA")).expect_err("another byte");
        assert_eq!(wrong.to_string(), "byte 1: expected 0200 of 3 bytes, got 0300 of 3 bytes");
        assert!(compare_bytes(&right, &json!([1, 2, 0])).is_err());
    }
}
