//! Constraints on numbers, as a schema enforces them.

use uavspec_runtime::{Constraint, Number, Scalar};

use super::tree::{Member, Node, member};
use crate::msg::constraint::number::spread;
use crate::value::Value;

/// A constraint without lists.
pub(super) type Numbers = Constraint<'static>;

/// The constraint that allows exactly `value`.
pub(super) fn exactly(value: Number, scalar: Scalar) -> Numbers {
    let (low, high) = spread(value, scalar);
    Constraint::NONE.from(low).to(high)
}

/// True if the two ranges are disjoint, even to readers that keep all numbers as 64-bit floats.
pub(super) fn are_apart(left: &Numbers, right: &Numbers) -> bool {
    let is_below =
        |low: &Numbers, high: &Numbers| low.high.map(Number::as_f64) < high.low.map(Number::as_f64);
    is_below(left, right) || is_below(right, left)
}

/// The keywords that assert a constraint.
pub(super) fn members<'s>(constraint: &Numbers) -> impl Iterator<Item = Member<'s>> + use<'s> {
    constraint.keywords().map(|(keyword, value)| member(keyword, node(value)))
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

/// The keywords that allow exactly `value` of type `scalar`.
pub(super) fn only<'s>(value: Number, scalar: Scalar) -> Vec<Member<'s>> {
    let bounds = exactly(value, scalar);
    if bounds.low == bounds.high {
        return vec![member("const", node(value))];
    }
    let ty = if scalar.is_float() { "number" } else { "integer" };
    [member("type", ty)].into_iter().chain(members(&bounds)).collect()
}

/// A number of a definition; null if JSON can't express it.
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
    #[allow(clippy::approx_constant)] // the neighbours of pi are meant, not pi
    fn bounds_of_float32_let_its_own_nearest_value_through() {
        let pi = std::f64::consts::PI;
        let of = |scalar| {
            let (low, high) = (spread(Number::Float(-pi), scalar).0, spread(Number::Float(pi), scalar).1);
            Constraint::NONE.from(low).to(high).asserted(scalar).expect("a number")
        };
        let holds = |scalar, value| of(scalar).violated_by(Number::Float(value)).is_none();
        for value in [f64::from(std::f32::consts::PI), 3.141_592_7, -3.141_592_7, pi] {
            assert!(holds(Scalar::Float32, value), "{value}");
        }
        assert!(!holds(Scalar::Float32, 3.141_593));
        assert!(!holds(Scalar::Float64, 3.141_592_7));
    }

    #[test]
    fn a_range_only_narrows() {
        let asserted = |of: Numbers, scalar| of.asserted(scalar).expect("a number");
        let byte = asserted(Constraint::NONE, Scalar::UInt8);
        let wide = Constraint::NONE.from(Number::Float(-5.0)).to(Number::Float(300.0));
        assert_eq!(asserted(wide, Scalar::UInt8), byte);
        assert_eq!(asserted(Constraint::NONE.counting(300), Scalar::UInt8), byte);
        let few = asserted(Constraint::NONE.counting(5), Scalar::UInt8);
        assert!(few.violated_by(Number::Int(6)).is_some());
        let long = asserted(Constraint::NONE, Scalar::UInt64);
        let most = i128::from(u64::MAX);
        assert!(
            long.violated_by(Number::Int(most)).is_none()
                && long.violated_by(Number::Int(most + 1)).is_some()
        );
    }

    #[test]
    fn both_forms_of_a_float32_are_exactly_it() {
        let names = |value, scalar| only(value, scalar).into_iter().map(|(name, _)| name).collect::<Vec<_>>();
        assert_eq!(names(Number::Float(0.1), Scalar::Float32), ["type", "minimum", "maximum"]);
        assert_eq!(names(Number::Float(0.1), Scalar::Float64), ["const"]);
        assert_eq!(names(Number::Int(-1), Scalar::Float32), ["const"]);
    }

    #[test]
    fn bounds_that_floats_of_64_bits_cant_tell_are_not_apart() {
        let of = |low, high| Constraint::NONE.from(Number::Int(low)).to(Number::Int(high));
        assert!(are_apart(&of(0, 4), &of(5, 5)) && are_apart(&of(5, 5), &of(0, 4)));
        assert!(!are_apart(&of(0, 5), &of(5, 9)));
        let greatest = i128::from(u64::MAX);
        assert!(!are_apart(&of(0, greatest - 1), &of(greatest, greatest)));
    }
}
