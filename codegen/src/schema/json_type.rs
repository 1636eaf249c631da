//! Types and messages of specification tables: what JSON they describe.
//!
//! ```
//! use uavspec_codegen::schema::json_type::Direction;
//!
//! assert_eq!(Direction::Request.title(), "Request");
//! ```

use super::documentation::Docs;
use crate::msg::constraint::Range;
use crate::source::Span;
pub use crate::table::type_table::Direction;

/// The name that stands for an error code of the package, where it has error codes.
pub(crate) const ERROR_CODE: &str = "ErrorCode";

/// The name that stands for a list of such codes.
pub(crate) const ERROR_LIST: &str = "ErrorList";

/// Names a type of a `Schema`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JsonTypeId(pub u32);

/// Names a message of a `Schema`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JsonMessageId(pub u32);

/// A type.
#[derive(Clone, Debug, PartialEq)]
pub struct JsonType {
    /// Index of its package.
    pub package: usize,
    /// Its name.
    pub name: String,
    /// What the paragraphs above its table say.
    pub docs: Docs,
    /// What its values are.
    pub definition: Definition,
    /// The heading.
    pub span: Span,
}

/// What the values of a type are.
#[derive(Clone, Debug, PartialEq)]
pub enum Definition {
    /// JSON objects.
    Object(Object),
    /// JSON arrays with a meaning for each position. None that is required stands behind one that isn't.
    Tuple(Vec<Member>),
    /// Some values, or any beside them.
    Set(Set),
    /// Those of another type, with a meaning of their own.
    Named(Typed),
}

/// JSON objects.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// The fields, in order.
    pub fields: Vec<Member>,
    /// Whether there are no others. Else they are allowed, and mean nothing.
    pub is_closed: bool,
}

/// A field of an object, or an element of a tuple.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Its name.
    pub name: String,
    /// Whether it may not be left out.
    pub is_required: bool,
    /// Its values.
    pub typed: Typed,
    /// What is said of it, annotations taken out.
    pub description: String,
    /// The cell of its name.
    pub span: Span,
}

/// A type with what restricts it in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Typed {
    /// The type.
    pub ty: Expression,
    /// The restrictions.
    pub limits: Limits,
}

/// What annotations say of values. Units, ranges, patterns and formats are those of the numbers and strings
/// within lists and maps; lengths are those of lists or, where there is none, of strings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits {
    /// The unit: one of `crate::unit::UNITS`, or as written.
    pub unit: Option<String>,
    /// Bounds of numbers.
    pub range: Option<Range>,
    /// Least length, in characters or elements.
    pub least: Option<u32>,
    /// Greatest length, in characters or elements.
    pub most: Option<u32>,
    /// Whether no element stands twice in the list.
    pub is_unique: bool,
    /// A regular expression that strings satisfy.
    pub pattern: Option<String>,
    /// The encoding of strings: one of `crate::msg::statement::FORMATS`.
    pub format: Option<String>,
}

impl Limits {
    /// What holds of the elements of a list or the values of a map.
    #[must_use]
    pub fn of_elements(&self) -> Self {
        Self { least: None, most: None, is_unique: false, ..self.clone() }
    }

    /// Whether any of it restricts values.
    pub fn is_restriction(&self) -> bool {
        Self { unit: None, ..self.clone() } != Self::default()
    }
}

/// A type expression.
#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    /// Any JSON value.
    Any,
    /// `null` alone.
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
    /// A list of such codes.
    ErrorList,
    /// A type of the package.
    Named(JsonTypeId),
    /// A JSON array whose elements are alike.
    List(Box<Expression>),
    /// A JSON object whose values are alike and whose keys are ids.
    Map(Box<Expression>),
    /// One of several types.
    Either(Vec<Expression>),
    /// One of some strings.
    OneOf(Vec<String>),
}

impl Expression {
    /// Whether `null` is a value by the expression itself.
    pub fn is_nullable(&self) -> bool {
        match self {
            Self::Null => true,
            Self::Either(alternatives) => alternatives.iter().any(Self::is_nullable),
            _ => false,
        }
    }

    /// The same without `null`; none where nothing is left.
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

    /// Calls `visit` with this expression and all that it is made of.
    pub fn walk(&self, visit: &mut impl FnMut(&Self)) {
        visit(self);
        match self {
            Self::List(inner) | Self::Map(inner) => inner.walk(visit),
            Self::Either(alternatives) => alternatives.iter().for_each(|inner| inner.walk(visit)),
            _ => {}
        }
    }
}

/// A set of values, which are all integers or all strings.
#[derive(Clone, Debug, PartialEq)]
pub struct Set {
    /// The values, in order.
    pub values: SetValues,
    /// Whether there may be others.
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
    /// What it means.
    pub description: String,
}

/// A message: bodies with the same `type`, each for its direction.
#[derive(Clone, Debug, PartialEq)]
pub struct JsonMessage {
    /// Index of its package.
    pub package: usize,
    /// Its type.
    pub name: String,
    /// What the paragraphs under its heading say.
    pub docs: Docs,
    /// Its bodies, by direction, each at most once.
    pub parts: Vec<JsonPart>,
    /// The heading.
    pub span: Span,
}

/// The body of a message for a direction.
#[derive(Clone, Debug, PartialEq)]
pub struct JsonPart {
    /// The direction.
    pub direction: Direction,
    /// The name of the message and the direction, as files bear them: `UAV-INF.request`.
    pub name: String,
    /// What the paragraphs under its heading say.
    pub docs: Docs,
    /// The types of the messages that answer a request, in order.
    pub answers: Vec<String>,
    /// The body. Its first field is `type`, which holds the name of the message.
    pub body: Object,
    /// The subheading.
    pub span: Span,
}

/// The field that holds the type of a message.
pub const TYPE_FIELD: &str = "type";

impl JsonPart {
    /// The fields but for `type`.
    pub fn fields(&self) -> &[Member] {
        self.body.fields.split_first().map_or(&[], |(_, rest)| rest)
    }
}
