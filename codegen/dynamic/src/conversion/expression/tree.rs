//! Expressions, and their syntax trees.

use uavspec_schema::span::Span;

/// A computed value, checked against the definitions of both messages.
#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    /// A truth value.
    Bool(bool),
    /// An integer.
    Int(i128),
    /// A float; may be NaN.
    Float(f64),
    /// The value of the field with this index in the source message.
    Field(usize, ValueKind),
    /// An integer as a float.
    AsFloat(Box<Expression>),
    /// An operator with one operand.
    Unary(Unary, Box<Expression>),
    /// An operator with two operands of the same kind.
    Binary(Binary, Box<Expression>, Box<Expression>),
    /// The second expression if the first is true, otherwise the third.
    If(Box<[Expression; 3]>),
}

/// The kind of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueKind {
    /// A truth value.
    Bool,
    /// An integer.
    Int,
    /// A float.
    Float,
}

/// An operator with one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    /// `not`
    Not,
    /// `-`
    Negate,
    /// `~`
    Invert,
}

/// An operator with two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binary {
    /// `or`
    Or,
    /// `and`
    And,
    /// `==`
    Equal,
    /// `!=`
    NotEqual,
    /// `<`
    Less,
    /// `<=`
    LessOrEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterOrEqual,
    /// `|`
    BitOr,
    /// `^`
    BitXor,
    /// `&`
    BitAnd,
    /// `+`; integers saturate.
    Add,
    /// `-`; integers saturate.
    Subtract,
    /// `*`; integers saturate.
    Multiply,
    /// `/`, for floats only.
    Divide,
}

impl ValueKind {
    /// The name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bool => "a boolean",
            Self::Int => "an integer",
            Self::Float => "a float",
        }
    }
}

/// A node of the syntax tree, with its location.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::conversion) struct Node {
    pub(in crate::conversion) kind: NodeKind,
    pub(in crate::conversion) span: Span,
}

/// The kinds of nodes.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::conversion) enum NodeKind {
    Bool(bool),
    Int(i128),
    Float(f64),
    Name(Name),
    Unary(Unary, Box<Node>),
    Binary(Binary, Box<Node>, Box<Node>),
    If(Box<[Node; 3]>),
}

/// The name of a field or a constant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::conversion) struct Name {
    /// The side that qualifies a constant's name.
    pub(in crate::conversion) side: Option<Side>,
    pub(in crate::conversion) text: String,
    pub(in crate::conversion) span: Span,
}

/// One of the two versions of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::conversion) enum Side {
    Old,
    New,
}

impl Node {
    /// Calls `visit` with each name in the expression.
    pub(in crate::conversion) fn names<'n>(&'n self, visit: &mut dyn FnMut(&'n Name)) {
        match &self.kind {
            NodeKind::Bool(_) | NodeKind::Int(_) | NodeKind::Float(_) => {}
            NodeKind::Name(name) => visit(name),
            NodeKind::Unary(_, operand) => operand.names(visit),
            NodeKind::Binary(_, left, right) => {
                left.names(visit);
                right.names(visit);
            }
            NodeKind::If(parts) => parts.iter().for_each(|part| part.names(visit)),
        }
    }
}
