//! The valid numbers of a field according to all of its annotations, for codecs and checks.

use uavspec_runtime::{Constraint, Number, Scalar};

use super::bits;
use super::enumeration::Enum;
use super::model::{Element, Field, Form, Message, Schema};
use crate::msg::Dialect;
use crate::msg::constraint::number::stored;
use crate::value::Value;

/// A [`Constraint`] that owns its lists.
#[derive(Clone, Debug, PartialEq)]
pub struct Restriction {
    /// The constraint without its lists.
    pub limits: Constraint<'static>,
    /// Values that have a special meaning, but are excluded by the other constraints.
    pub special: Vec<Number>,
    /// Documented values, or masks.
    pub known: Option<Vec<i128>>,
    /// The requirements in `limits`: methods of [`Constraint`] and their arguments.
    pub demands: Vec<(&'static str, Number)>,
}

impl Default for Restriction {
    fn default() -> Self {
        Self { limits: Constraint::NONE, special: Vec::new(), known: None, demands: Vec::new() }
    }
}

impl Restriction {
    /// The constraint for checks of values.
    pub fn constraint(&self) -> Constraint<'_> {
        Constraint { special: &self.special, known: self.known.as_deref(), ..self.limits }
    }
}

impl Schema {
    /// The enum of a field, if its values are restricted to the members. Bits that the definition doesn't declare with
    /// `@flags` may have any combination.
    pub fn enforced_enum(&self, field: &Field) -> Option<&Enum> {
        let reference = field.enumeration.filter(|_| field.is_enum_exact)?;
        let found = self.enumeration(reference);
        let are_bits =
            || bits::are_bits(found, self.message(reference.message)) || bits::mentions_bits(field);
        (found.is_flags || !are_bits()).then_some(found)
    }

    /// The restriction of a numeric field, or `None` if all values of its type are valid.
    pub fn restriction(&self, message: &Message, field: &Field) -> Option<Restriction> {
        let Form::Msg(dialect) = self.package_of(message).form else { return None };
        let Element::Scalar(scalar) = field.ty.element else { return None };
        if scalar == Scalar::Bool {
            return None;
        }
        let counted = field.counts.and_then(|array| message.fields.get(array));
        let enumeration = self.enforced_enum(field);
        let mut restriction = Restriction {
            limits: Constraint {
                count: counted.and_then(|array| array.ty.max_length()),
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
        let is_excluded = |value: &Number| restriction.constraint().violated_by(*value).is_some();
        restriction.special = field.special_values().into_iter().filter(is_excluded).collect();
        (restriction.constraint() != Constraint::NONE).then_some(restriction)
    }
}

/// True if NaN is invalid in a float field. NaN is invalid if the definition restricts the field and doesn't mention
/// NaN.
///
/// Unconstrained fields may be NaN, which is common in valid logs. In ROS 2, the users of a message decide whether NaN
/// is valid.
fn forbids_nan(message: &Message, field: &Field, dialect: Dialect) -> bool {
    dialect == Dialect::Px4 && field.is_restricted() && !mentions_nan(message, field)
}

/// True if the definition mentions NaN in the field's annotations, or in the texts of the field, the group or the
/// message.
pub fn mentions_nan(message: &Message, field: &Field) -> bool {
    let group = field.group.and_then(|group| message.groups.get(group));
    field.gives_nan_a_meaning()
        || group.into_iter().chain([&message.docs]).any(|docs| text_mentions_nan(&docs.text()))
}

impl Field {
    /// The values that have a special meaning, including values that the other constraints allow.
    pub fn special_values(&self) -> Vec<Number> {
        let Element::Scalar(scalar) = self.ty.element else { return Vec::new() };
        let special = self.constraints.iter().filter(|constraint| constraint.is_special());
        special.filter_map(|constraint| stored(constraint.stated.value()?, scalar)).collect()
    }

    /// True if the definition mentions NaN in the annotations or the text of the field.
    pub fn gives_nan_a_meaning(&self) -> bool {
        self.states_nan()
            || self.constraints.iter().any(|found| text_mentions_nan(&found.text))
            || text_mentions_nan(&self.description)
    }

    /// True if an annotation of the field gives NaN a meaning.
    pub fn states_nan(&self) -> bool {
        self.constraints.iter().any(|found| found.stated.value().is_some_and(Value::is_nan))
    }
}

/// True if a text mentions NaN.
fn text_mentions_nan(text: &str) -> bool {
    text.split(|character: char| !character.is_alphanumeric()).any(|word| word.eq_ignore_ascii_case("nan"))
}
