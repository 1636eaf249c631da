//! The encoding of values in the protocol: JSON with numbers that all parsers preserve.
//!
//! Many JSON parsers store all numbers as 64-bit floats. For this reason, integers beyond ±2^53 are written as
//! `{"$u64": "18446744073709551615"}` or `{"$i64": "…"}`, and floats that JSON can't represent are written as `{"$f":
//! "NaN"}`, `{"$f": "inf"}` and `{"$f": "-inf"}`. Bytes are base64 (RFC 4648, section 4, with padding).

use serde_json::{Map, Number, Value, json};
use uavspec_dynamic::MessageType;
pub use uavspec_model::json::base64::{decode as from_base64, encode as to_base64};
use uavspec_schema::{Element, Shape};

/// The limit up to which 64-bit floats represent every integer exactly.
const EXACT: u64 = 1 << 53;

/// The tag of positive integers.
const UNSIGNED: &str = "$u64";

/// The tag of negative integers.
const SIGNED: &str = "$i64";

/// The tag of floats that JSON can't represent.
pub(super) const FLOAT: &str = "$f";

/// Encodes a value for the wire. `message` determines which fields are floats. In these fields, null means NaN.
pub fn to_wire(value: &Value, message: Option<MessageType<'_>>) -> Value {
    match value {
        Value::Number(number) => number_to_wire(number),
        Value::Array(items) => items.iter().map(|item| to_wire(item, message)).collect(),
        Value::Object(members) => {
            let member =
                |(name, value): (&String, &Value)| (name.clone(), member_to_wire(name, value, message));
            Value::Object(members.iter().map(member).collect())
        }
        Value::Null | Value::Bool(_) | Value::String(_) => value.clone(),
    }
}

fn member_to_wire(name: &str, value: &Value, message: Option<MessageType<'_>>) -> Value {
    let field = message.and_then(|message| Some((message, message.field(name)?)));
    match field.map(|(message, field)| (message, field.element, field.shape)) {
        Some((message, Element::Message(id), _)) => to_wire(value, Some(message.nested(id))),
        Some((_, Element::Scalar(scalar), shape)) if scalar.is_float() => float_to_wire(value, shape),
        _ => to_wire(value, None),
    }
}

/// Encodes a float, or an array of floats. If there is null in place of an array, or an array in place of a float, the
/// value is invalid and isn't changed.
fn float_to_wire(value: &Value, shape: Shape) -> Value {
    match value {
        Value::Null if shape == Shape::Single => json!({ FLOAT: "NaN" }),
        Value::Array(items) if shape != Shape::Single => {
            items.iter().map(|item| float_to_wire(item, Shape::Single)).collect()
        }
        other => to_wire(other, None),
    }
}

fn number_to_wire(number: &Number) -> Value {
    if let Some(value) = number.as_u64().filter(|value| *value > EXACT) {
        json!({ UNSIGNED: value.to_string() })
    } else if let Some(value) = number.as_i64().filter(|value| value.unsigned_abs() > EXACT) {
        json!({ SIGNED: value.to_string() })
    } else {
        Value::Number(number.clone())
    }
}

/// Removes the tags of a value. NaN becomes null, as in the published schemas. Infinities stay tagged.
pub fn from_wire(value: &Value) -> Value {
    match value {
        Value::Array(items) => items.iter().map(from_wire).collect(),
        Value::Object(members) => {
            let plain = || members.iter().map(|(name, value)| (name.clone(), from_wire(value))).collect();
            untagged(members).unwrap_or_else(|| Value::Object(plain()))
        }
        other => other.clone(),
    }
}

fn untagged(members: &Map<String, Value>) -> Option<Value> {
    let value = Value::Object(members.clone());
    match float(&value) {
        Some(float) if float.is_nan() => Some(Value::Null),
        _ => integer(&value).and_then(Number::from_i128).map(Value::Number),
    }
}

/// The value as an integer. A float without a fraction counts as an integer, because some writers don't distinguish the
/// two.
pub(super) fn integer(value: &Value) -> Option<i128> {
    match value {
        Value::Number(number) => number.as_i128().or_else(|| whole(number.as_f64()?)),
        Value::Object(_) => {
            let (tag, text) = tag(value)?;
            (tag == UNSIGNED || tag == SIGNED).then(|| text.parse().ok()).flatten()
        }
        _ => None,
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)] // without a fraction and within bounds
fn whole(value: f64) -> Option<i128> {
    (value.fract() == 0.0 && value.abs() <= EXACT as f64).then_some(value as i128)
}

/// The value as a float. Null means NaN.
#[allow(clippy::cast_precision_loss)] // the caller asks for a float
pub(super) fn float(value: &Value) -> Option<f64> {
    match value {
        Value::Null => Some(f64::NAN),
        Value::Number(number) => number.as_f64(),
        Value::Object(_) => match tag(value)? {
            (FLOAT, "NaN") => Some(f64::NAN),
            (FLOAT, "inf") => Some(f64::INFINITY),
            (FLOAT, "-inf") => Some(f64::NEG_INFINITY),
            _ => integer(value).map(|value| value as f64),
        },
        _ => None,
    }
}

/// True if a value is a number with one of these tags.
pub(super) fn has_tag(value: &Value, tags: &[&str]) -> bool {
    tag(value).is_some_and(|(name, _)| tags.contains(&name))
        && (float(value).is_some() || integer(value).is_some())
}

fn tag(value: &Value) -> Option<(&str, &str)> {
    let members = value.as_object()?;
    let (name, text) = members.iter().next().filter(|_| members.len() == 1)?;
    Some((name, text.as_str()?))
}

#[cfg(test)]
mod tests {
    use uavspec_rules::definitions::Definitions;

    use super::*;

    #[test]
    fn tags_numbers_that_floats_would_round() {
        let plain = json!([0, -7, 0.5, u64::MAX, i64::MIN, EXACT, EXACT + 1, "x", true, { "a": -9_007_199_254_740_993_i64 }]);
        let wire = to_wire(&plain, None);
        assert_eq!(wire[3], json!({ "$u64": "18446744073709551615" }));
        assert_eq!(wire[4], json!({ "$i64": "-9223372036854775808" }));
        assert_eq!(wire[5], json!(9_007_199_254_740_992_u64));
        assert_eq!(wire[6], json!({ "$u64": "9007199254740993" }));
        assert_eq!(from_wire(&wire), plain);
        assert_eq!(from_wire(&json!({ "$f": "NaN" })), Value::Null);
        assert_eq!(float(&json!({ "$f": "-inf" })), Some(f64::NEG_INFINITY));
        assert_eq!(integer(&json!(5.0)), Some(5));
        assert_eq!(integer(&json!(5.5)), None);
        assert_eq!(integer(&json!({ "$u64": "5", "x": 1 })), None);
    }

    #[test]
    fn tags_null_as_nan_only_in_place_of_a_float() {
        let definitions = Definitions::built_in();
        let battery = definitions.types().find("px4", "BatteryStatus");
        assert!(battery.is_some());
        let nan = json!({ "$f": "NaN" });
        for (field, plain, wire) in [
            ("voltage_v", Value::Null, nan.clone()),
            ("voltage_cell_v", json!([null, 1.5]), json!([nan, 1.5])),
            // Invalid values are sent unchanged.
            ("voltage_cell_v", Value::Null, Value::Null),
            ("voltage_v", json!([null]), json!([null])),
            ("voltage_cell_v", json!([[null]]), json!([[null]])),
            ("timestamp", Value::Null, Value::Null),
        ] {
            assert_eq!(to_wire(&json!({ field: plain }), battery), json!({ field: wire }), "{field}");
        }
    }
}
