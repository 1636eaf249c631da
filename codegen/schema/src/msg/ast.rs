//! The syntax tree of a `.msg`, `.srv` or `.action` file, as written.

use uavspec_runtime::Scalar;
pub use uavspec_runtime::descriptor::Shape;

use super::annotation::Note;
use crate::directive::Directive;
use crate::model;
use crate::source::Span;
use crate::value::Value;

/// A file: one part for a message, two for a service, three for an action.
#[derive(Debug)]
pub struct Definition<'s> {
    /// The parts.
    pub parts: Vec<Part<'s>>,
}

/// The lines between two separators (`---`).
#[derive(Debug, Default)]
pub struct Part<'s> {
    /// Every line, including empty lines.
    pub lines: Vec<Line<'s>>,
}

/// A line: a declaration, a comment, both, or neither. The content is boxed to keep empty lines small.
#[derive(Debug)]
pub struct Line<'s> {
    /// The line without its line break.
    pub span: Span,
    /// The declaration.
    pub item: Option<Box<Item<'s>>>,
    /// The comment.
    pub comment: Option<Box<Comment<'s>>>,
    /// True if a part of the line could not be read.
    pub is_invalid: bool,
}

impl Line<'_> {
    pub(super) fn blank(span: Span) -> Self {
        Self { span, item: None, comment: None, is_invalid: false }
    }

    /// True if the line is empty.
    pub fn is_blank(&self) -> bool {
        self.item.is_none() && self.comment.is_none() && !self.is_invalid
    }
}

/// A comment from its `#` to the end of the line.
#[derive(Debug)]
pub struct Comment<'s> {
    /// The location, starting at the `#`.
    pub span: Span,
    /// The zero-based column of the `#`, in bytes.
    pub column: usize,
    /// The text after the `#`, without the directive and trailing white space.
    pub text: &'s str,
    /// The directive at the end.
    pub directive: Option<Directive<'s>>,
    /// The parsed annotations and text, if the line declares something.
    pub note: Option<Note<'s>>,
}

impl Comment<'_> {
    /// True if the comment contains only a directive, and is therefore not part of the documentation.
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

/// A name and its location.
#[derive(Clone, Copy, Debug)]
pub struct Name<'s> {
    /// The name.
    pub text: &'s str,
    /// The location.
    pub span: Span,
}

/// A field.
#[derive(Debug)]
pub struct Field<'s> {
    /// The type.
    pub ty: Type<'s>,
    /// The name.
    pub name: Name<'s>,
    /// The default (ROS 2).
    pub default: Option<Value>,
}

/// A constant.
#[derive(Debug)]
pub struct Constant<'s> {
    /// The type: a scalar or a string without a bound.
    pub ty: model::Element,
    /// The name.
    pub name: Name<'s>,
    /// The value, checked against the type's range.
    pub value: Value,
    /// The location of the value.
    pub value_span: Span,
}

/// The type of a field.
#[derive(Debug)]
pub struct Type<'s> {
    /// The location.
    pub span: Span,
    /// The element.
    pub element: Element<'s>,
    /// The number of elements.
    pub shape: Shape,
}

/// The type of a field, or of the elements of an array.
#[derive(Clone, Copy, Debug)]
pub enum Element<'s> {
    /// A built-in scalar.
    Scalar(Scalar),
    /// A `string` or `wstring`, optionally bounded.
    String {
        /// True for a `wstring`.
        wide: bool,
        /// The maximum length in characters.
        bound: Option<u32>,
    },
    /// A message.
    Message {
        /// The package, or `None` for the same package.
        package: Option<&'s str>,
        /// The message.
        name: &'s str,
    },
}
