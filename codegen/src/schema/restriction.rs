//! Valid numbers of a field by all of its annotations, in the form that codecs and checks use.

use uavspec_runtime::{Constraint, Number, Scalar};

use super::model::{Element, Field, Form, Message, Schema};
use crate::msg::Dialect;
use crate::msg::ast::Shape;
use crate::msg::constraint::Stated;
use crate::msg::constraint::number::held;
use crate::value::Value;

/// A [`Constraint`] that owns its lists.
#[derive(Clone, Debug, PartialEq)]
pub struct Restriction {
    /// The constraint without its lists.
    pub limits: Constraint<'static>,
    /// Values with a special meaning that the rest would refuse.
    pub special: Vec<Number>,
    /// Documented values, or masks.
    pub known: Option<Vec<i128>>,
    /// The demands in `limits`: methods of [`Constraint`], each with its argument.
    pub(crate) demands: Vec<(&'static str, Number)>,
}

impl Default for Restriction {
    fn default() -> Self {
        Self { limits: Constraint::NONE, special: Vec::new(), known: None, demands: Vec::new() }
    }
}

impl Restriction {
    /// The constraint to check values by.
    pub fn constraint(&self) -> Constraint<'_> {
        Constraint { special: &self.special, known: self.known.as_deref(), ..self.limits }
    }
}

impl Schema {
    /// The restriction of the numbers of a field; none if its type says all.
    pub fn restriction(&self, message: &Message, field: &Field) -> Option<Restriction> {
        let Form::Msg(dialect) = self.package_of(message).form else { return None };
        let Element::Scalar(scalar) = field.ty.element else { return None };
        if field.is_text(dialect) || scalar == Scalar::Bool {
            return None;
        }
        let counted = field.counts.and_then(|array| message.fields.get(array));
        let enumeration = field.enumeration.map(|reference| self.enumeration(reference));
        let mut restriction = Restriction {
            limits: Constraint {
                count: counted.and_then(|array| match array.ty.shape {
                    Shape::Array(length) | Shape::Bounded(length) => Some(length),
                    Shape::Single | Shape::Sequence => None,
                }),
                is_flags: enumeration.is_some_and(|found| found.is_flags),
                forbids_nan: scalar.is_float() && forbids_nan(message, field, dialect),
                ..Constraint::NONE
            },
            known: enumeration.map(|found| found.members.iter().map(|member| member.value).collect()),
            ..Restriction::default()
        };
        for demand in field.constraints.iter().flat_map(|constraint| constraint.demands(scalar)) {
            restriction.limits = (demand.apply)(restriction.limits, demand.number);
            restriction.demands.push((demand.method, demand.number));
        }
        let special = field.constraints.iter().filter(|constraint| constraint.is_special());
        let special = special.filter_map(|constraint| held(constraint.stated.value()?, scalar));
        let is_refused = |value: &Number| restriction.constraint().violated_by(*value).is_some();
        restriction.special = special.filter(is_refused).collect();
        (restriction.constraint() != Constraint::NONE).then_some(restriction)
    }
}

/// True if NaN has no meaning in a field of floats: the definition constrains the field, and neither the annotations
/// nor the texts of the field, of its group or of the message mention NaN.
///
/// Fields without constraints may be NaN: healthy logs hold NaN in many of them. ROS 2 leaves NaN to the user of a
/// message.
fn forbids_nan(message: &Message, field: &Field, dialect: Dialect) -> bool {
    let is_nan = |stated: &Stated| matches!(stated.value(), Some(Value::Float(value)) if value.is_nan());
    let group = field.group.and_then(|group| message.groups.get(group));
    let has_meaning = || {
        field.constraints.iter().any(|found| is_nan(&found.stated) || says_nan(&found.text))
            || says_nan(&field.description)
            || group.into_iter().chain([&message.docs]).any(|docs| says_nan(&docs.text()))
    };
    dialect == Dialect::Px4 && !field.constraints.is_empty() && !has_meaning()
}

/// True if a text mentions NaN.
fn says_nan(text: &str) -> bool {
    text.split(|character: char| !character.is_alphanumeric()).any(|word| word.eq_ignore_ascii_case("nan"))
}
