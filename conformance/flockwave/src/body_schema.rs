//! The schemas of Flockwave message bodies, and the code that checks values against them.
//!
//! Schemas are data. A message body has a separate schema for each direction. The body schemas are compiled from the
//! definitions ([`DefinedSchemas`]). For undefined types, users can supply JSON Schemas ([`Schemas`]) if the crate has
//! the feature `schemas`. Rules that check a single field use separate schemas (`ExpectedValue`), which may be less
//! strict than the definitions.
//!
//! ```
//! use uavspec_flockwave::body_schema::ExpectedValue;
//! use uavspec_model::json::Tree;
//!
//! let value = Tree::read("120").unwrap();
//! let mismatch = ExpectedValue::Integer(0, 100).mismatch(&value).unwrap();
//! assert_eq!((mismatch.expected.as_str(), mismatch.actual.as_str()), ("an integer from 0 to 100", "120"));
//! ```

mod bodies;
mod check;
mod compile;
mod defined;
mod plain;
#[cfg_attr(not(feature = "schemas"), path = "body_schema/absent.rs")]
mod schemas;

use std::fmt;
use std::sync::Arc;

use uavspec_model::json::{Tree, pointer};
use uavspec_schema::json_type::Direction;
use uavspec_schema::source::Span;

pub use self::bodies::DefinedSchemas;
pub use self::plain::Members;
pub use self::schemas::{SchemaError, Schemas};

/// The body schemas of all types: schemas from the definitions, and user-supplied schemas for other types.
#[derive(Clone, Copy, Debug)]
pub struct BodySchemas<'s> {
    /// The schemas from the definitions.
    pub defined_schemas: &'s DefinedSchemas,
    /// The schemas from the user.
    pub schemas: &'s Schemas,
}

impl BodySchemas<'_> {
    /// True if there is a body schema for this type.
    pub fn has(&self, type_name: &str) -> bool {
        self.defined_schemas.has(type_name) || self.schemas.has(type_name)
    }

    /// True if there is a body schema for this type and direction.
    pub fn is_defined(&self, type_name: &str, direction: Direction) -> bool {
        if self.defined_schemas.has(type_name) {
            self.defined_schemas.is_defined(type_name, direction)
        } else {
            self.schemas.is_defined(type_name, direction)
        }
    }

    /// The violations of the body schema for a type and direction. `None` if there is no such schema.
    pub fn deviations(
        &self,
        type_name: &str,
        direction: Direction,
        body: &Tree<'_>,
    ) -> Option<Vec<Deviation>> {
        if self.defined_schemas.has(type_name) {
            self.defined_schemas.check(type_name, direction, body)
        } else {
            self.schemas.check(type_name, direction, body)
        }
    }
}

/// The expected form of a value.
#[derive(Clone, Copy, Debug)]
pub enum ExpectedValue {
    /// An integer between the first and the second value, inclusive. `5.0` counts as an integer.
    Integer(i128, i128),
    /// Any number.
    Number,
    /// `true` or `false`.
    Bool,
    /// Any string.
    Text,
    /// A string with a minimum and a maximum length in characters.
    Length(usize, usize),
    /// An object id: a string of 1 to 64 characters that contains no `/`.
    ObjectId,
    /// A list whose elements have this form.
    List(&'static ExpectedValue),
    /// An object whose values have this form.
    Map(&'static ExpectedValue),
    /// Any object.
    Object,
    /// One of these strings.
    OneOf(&'static [&'static str]),
    /// A value of this form, or null.
    Nullable(&'static ExpectedValue),
}

/// Any integer.
pub const INTEGER: ExpectedValue = ExpectedValue::Integer(i128::MIN, i128::MAX);

/// A value that differs from its expected form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mismatch {
    /// The location in the value, as a JSON pointer.
    pub path: String,
    /// The expected value.
    pub expected: String,
    /// The actual value, shortened.
    pub actual: String,
}

/// The kind of a violation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A required field is missing.
    Absent,
    /// The value is null.
    Null,
    /// The value has the wrong type, e.g. a string instead of a number.
    Kind,
    /// The type is correct, but the value isn't allowed.
    Value,
    /// The field isn't allowed.
    Additional,
    /// The field isn't allowed, and it holds requested objects that belong in another field.
    Misplaced,
}

/// A step of the path to a value in a body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// A defined field.
    Field(Arc<str>),
    /// A list element or a map value.
    Other,
}

/// A violation of a body schema.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deviation {
    /// The path to the value.
    pub steps: Vec<Step>,
    /// True if the value belongs to an optional field or to an optional element of an array.
    pub is_optional: bool,
    /// The kind of violation. `None` if the body schema is user-supplied.
    pub fault: Option<Fault>,
    /// The defined fields on the path, joined by dots; empty if there are none.
    pub field: String,
    /// The location of the definition.
    pub definition: Option<Span>,
    /// The location in the body, with the expected and the actual value.
    pub mismatch: Mismatch,
}

