//! Neutral values of fields that the source lacks.

use uavspec_runtime::{Number, Scalar};
use uavspec_schema::msg::constraint::INVALID;
use uavspec_schema::value::Value;
use uavspec_schema::{Element, Field, Message, Schema};

use crate::conversion::plan::Neutral;

/// The neutral value of a field, or the reason why the definition has none.
///
/// The neutral value is the definition's value for missing data. NaN is neutral if the definition gives it a meaning.
pub(super) fn neutral(schema: &Schema, message: &Message, field: &Field) -> Result<Neutral, String> {
    if field.default.is_some() {
        return Ok(Neutral::Default);
    }
    let Element::Scalar(scalar) = field.ty.element else { return Ok(Neutral::Default) };
    let invalid = field.constraint(&INVALID).and_then(|found| found.stated.value());
    match invalid {
        Some(Value::Int(value)) if scalar.is_float() => {
            #[allow(clippy::cast_precision_loss)] // the parser checked that the type has the value
            return Ok(Neutral::Float(*value as f64));
        }
        Some(Value::Int(value)) => return Ok(Neutral::Int(*value)),
        Some(Value::Float(value)) if scalar.is_float() => return Ok(Neutral::Float(*value)),
        _ => {}
    }
    if scalar.is_float() && field.gives_nan_a_meaning() {
        return Ok(Neutral::Float(f64::NAN));
    }
    let zero = if scalar.is_float() { Number::Float(0.0) } else { Number::Int(0) };
    let restriction = schema.restriction(message, field).filter(|_| scalar != Scalar::Bool);
    let violated = restriction.and_then(|found| found.constraint().violated_by(zero));
    if violated.is_some() {
        return Err("0 is not a valid value, and the definition has no value for missing data".to_owned());
    }
    Ok(Neutral::Default)
}
