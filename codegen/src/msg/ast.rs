//! The syntax tree of a `.msg`, `.srv` or `.action` file, as written.

use uavspec_runtime::Scalar;
pub use uavspec_runtime::descriptor::Shape;

use super::annotation::Note;
use crate::directive::Directive;
use crate::source::Span;
use crate::value::Value;

/// A file: one part for a message, two for a service, three for an action.
#[derive(Debug)]
pub struct Definition<'s> {
    /// Its parts, as many as its kind has.
    pub parts: Vec<Part<'s>>,
}

/// The lines between two `---`.
#[derive(Debug, Default)]
pub struct Part<'s> {
    /// Every line, blank ones too.
    pub lines: Vec<Line<'s>>,
}

/// A line: a field, a constant, a comment, any with a comment, or nothing. What it holds is boxed, so
/// that an empty line takes little.
#[derive(Debug)]
pub struct Line<'s> {
    /// The line without its end.
    pub span: Span,
    /// What it declares.
    pub item: Option<Box<Item<'s>>>,
    /// Its comment.
    pub comment: Option<Box<Comment<'s>>>,
    /// Whether something stood there that could not be read.
    pub is_broken: bool,
}

impl Line<'_> {
    /// Whether the line holds nothing.
    pub fn is_blank(&self) -> bool {
        self.item.is_none() && self.comment.is_none() && !self.is_broken
    }
}

/// A comment from its `#` to the end of the line.
#[derive(Debug)]
pub struct Comment<'s> {
    /// From the `#` on.
    pub span: Span,
    /// Column of the `#`, from 0, in bytes.
    pub column: usize,
    /// What follows the `#`, without a directive, white space at the end removed.
    pub text: &'s str,
    /// The directive at its end.
    pub directive: Option<Directive<'s>>,
    /// The text with its annotations read, where the line declares something.
    pub note: Option<Note<'s>>,
}

impl Comment<'_> {
    /// Whether it is a directive and nothing else: such a line stands for nothing in the documentation.
    pub fn is_directive(&self) -> bool {
        self.directive.is_some() && self.text.is_empty()
    }
}

/// A declaration.
#[derive(Debug)]
pub enum Item<'s> {
    /// `type name` or `type name default`.
    Field(Field<'s>),
    /// `type NAME=value`.
    Constant(Constant<'s>),
}

/// A name and its place.
#[derive(Clone, Copy, Debug)]
pub struct Name<'s> {
    /// The name.
    pub text: &'s str,
    /// Its place.
    pub span: Span,
}

/// A field.
#[derive(Debug)]
pub struct Field<'s> {
    /// Its type.
    pub ty: Type<'s>,
    /// Its name.
    pub name: Name<'s>,
    /// Its default (ROS 2).
    pub default: Option<Value>,
}

/// A constant.
#[derive(Debug)]
pub struct Constant<'s> {
    /// Its type.
    pub ty: ConstantType,
    /// Its name.
    pub name: Name<'s>,
    /// Its value, of that type and in its range.
    pub value: Value,
    /// Place of the value.
    pub value_span: Span,
}

/// Type of a constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstantType {
    /// A number, a `bool`, a `byte` or a `char`.
    Scalar(Scalar),
    /// A `string`, or a `wstring` where `wide`.
    String {
        /// Whether it is a `wstring`.
        wide: bool,
    },
}

/// Type of a field.
#[derive(Debug)]
pub struct Type<'s> {
    /// As written.
    pub span: Span,
    /// The element.
    pub element: Element<'s>,
    /// How many of them.
    pub shape: Shape,
}

/// Type of a field or of the elements of an array.
#[derive(Clone, Copy, Debug)]
pub enum Element<'s> {
    /// A built-in scalar.
    Scalar(Scalar),
    /// `string`, `wstring`, with a greatest length where stated.
    String {
        /// Whether it is a `wstring`.
        wide: bool,
        /// Greatest length in characters.
        bound: Option<u32>,
    },
    /// A message, of this package where no other is named.
    Message {
        /// The package that is named.
        package: Option<&'s str>,
        /// The message.
        name: &'s str,
    },
}
