//! What the values of a field may be, from its annotations: the form in which codecs and checks use it.

use uavspec_runtime::{Constraint, Number, Scalar};

use super::model::{Element, Field, Form, Message, Schema};
use super::range::Special;
use crate::msg::Dialect;
use crate::msg::ast::Shape;
use crate::value::Value;

/// A [`Constraint`] that owns its lists.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Restriction {
    /// Least value.
    pub low: Option<Number>,
    /// Greatest value.
    pub high: Option<Number>,
    /// Values with a meaning of their own that the rest would refuse.
    pub special: Vec<Number>,
    /// Length of the array that is counted.
    pub count: Option<u32>,
    /// Documented values, or masks.
    pub known: Option<Vec<i128>>,
    /// Whether values are made of the documented ones bit by bit.
    pub is_flags: bool,
    /// Whether NaN has no meaning.
    pub forbids_nan: bool,
}

impl Restriction {
    /// The same, to check values by.
    pub fn constraint(&self) -> Constraint<'_> {
        Constraint {
            low: self.low,
            high: self.high,
            special: &self.special,
            count: self.count,
            known: self.known.as_deref(),
            names: &[],
            is_flags: self.is_flags,
            forbids_nan: self.forbids_nan,
        }
    }
}

impl Schema {
    /// What the numbers of a field may be; none where its type says all.
    pub fn restriction(&self, message: &Message, field: &Field) -> Option<Restriction> {
        let Form::Msg(dialect) = self.package_of(message).form else { return None };
        let Element::Scalar(scalar) = field.ty.element else { return None };
        if field.is_text(dialect) || scalar == Scalar::Bool {
            return None;
        }
        let bound = |value: Option<&Value>, pick: fn((Value, Value)) -> Value| {
            value.and_then(|value| pick(spread(value, scalar)).number())
        };
        let range = field.range.as_ref();
        let counted = field.counts.and_then(|array| message.fields.get(array));
        let enumeration = field.enumeration.map(|reference| self.enumeration(reference));
        let mut restriction = Restriction {
            low: bound(range.and_then(|range| range.low.as_ref()), |(low, _)| low),
            high: bound(range.and_then(|range| range.high.as_ref()), |(_, high)| high),
            special: Vec::new(),
            count: counted.and_then(|array| match array.ty.shape {
                Shape::Array(length) | Shape::Bounded(length) => Some(length),
                Shape::Single | Shape::Sequence => None,
            }),
            known: enumeration.map(|found| found.members.iter().map(|member| member.value).collect()),
            is_flags: enumeration.is_some_and(|found| found.is_flags),
            forbids_nan: scalar.is_float() && forbids_nan(message, field, dialect),
        };
        let special = [&field.invalid, &field.uncontrolled].into_iter().filter_map(|special| {
            let value = held(special.as_ref()?.value.as_ref()?, scalar)?;
            restriction.constraint().broken_by(value).map(|_| value)
        });
        restriction.special = special.collect();
        let says_nothing = restriction.constraint() == Constraint::NONE;
        (!says_nothing).then_some(restriction)
    }
}

/// Whether NaN has no meaning in a field of floats: so where the definition restricts the field, by a range
/// or by another value that says that there is no data, and neither the annotations nor what is said of the
/// field, of its group or of the whole message speak of NaN.
///
/// Of a field that isn't restricted nothing follows: healthy logs hold NaN in many such. ROS 2 leaves NaN to
/// whoever uses a message.
fn forbids_nan(message: &Message, field: &Field, dialect: Dialect) -> bool {
    let specials = [&field.invalid, &field.uncontrolled];
    let is_restricted = field.range.is_some() || specials.iter().any(|special| special.is_some());
    let is_nan = |special: &Special| {
        matches!(special.value, Some(Value::Float(value)) if value.is_nan()) || says_nan(&special.text)
    };
    let group = field.group.and_then(|group| message.groups.get(group));
    let has_meaning = || {
        specials.into_iter().flatten().any(is_nan)
            || says_nan(&field.description)
            || group.into_iter().chain([&message.docs]).any(|docs| says_nan(&docs.text()))
    };
    dialect == Dialect::Px4 && is_restricted && !has_meaning()
}

/// Whether a text speaks of NaN.
fn says_nan(text: &str) -> bool {
    text.split(|character: char| !character.is_alphanumeric()).any(|word| word.eq_ignore_ascii_case("nan"))
}

/// A value as a field of type `scalar` holds it.
fn held(value: &Value, scalar: Scalar) -> Option<Number> {
    let number = value.number()?;
    match value.as_f64() {
        #[allow(clippy::cast_possible_truncation)] // rounding is what this is about
        Some(value) if scalar == Scalar::Float32 => Some(Number::Float(f64::from(value as f32))),
        Some(value) if scalar == Scalar::Float64 => Some(Number::Float(value)),
        _ => Some(number),
    }
}

/// The greatest `float32` in the shortest form that reads back as it. Most programs write that form,
/// and it is slightly above the exact value, so the exact value as a bound would refuse it.
pub(crate) const MAX_FLOAT32: f64 = 3.402_823_5e38;

/// Least and greatest of the forms in which `value` may stand in JSON when a `scalar` held it.
///
/// A `float32` isn't exactly pi: it is written widened to 64 bits (3.1415927410125732) or in its
/// shortest form (3.1415927), and both are greater than pi.
pub(crate) fn spread(value: &Value, scalar: Scalar) -> (Value, Value) {
    let exact = value.as_f64().filter(|exact| scalar == Scalar::Float32 && exact.abs() < MAX_FLOAT32);
    let Some(exact) = exact else { return (value.clone(), value.clone()) };
    #[allow(clippy::cast_possible_truncation)] // rounding is what this is about
    let rounded = exact as f32;
    let widened = f64::from(rounded);
    let shortest = rounded.to_string().parse().unwrap_or(widened);
    let (low, high) = (widened.min(shortest), widened.max(shortest));
    let low = if low < exact { Value::Float(low) } else { value.clone() };
    let high = if high > exact { Value::Float(high) } else { value.clone() };
    (low, high)
}
