//! Compares responses with expected responses.
//!
//! Numbers are compared as values of the field's type, for example as float32 in float32 fields. NaN equals NaN, and 0
//! equals -0, because not every JSON writer can represent NaN or -0. Bytes are compared exactly.

use std::fmt;

use serde_json::Value;
use uavspec_codegen::dynamic::{MessageType, PlacedElement, Types};
use uavspec_codegen::schema::Shape;
use uavspec_runtime::Scalar;

use super::case::{Case, ExpectedResponse};
use super::protocol::Response;
use super::wire::{float, from_base64, integer};

/// The maximum number of characters of a value in a message.
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
        (Response::Ok(value), ExpectedResponse::Message(wanted)) => {
            let message =
                case.type_name.split_once('/').and_then(|(package, name)| types.find(package, name));
            match message {
                Some(message) => compare_message(message, wanted, value, ""),
                None => compare_json(wanted, value, ""),
            }
        }
        (Response::Ok(value), ExpectedResponse::Bytes(right)) => compare_bytes(right, value),
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

fn compare_message(
    message_type: MessageType<'_>,
    wanted: &Value,
    actual: &Value,
    path: &str,
) -> Result<(), Difference> {
    compare_members(wanted, actual, path, |name, wanted, actual, path| {
        let field = message_type.layout().find(|field| field.name == name);
        field.map_or_else(
            || compare_json(wanted, actual, path),
            |field| compare_shaped(field.element, field.shape, wanted, actual, path),
        )
    })
}

/// Compares the values of a field.
fn compare_shaped(
    element: PlacedElement<'_>,
    shape: Shape,
    wanted: &Value,
    actual: &Value,
    path: &str,
) -> Result<(), Difference> {
    if shape != Shape::Single && wanted.is_array() {
        return compare_items(wanted, actual, path, |wanted, actual, path| {
            compare_shaped(element, Shape::Single, wanted, actual, path)
        });
    }
    match element {
        PlacedElement::Message(nested) => compare_message(nested, wanted, actual, path),
        PlacedElement::Scalar(scalar) if scalar.is_float() => compare_float(scalar, wanted, actual, path),
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

    use super::*;
    use crate::definitions::Definitions;

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
        // These are equal as float32.
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
