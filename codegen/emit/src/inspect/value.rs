//! Values as JSON.

use serde_json::{Value as Json, json};
use uavspec_schema::value::Value;
use uavspec_schema::{Range, Stated};

pub(super) fn range(range: &Range) -> Json {
    json!([range.low.as_ref().map(value), range.high.as_ref().map(value)])
}

/// The values of a constraint.
pub(super) fn stated(stated: &Stated) -> Json {
    match stated {
        Stated::Range(bounds) => range(bounds),
        Stated::Value(stated) => value(stated),
        Stated::Empty => json!("empty"),
    }
}

/// A value as JSON. NaN and infinities are strings.
pub(crate) fn value(value: &Value) -> Json {
    match value {
        Value::Bool(value) => json!(value),
        Value::Int(value) => integer(*value),
        Value::Float(value) if value.is_nan() => json!("NaN"),
        Value::Float(value) if value.is_infinite() => json!(if *value > 0.0 { "inf" } else { "-inf" }),
        Value::Float(value) => json!(value),
        Value::Text(value) => json!(value),
        Value::List(values) => values.iter().map(self::value).collect(),
    }
}

/// Converts an integer to JSON. The integers in fields and constants have at most 64 bits.
pub(crate) fn integer(value: i128) -> Json {
    i64::try_from(value)
        .map_or_else(|_| json!(u64::try_from(value).unwrap_or(u64::MAX)), |value| json!(value))
}
