//! The language of computed values: its syntax tree, its typed form and its evaluation.

mod evaluate;
mod parser;
mod tree;
mod typing;

pub use self::evaluate::Computed;
pub(super) use self::parser::parse;
pub use self::tree::{Binary, Expression, Unary, ValueKind};
pub(super) use self::tree::{Name, Node, NodeKind, Side};
pub(super) use self::typing::{Names, typed};
