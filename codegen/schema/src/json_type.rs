//! JSON types and messages of specification tables.
//!
//! ```
//! use uavspec_schema::json_type::Direction;
//!
//! assert_eq!(Direction::Request.title(), "Request");
//! ```

use super::documentation::Docs;
use crate::msg::constraint::Range;
use crate::source::Span;
pub use crate::table::type_table::Direction;

/// The type name for the package's error codes.
pub(crate) const ERROR_CODE: &str = "ErrorCode";

/// The type name for lists of error codes.
pub(crate) const ERROR_LIST: &str = "ErrorList";

/// The index of a type in a `Schema`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JsonTypeId(pub u32);

/// The index of a message in a `Schema`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JsonMessageId(pub u32);

/// A type.
#[derive(Clone, Debug, PartialEq)]
pub struct JsonType {
    /// The index of the package.
    pub package: usize,
    /// The name.
    pub name: String,
    /// The paragraphs above the table.
    pub docs: Docs,
    /// The definition.
    pub definition: Definition,
    /// The heading.
    pub span: Span,
}

/// The definition of a type.
#[derive(Clone, Debug, PartialEq)]
pub enum Definition {
    /// JSON objects.
    Object(Object),
    /// JSON arrays with a meaning for each position. Required elements precede optional ones.
    Tuple(Vec<Member>),
    /// A set of known values, open or closed.
    Set(Set),
    /// An alias of another type, with a separate meaning.
    Named(Typed),
}

impl Definition {
    /// The fields of an object, or the elements of a tuple.
    pub fn members(&self) -> &[Member] {
        match self {
            Self::Object(object) => &object.fields,
            Self::Tuple(elements) => elements,
            Self::Set(_) | Self::Named(_) => &[],
        }
    }

    /// The types of all parts, or the type of an alias.
    pub fn typed(&self) -> impl Iterator<Item = &Typed> {
        let named = if let Self::Named(typed) = self { Some(typed) } else { None };
        self.members().iter().map(|member| &member.typed).chain(named)
    }
}

/// JSON objects.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// The fields, in order.
    pub fields: Vec<Member>,
    /// True if further fields are forbidden; otherwise they are allowed and ignored.
    pub is_closed: bool,
}

/// A field of an object, or an element of a tuple.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// The name.
    pub name: String,
    /// True if the field or element is required.
    pub is_required: bool,
    /// The type of the values.
    pub typed: Typed,
    /// The description, without annotations.
    pub description: String,
    /// The cell with the name.
    pub span: Span,
}

/// A type with restrictions.
#[derive(Clone, Debug, PartialEq)]
pub struct Typed {
    /// The type.
    pub ty: Expression,
    /// The restrictions.
    pub limits: Limits,
}

/// The annotations of a value. Units, ranges, patterns and formats also apply to the numbers and strings in lists and
/// maps. Lengths apply to lists or, if there is no list, to strings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits {
    /// The unit: one of `crate::unit::UNITS`, or the unit as written.
    pub unit: Option<String>,
    /// The bounds of numbers.
    pub range: Option<Range>,
    /// The minimum length, in characters or elements.
    pub min: Option<u32>,
    /// The maximum length, in characters or elements.
    pub max: Option<u32>,
    /// True if the elements of the list are distinct.
    pub is_unique: bool,
    /// A regular expression that strings must match.
    pub pattern: Option<String>,
    /// The encoding of strings: one of `crate::msg::statement::FORMATS`.
    pub format: Option<String>,
}

impl Limits {
    /// The limits for list elements or map values.
    #[must_use]
    pub fn of_elements(&self) -> Self {
        Self { min: None, max: None, is_unique: false, ..self.clone() }
    }

    /// True if any limit restricts values.
    pub fn is_restriction(&self) -> bool {
        Self { unit: None, ..self.clone() } != Self::default()
    }
}

