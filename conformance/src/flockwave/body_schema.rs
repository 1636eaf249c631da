//! What values in bodies of Flockwave messages have to look like, and whether they do.
//!
//! Shapes are data. Whole bodies have those that the definitions give them for each direction ([`DefinedSchemas`]), or, where
//! the definitions don't have their type, JSON Schemas of a user ([`Schemas`]); rules on single fields bring along their
//! own (`ExpectedValue`), which may be wider than the definition.
//!
//! ```
//! use uavspec_conformance::definitions::Definitions;
//! use uavspec_conformance::json::Tree;
//!
//! let definitions = Definitions::built_in();
//! let value = Tree::read(r#"{"percentage": 120}"#).unwrap();
//! let mismatch = definitions.defined_schemas().mismatch("flockwave/Progress", &value).flatten().unwrap();
//! assert_eq!((mismatch.path.as_str(), mismatch.actual.as_str()), ("/body/percentage", "120"));
//! ```

mod bodies;
mod check;
mod compile;
mod defined;
mod plain;
mod schemas;

use uavspec_codegen::schema::json_type::Direction;
use uavspec_codegen::source::Span;

pub use self::bodies::DefinedSchemas;
pub(crate) use self::plain::Members;
pub use self::schemas::{SchemaError, Schemas};
use crate::json::{Tree, pointer};

/// The body schemas of all types: those of the definitions, and those of the user for other types.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodySchemas<'s> {
    /// Those of the definitions.
    pub defined_schemas: &'s DefinedSchemas,
    /// Those of the user.
    pub schemas: &'s Schemas,
}

impl BodySchemas<'_> {
    /// True if there is a body schema of this type.
    pub(crate) fn has(&self, type_name: &str) -> bool {
        self.defined_schemas.has(type_name) || self.schemas.has(type_name)
    }

    /// The violations of the schema of a body's type for its direction; none if there is no such schema.
    pub(crate) fn deviations(
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

/// What a value has to be.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ExpectedValue {
    /// An integer from the first to the second, however it is written: `5.0` is one.
    Integer(i128, i128),
    /// `true` or `false`.
    Bool,
    /// Any string.
    Text,
    /// A string of so many characters.
    Length(usize, usize),
    /// The id of an object: 1 to 64 characters, none of them `/`.
    ObjectId,
    /// An array of values of this shape.
    List(&'static ExpectedValue),
    /// An object whose values have this shape.
    Map(&'static ExpectedValue),
    /// Any object.
    Object,
    /// One of these strings.
    OneOf(&'static [&'static str]),
    /// This shape, or null.
    Nullable(&'static ExpectedValue),
}

/// Any integer.
pub(crate) const INTEGER: ExpectedValue = ExpectedValue::Integer(i128::MIN, i128::MAX);

/// A deviation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mismatch {
    /// Where in the value, as a JSON pointer.
    pub path: String,
    /// What should be there.
    pub expected: String,
    /// What is there, shortened.
    pub actual: String,
}

/// What is wrong with a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// It isn't there, and has to be.
    Absent,
    /// It is null.
    Null,
    /// It is of another kind: a string where there should be a number.
    Kind,
    /// It is of its kind, and none of the values that there may be.
    Value,
    /// It is there, and nothing may be.
    Further,
}

/// A step into a body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Into a field that the definition has.
    Field(String),
    /// Into an element, or a value of a map.
    Other,
}

/// Something in a body that hasn't the shape that it should have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Deviation {
    /// The steps that lead to it.
    pub steps: Vec<Step>,
    /// The kind of violation; none if the body schema is one of the user.
    pub fault: Option<Fault>,
    /// The fields of the definition that lead to it, with dots between them; empty where it is in none.
    pub field: String,
    /// Where the definition says what should be.
    pub definition: Option<Span>,
    /// What it is.
    pub mismatch: Mismatch,
}

impl ExpectedValue {
    /// The first deviation of a value.
    pub(crate) fn mismatch(&self, value: &Tree<'_>) -> Option<Mismatch> {
        let wrong = || Some(Mismatch::new(self.to_string(), value.to_string()));
        match (self, value) {
            (Self::Nullable(_), Tree::Null)
            | (Self::Bool, Tree::Bool(_))
            | (Self::Object, Tree::Object(_)) => None,
            (Self::Nullable(schema), _) => schema.mismatch(value),
            (Self::Integer(low, high), _) => match integer(value) {
                Some(number) if (*low..=*high).contains(&number) => None,
                _ => wrong(),
            },
            (Self::List(schema), Tree::List(values)) => {
                let of = |(at, value)| Some(schema.mismatch(value)?.below(&at_index(at)));
                values.iter().enumerate().find_map(of)
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

/// In words.
impl std::fmt::Display for ExpectedValue {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Integer(i128::MIN, i128::MAX) => formatter.write_str("an integer"),
            Self::Integer(low, i128::MAX) => write!(formatter, "an integer, {low} or more"),
            Self::Integer(i128::MIN, high) => write!(formatter, "an integer, {high} at most"),
            Self::Integer(low, high) => write!(formatter, "an integer, {low} to {high}"),
            Self::Bool => formatter.write_str("true or false"),
            Self::Text => formatter.write_str("a string"),
            Self::Length(low, high) => write!(formatter, "a string of {low} to {high} characters"),
            Self::ObjectId => formatter.write_str("a string of 1 to 64 characters without `/`"),
            Self::List(schema) => write!(formatter, "a list, each entry {schema}"),
            Self::Map(schema) => write!(formatter, "an object, each value {schema}"),
            Self::Object => formatter.write_str("an object"),
            Self::OneOf(known) => write!(formatter, "one of {}", known.join(", ")),
            Self::Nullable(schema) => write!(formatter, "{schema}, or null"),
        }
    }
}

impl Mismatch {
    /// At the value itself.
    pub(crate) fn new(expected: impl Into<String>, actual: impl Into<String>) -> Self {
        Self { path: String::new(), expected: expected.into(), actual: actual.into() }
    }

    /// The same, seen from the value that holds it under a key.
    #[must_use]
    pub(crate) fn below(self, key: &str) -> Self {
        Self { path: pointer(&[key]) + &self.path, ..self }
    }
}

/// An integer, however it is written. Those beyond 2^53 that have a fraction or an exponent are taken as they round.
pub(crate) fn integer(value: &Tree<'_>) -> Option<i128> {
    match value {
        Tree::Int(value) => Some(*value),
        #[allow(clippy::cast_possible_truncation)] // within bounds
        Tree::Float(value, _) if value.fract() == 0.0 && value.abs() < 1e30 => Some(*value as i128),
        _ => None,
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
