//! Bounds of numbers, as a schema enforces them.

use uavspec_runtime::Scalar;

use super::tree::{Member, Node, member};
use crate::schema::Range;
use crate::schema::constraint::{MAX_FLOAT32, spread};
use crate::value::Value;

/// Inclusive bounds of a number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bounds {
    scalar: Scalar,
    low: Value,
    high: Value,
}

impl Bounds {
    /// All values of `scalar`; none for `bool`.
    pub(super) fn of(scalar: Scalar) -> Option<Self> {
        let (low, high) = match (scalar, scalar.integer_bounds()) {
            (_, Some((low, high))) => (Value::Int(low), Value::Int(high)),
            (Scalar::Float32, None) => (Value::Float(-MAX_FLOAT32), Value::Float(MAX_FLOAT32)),
            // Some readers of JSON take 1e999 and pass it on as infinity.
            (Scalar::Float64, None) => (Value::Float(f64::MIN), Value::Float(f64::MAX)),
            _ => return None,
        };
        Some(Self { scalar, low, high })
    }

    /// What lets through exactly `value`.
    pub(super) fn exactly(value: &Value, scalar: Scalar) -> Self {
        let (low, high) = spread(value, scalar);
        Self { scalar, low, high }
    }

    /// What of these bounds lies in `range`.
    pub(super) fn within(mut self, range: &Range) -> Self {
        if let Some(low) = range.low.as_ref().map(|low| spread(low, self.scalar).0)
            && is_less(&self.low, &low)
        {
            self.low = low;
        }
        if let Some(high) = range.high.as_ref().map(|high| spread(high, self.scalar).1)
            && is_less(&high, &self.high)
        {
            self.high = high;
        }
        self
    }

    /// What of these bounds isn't above `greatest`.
    pub(super) fn at_most(self, greatest: u32) -> Self {
        self.within(&Range { low: None, high: Some(Value::Int(greatest.into())) })
    }

    /// Whether `value` is a number within. NaN is in no bounds.
    pub(super) fn hold(&self, value: &Value) -> bool {
        let is_number = value.as_f64().is_some_and(|value| !value.is_nan());
        is_number && !is_less(value, &self.low) && !is_less(&self.high, value)
    }

    /// Whether no number is within both, to readers that keep all numbers as 64-bit floats, too.
    pub(super) fn is_apart(&self, other: &Self) -> bool {
        self.high.as_f64() < other.low.as_f64() || other.high.as_f64() < self.low.as_f64()
    }

    /// `minimum` and `maximum`.
    pub(super) fn members<'s>(&self) -> [Member<'s>; 2] {
        [member("minimum", number(&self.low)), member("maximum", number(&self.high))]
    }
}

/// The value that a field of type `scalar` has where its definition says `value`.
pub(super) fn held(value: &Value, scalar: Scalar) -> Value {
    #[allow(clippy::cast_possible_truncation)] // rounding is what this is about
    let rounded = value.as_f64().map(|exact| f64::from(exact as f32));
    match rounded {
        Some(rounded) if scalar == Scalar::Float32 && value.as_f64() != Some(rounded) => {
            Value::Float(rounded)
        }
        _ => value.clone(),
    }
}

/// What a schema asserts to let through exactly `value` of type `scalar`.
pub(super) fn exactly<'s>(value: &Value, scalar: Scalar) -> Vec<Member<'s>> {
    let bounds = Bounds::exactly(value, scalar);
    if bounds.low == bounds.high {
        return vec![member("const", number(value))];
    }
    let ty = if scalar.is_float() { "number" } else { "integer" };
    [member("type", ty)].into_iter().chain(bounds.members()).collect()
}

/// A number of a definition; what has no JSON becomes null.
pub(super) fn number<'s>(value: &Value) -> Node<'s> {
    match value {
        Value::Int(value) => Node::Integer(*value),
        Value::Float(value) if value.is_finite() => Node::Float(*value),
        _ => Node::Null,
    }
}

/// Exact for integers, which floats of 64 bits can't tell apart near the bounds of 64-bit integers.
fn is_less(left: &Value, right: &Value) -> bool {
    match (left, right) {
        (Value::Int(left), Value::Int(right)) => left < right,
        _ => left.as_f64() < right.as_f64(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(low: f64, high: f64) -> Range {
        Range { low: Some(Value::Float(low)), high: Some(Value::Float(high)) }
    }

    #[test]
    #[allow(clippy::approx_constant)] // the neighbours of pi are meant, not pi
    fn bounds_of_float32_let_its_own_nearest_value_through() {
        let pi = std::f64::consts::PI;
        let bounds = Bounds::of(Scalar::Float32).expect("a number").within(&range(-pi, pi));
        for value in [f64::from(std::f32::consts::PI), 3.141_592_7, -3.141_592_7, pi] {
            assert!(bounds.hold(&Value::Float(value)), "{value}");
        }
        assert!(!bounds.hold(&Value::Float(3.141_593)));
        let bounds = Bounds::of(Scalar::Float64).expect("a number").within(&range(-pi, pi));
        assert!(!bounds.hold(&Value::Float(3.141_592_7)));
    }

    #[test]
    fn a_range_only_narrows() {
        let of = |scalar| Bounds::of(scalar).expect("a number");
        let byte = of(Scalar::UInt8);
        assert_eq!(byte.clone().within(&range(-5.0, 300.0)), byte);
        assert_eq!(byte.clone().at_most(300), byte);
        assert!(!byte.at_most(5).hold(&Value::Int(6)));
        let long = of(Scalar::UInt64);
        assert!(long.hold(&Value::Int(u64::MAX.into())) && !long.hold(&Value::Int(i128::from(u64::MAX) + 1)));
    }

    #[test]
    fn both_forms_of_a_float32_are_exactly_it() {
        let names =
            |value, scalar| exactly(&value, scalar).into_iter().map(|(name, _)| name).collect::<Vec<_>>();
        assert_eq!(names(Value::Float(0.1), Scalar::Float32), ["type", "minimum", "maximum"]);
        assert_eq!(names(Value::Float(0.1), Scalar::Float64), ["const"]);
        assert_eq!(names(Value::Int(-1), Scalar::Float32), ["const"]);
    }

    #[test]
    fn bounds_that_floats_of_64_bits_cant_tell_are_not_apart() {
        let of = |low, high| Bounds { scalar: Scalar::UInt64, low: Value::Int(low), high: Value::Int(high) };
        assert!(of(0, 4).is_apart(&of(5, 5)) && of(5, 5).is_apart(&of(0, 4)));
        assert!(!of(0, 5).is_apart(&of(5, 9)));
        let greatest = i128::from(u64::MAX);
        assert!(!of(0, greatest - 1).is_apart(&of(greatest, greatest)));
    }
}
