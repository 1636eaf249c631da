//! Faults: the possible violations in a message.
//!
//! A message descriptor determines the number of faults. Each rule that a field or its elements can violate is one
//! fault, regardless of the number of elements. [`Draw`](super::draw::Draw) counts in the same order to find the fault
//! with a given index.

use std::vec::Vec;

use super::number::Allowed;
use super::tree::Node;
use crate::descriptor::{Element, FieldDescriptor, MessageDescriptor, Shape};
use crate::{Constraint, ConstraintKind, Number, Path, Scalar};

/// Faults exceed a bound only if it is at most this large. More elements would take too long to generate.
const GREATEST_BOUND: u32 = 4096;

/// The number of faults in a message.
pub(super) fn count(message: &MessageDescriptor) -> usize {
    message.fields.iter().map(in_field).sum()
}

/// The number of faults in a field: the faults in its length, followed by the faults in its elements.
pub(super) fn in_field(field: &FieldDescriptor) -> usize {
    let is_empty = matches!(field.shape, Shape::Array(0) | Shape::Bounded(0));
    in_length(field.shape) + if is_empty { 0 } else { in_element(field) }
}

/// The number of faults in the length of a field.
pub(super) fn in_length(shape: Shape) -> usize {
    match shape {
        Shape::Bounded(bound) => usize::from(bound <= GREATEST_BOUND),
        Shape::Single | Shape::Array(_) | Shape::Sequence => 0,
    }
}

fn in_element(field: &FieldDescriptor) -> usize {
    match field.element {
        Element::Scalar(scalar) => rules(scalar, restriction(field)).count(),
        Element::Text => 1,
        Element::String { bound, .. } => usize::from(bound.is_some_and(|bound| bound <= GREATEST_BOUND)),
        Element::Message(nested) => count(nested),
    }
}

/// The constraint on the numbers of a field.
pub(super) fn restriction(field: &FieldDescriptor) -> &'static Constraint<'static> {
    field.constraint.unwrap_or(&Constraint::NONE)
}

/// The rules that a number can violate.
pub(super) fn rules(
    scalar: Scalar,
    constraint: &'static Constraint<'static>,
) -> impl Iterator<Item = ConstraintKind> {
    ConstraintKind::ALL.into_iter().filter(move |rule| !values(scalar, constraint, *rule).is_empty())
}

/// Numbers of a type that violate `rule`, starting with the numbers closest to the valid range.
pub(super) fn values(scalar: Scalar, constraint: &Constraint<'_>, rule: ConstraintKind) -> Vec<Number> {
    let allowed = Allowed { scalar, constraint };
    let candidates: Vec<Number> = if scalar.is_float() {
        floats(allowed).into_iter().map(Number::Float).collect()
    } else {
        integers(allowed).into_iter().filter(|value| fits(scalar, *value)).map(Number::Int).collect()
    };
    candidates.into_iter().filter(|value| constraint.violated_by(*value) == Some(rule)).collect()
}

/// True if a field of the type can contain the integer.
pub(super) fn fits(scalar: Scalar, value: i128) -> bool {
    scalar.integer_bounds().is_some_and(|(min, max)| (min..=max).contains(&value))
}

/// Integers adjacent to the allowed values, and the extremes of the type.
fn integers(allowed: Allowed<'_>) -> Vec<i128> {
    /// The maximum number of documented values whose neighbours are tried.
    const NEIGHBOURS: usize = 32;
    let Some((min, max)) = allowed.scalar.integer_bounds() else { return Vec::new() };
    let (low, high) = allowed.integers().unwrap_or((min, max));
    let mut values = Vec::from([high + 1, low - 1]);
    if let Some(known) = allowed.constraint.known {
        if allowed.constraint.is_flags {
            // In a signed number, the top bit makes the number negative.
            values.extend(
                (0..8 * allowed.scalar.size()).map(|bit| 1 << bit).map(
                    |bit: i128| {
                        if bit > max { -bit } else { bit }
                    },
                ),
            );
        } else {
            values.extend(known.iter().take(NEIGHBOURS).flat_map(|value| [value + 1, value - 1]));
            values.extend(known.iter().max().map(|value| value + 1));
            values.extend(known.iter().min().map(|value| value - 1));
            values.extend([0, low, high]);
        }
    }
    values.extend([max, min]);
    values
}

/// NaN, finite floats adjacent to the allowed values, and the finite extremes of the type.
#[allow(clippy::cast_possible_truncation)] // 32-bit floats don't change
fn floats(allowed: Allowed<'_>) -> Vec<f64> {
    let is_single = allowed.scalar == Scalar::Float32;
    let Some((low, high)) = allowed.floats() else { return Vec::from([f64::NAN]) };
    let neighbours = if is_single {
        [f64::from((high as f32).next_up()), (low as f32).next_down().into()]
    } else {
        [high.next_up(), low.next_down()]
    };
    let max = if is_single { f32::MAX.into() } else { f64::MAX };
    let further = [high.abs() * 2.0 + 1.0, -(low.abs() * 2.0 + 1.0), max, -max];
    let round = |value: f64| if is_single { f64::from(value as f32) } else { value };
    let finite = neighbours.into_iter().chain(further.map(round)).filter(|value| value.is_finite());
    finite.chain([f64::NAN]).collect()
}

/// Finds the fault in the message with the given `root`. Extends `path` to the location of the fault and returns the
/// violated rule.
pub(super) fn locate(message: &'static MessageDescriptor, root: &Node, path: &mut Path) -> ConstraintKind {
    let parts = root.parts().iter().enumerate();
    let faulty = parts.zip(message.fields).find(|((_, part), _)| part.fault.is_some());
    // The tree has one fault, which simplification preserves.
    let Some(((index, mut part), field)) = faulty else { return root.fault.unwrap_or(ConstraintKind::Range) };
    path.enter(index);
    let is_list = field.shape != Shape::Single && field.element != Element::Text;
    if is_list {
        let element = part.parts().iter().enumerate().find(|(_, element)| element.fault.is_some());
        let Some((index, element)) = element else { return part.fault.unwrap_or(ConstraintKind::Bound) };
        path.select(Some(index));
        part = element;
    }
    match (field.element, part.fault) {
        (Element::Message(nested), _) => locate(nested, part, path),
        (_, Some(rule)) => rule,
        (_, None) => ConstraintKind::Range,
    }
}
