//! Numeric constraints as schema keywords.

use uavspec_runtime::{Constraint, Number, Scalar};
use uavspec_schema::msg::constraint::number::spread;
use uavspec_schema::value::Value;

use super::tree::{Member, Node, member};

/// A constraint without lists of values.
pub(super) type Numbers = Constraint<'static>;

/// The constraint that allows only `value`.
pub(super) fn exactly(value: Number, scalar: Scalar) -> Numbers {
    let (low, high) = spread(value, scalar);
    Constraint::NONE.from(low).to(high)
}

/// True if the two ranges are disjoint, even after conversion to 64-bit floats.
pub(super) fn are_disjoint(left: &Numbers, right: &Numbers) -> bool {
    let is_below =
        |low: &Numbers, high: &Numbers| low.high.map(Number::as_f64) < high.low.map(Number::as_f64);
    is_below(left, right) || is_below(right, left)
}

/// The keywords for a constraint.
pub(super) fn members<'s>(constraint: &Numbers) -> impl Iterator<Item = Member<'s>> + use<'s> {
    constraint.keywords().map(|(keyword, value)| member(keyword, node(value)))
}

/// The declared `value` after conversion to `scalar`.
pub(super) fn stored(value: &Value, scalar: Scalar) -> Value {
    #[allow(clippy::cast_possible_truncation)] // rounding is intended
    let rounded = value.as_f64().map(|exact| f64::from(exact as f32));
    match rounded {
        Some(rounded) if scalar == Scalar::Float32 && value.as_f64() != Some(rounded) => {
            Value::Float(rounded)
        }
        _ => value.clone(),
    }
}

/// The schema keywords that allow only the number `value`, in a field of type `scalar`.
pub(super) fn only<'s>(value: Number, scalar: Scalar) -> Vec<Member<'s>> {
    let bounds = exactly(value, scalar);
    if bounds.low == bounds.high {
        return vec![member("const", node(value))];
    }
    let ty = if scalar.is_float() { "number" } else { "integer" };
    [member("type", ty)].into_iter().chain(members(&bounds)).collect()
}

/// A declared number, or null if JSON can't represent it.
pub(super) fn number<'s>(value: &Value) -> Node<'s> {
    value.number().map_or(Node::Null, node)
}

fn node<'s>(number: Number) -> Node<'s> {
    match number {
        Number::Int(value) => Node::Integer(value),
        Number::Float(value) if value.is_finite() => Node::Float(value),
        Number::Float(_) => Node::Null,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::approx_constant)] // values near pi are intended
    fn float32_bounds_accept_the_nearest_float32() {
        let pi = std::f64::consts::PI;
        let bounds = |scalar| {
            let (low, high) = (spread(Number::Float(-pi), scalar).0, spread(Number::Float(pi), scalar).1);
            Constraint::NONE.from(low).to(high).asserted(scalar).expect("a number")
        };
        let is_valid = |scalar, value| bounds(scalar).violated_by(Number::Float(value)).is_none();
        for value in [f64::from(std::f32::consts::PI), 3.141_592_7, -3.141_592_7, pi] {
            assert!(is_valid(Scalar::Float32, value), "{value}");
        }
        assert!(!is_valid(Scalar::Float32, 3.141_593));
        assert!(!is_valid(Scalar::Float64, 3.141_592_7));
    }

    #[test]
    fn ranges_never_extend_the_type() {
        let asserted = |numbers: Numbers, scalar| numbers.asserted(scalar).expect("a number");
        let byte = asserted(Constraint::NONE, Scalar::UInt8);
        let wide = Constraint::NONE.from(Number::Float(-5.0)).to(Number::Float(300.0));
        assert_eq!(asserted(wide, Scalar::UInt8), byte);
        assert_eq!(asserted(Constraint::NONE.counting(300), Scalar::UInt8), byte);
        let few = asserted(Constraint::NONE.counting(5), Scalar::UInt8);
        assert!(few.violated_by(Number::Int(6)).is_some());
        let long = asserted(Constraint::NONE, Scalar::UInt64);
        let max = i128::from(u64::MAX);
        assert!(
            long.violated_by(Number::Int(max)).is_none() && long.violated_by(Number::Int(max + 1)).is_some()
        );
    }

    #[test]
    fn accepts_both_decimal_forms_of_a_float32() {
        let names = |value, scalar| only(value, scalar).into_iter().map(|(name, _)| name).collect::<Vec<_>>();
        assert_eq!(names(Number::Float(0.1), Scalar::Float32), ["type", "minimum", "maximum"]);
        assert_eq!(names(Number::Float(0.1), Scalar::Float64), ["const"]);
        assert_eq!(names(Number::Int(-1), Scalar::Float32), ["const"]);
    }

    #[test]
    fn ranges_that_overlap_as_64_bit_floats_are_not_disjoint() {
        let range = |low, high| Constraint::NONE.from(Number::Int(low)).to(Number::Int(high));
        assert!(are_disjoint(&range(0, 4), &range(5, 5)) && are_disjoint(&range(5, 5), &range(0, 4)));
        assert!(!are_disjoint(&range(0, 5), &range(5, 9)));
        let max = i128::from(u64::MAX);
        assert!(!are_disjoint(&range(0, max - 1), &range(max, max)));
    }
}