impl ExpectedValue {
    /// The first mismatch between a value and this form.
    pub fn mismatch(&self, value: &Tree<'_>) -> Option<Mismatch> {
        let wrong = || Some(Mismatch::new(self.to_string(), value.to_string()));
        match (self, value) {
            (Self::Nullable(_), Tree::Null)
            | (Self::Bool, Tree::Bool(_))
            | (Self::Number, Tree::Int(_) | Tree::Float(..) | Tree::Huge(_))
            | (Self::Object, Tree::Object(_)) => None,
            (Self::Nullable(schema), _) => schema.mismatch(value),
            (Self::Integer(low, high), _) => match value.as_integer() {
                Some(number) if (*low..=*high).contains(&number) => None,
                _ => wrong(),
            },
            (Self::List(schema), Tree::List(values)) => {
                let element_mismatch = |(at, value)| Some(schema.mismatch(value)?.below(&at_index(at)));
                values.iter().enumerate().find_map(element_mismatch)
            }
            (Self::Map(schema), Tree::Object(members)) => {
                members.iter().find_map(|(key, value)| Some(schema.mismatch(value)?.below(key)))
            }
            (_, Tree::Text(text)) if self.accepts_text(text) => None,
            _ => wrong(),
        }
    }

    fn accepts_text(&self, text: &str) -> bool {
        match self {
            Self::Text => true,
            Self::Length(low, high) => (*low..=*high).contains(&text.chars().count()),
            Self::ObjectId => (1..=64).contains(&text.chars().count()) && !text.contains('/'),
            Self::OneOf(known) => known.contains(&text),
            _ => false,
        }
    }
}

impl fmt::Display for ExpectedValue {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(i128::MIN, i128::MAX) => formatter.write_str("an integer"),
            Self::Integer(low, i128::MAX) => write!(formatter, "an integer of at least {low}"),
            Self::Integer(i128::MIN, high) => write!(formatter, "an integer of at most {high}"),
            Self::Integer(low, high) => write!(formatter, "an integer from {low} to {high}"),
            Self::Number => formatter.write_str("a number"),
            Self::Bool => formatter.write_str("true or false"),
            Self::Text => formatter.write_str("a string"),
            Self::Length(low, high) => write!(formatter, "a string of {low} to {high} characters"),
            Self::ObjectId => {
                formatter.write_str("a string that is 1 to 64 characters long and contains no `/`")
            }
            Self::List(schema) => write!(formatter, "a list where each element is {schema}"),
            Self::Map(schema) => write!(formatter, "an object where each value is {schema}"),
            Self::Object => formatter.write_str("an object"),
            Self::OneOf(known) => write!(formatter, "one of {}", known.join(", ")),
            Self::Nullable(schema) => write!(formatter, "{schema}, or null"),
        }
    }
}

impl Mismatch {
    /// Creates a mismatch with an empty path, which refers to the whole value.
    pub fn new(expected: impl Into<String>, actual: impl Into<String>) -> Self {
        Self { path: String::new(), expected: expected.into(), actual: actual.into() }
    }

    /// Adds a key to the start of the path.
    #[must_use]
    pub(crate) fn below(self, key: &str) -> Self {
        Self { path: pointer(&[key]) + &self.path, ..self }
    }
}

fn at_index(at: usize) -> String {
    at.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mismatch(schema: ExpectedValue, text: &str) -> Option<(String, String)> {
        let tree = Tree::read(text).expect("JSON");
        schema.mismatch(&tree).map(|found| (found.path, found.actual))
    }

    #[test]
    fn integers_may_be_written_with_a_fraction_of_zero() {
        assert_eq!(mismatch(INTEGER, "5.0"), None);
        assert_eq!(mismatch(INTEGER, "5e3"), None);
        assert_eq!(mismatch(INTEGER, "5.5"), Some((String::new(), "5.5".to_owned())));
        assert_eq!(mismatch(ExpectedValue::Integer(0, 9), "10"), Some((String::new(), "10".to_owned())));
        assert!(mismatch(INTEGER, "1e400").is_some() && mismatch(INTEGER, "true").is_some());
    }

    #[test]
    fn reports_the_first_deviation_with_its_location() {
        let map = ExpectedValue::Map(&ExpectedValue::List(&ExpectedValue::Text));
        assert_eq!(mismatch(map, r#"{"a/b": ["x", 7]}"#), Some(("/a~1b/1".to_owned(), "7".to_owned())));
    }
}