/// A type expression.
#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    /// Any JSON value.
    Any,
    /// `null`.
    Null,
    /// `true` or `false`.
    Boolean,
    /// An integer.
    Integer,
    /// Any number.
    Number,
    /// A string.
    String,
    /// An error code of the package.
    ErrorCode,
    /// A list of error codes.
    ErrorList,
    /// A type of the package.
    Named(JsonTypeId),
    /// A JSON array of elements of one type.
    List(Box<Expression>),
    /// A JSON object whose keys are ids and whose values have one type.
    Map(Box<Expression>),
    /// One of several types.
    Either(Vec<Expression>),
    /// One of some strings.
    OneOf(Vec<String>),
}

impl Expression {
    /// True if the expression allows `null`, not counting named types.
    pub fn is_nullable(&self) -> bool {
        match self {
            Self::Null => true,
            Self::Either(alternatives) => alternatives.iter().any(Self::is_nullable),
            _ => false,
        }
    }

    /// The expression without `null`, or `None` if it is only `null`.
    pub fn without_null(&self) -> Option<Self> {
        match self {
            Self::Null => None,
            Self::Either(alternatives) => {
                let mut rest: Vec<Self> = alternatives.iter().filter_map(Self::without_null).collect();
                if rest.len() > 1 { Some(Self::Either(rest)) } else { rest.pop() }
            }
            other => Some(other.clone()),
        }
    }

    /// The named types among the expression and its alternatives, without types in lists and maps.
    pub fn alternatives(&self) -> Vec<JsonTypeId> {
        match self {
            Self::Named(id) => vec![*id],
            Self::Either(alternatives) => alternatives.iter().flat_map(Self::alternatives).collect(),
            _ => Vec::new(),
        }
    }

    /// Calls `visit` with this expression and all expressions within it.
    pub fn walk(&self, visit: &mut impl FnMut(&Self)) {
        visit(self);
        match self {
            Self::List(inner) | Self::Map(inner) => inner.walk(visit),
            Self::Either(alternatives) => alternatives.iter().for_each(|inner| inner.walk(visit)),
            _ => {}
        }
    }
}

/// A set of integers or of strings.
#[derive(Clone, Debug, PartialEq)]
pub struct Set {
    /// The values, in order.
    pub values: SetValues,
    /// True if other values are allowed.
    pub is_open: bool,
}

/// The values of a set.
#[derive(Clone, Debug, PartialEq)]
pub enum SetValues {
    /// Integers.
    Integers(Vec<SetValue<i64>>),
    /// Strings.
    Strings(Vec<SetValue<String>>),
}

/// A value of a set.
#[derive(Clone, Debug, PartialEq)]
pub struct SetValue<T> {
    /// The value.
    pub value: T,
    /// The description.
    pub description: String,
}

/// A message: all bodies with the same `type`, at most one for each direction.
#[derive(Clone, Debug, PartialEq)]
pub struct JsonMessage {
    /// The index of the package.
    pub package: usize,
    /// The message type.
    pub name: String,
    /// The paragraphs under the heading.
    pub docs: Docs,
    /// The bodies, sorted by direction.
    pub parts: Vec<JsonPart>,
    /// The heading.
    pub span: Span,
}

/// The body of a message in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct JsonPart {
    /// The direction.
    pub direction: Direction,
    /// The message name and the direction, as in `UAV-INF.request`. Also used in file names.
    pub name: String,
    /// The paragraphs under the subheading.
    pub docs: Docs,
    /// The types of the messages that answer a request, in order.
    pub answers: Vec<String>,
    /// The body. The first field is `type`, which contains the name of the message.
    pub body: Object,
    /// The subheading.
    pub span: Span,
}

/// The name of the field with the message type.
pub const TYPE_FIELD: &str = "type";

impl JsonPart {
    /// The fields except `type`.
    pub fn fields(&self) -> &[Member] {
        self.body.fields.split_first().map_or(&[], |(_, rest)| rest)
    }
}
