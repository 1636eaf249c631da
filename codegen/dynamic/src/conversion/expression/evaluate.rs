//! Evaluates expressions.

use super::tree::{Binary, Expression, Unary};

/// The value of an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Computed {
    /// A truth value.
    Bool(bool),
    /// An integer.
    Int(i128),
    /// A float.
    Float(f64),
}

impl Computed {
    fn is_true(self) -> bool {
        self == Self::Bool(true)
    }

    #[allow(clippy::cast_precision_loss)] // the language documents the conversion
    fn as_float(self) -> f64 {
        match self {
            Self::Bool(value) => f64::from(u8::from(value)),
            Self::Int(value) => value as f64,
            Self::Float(value) => value,
        }
    }
}

impl Expression {
    /// The value of the expression. `field` returns the value of the source field with a given index.
    pub fn value(&self, field: &dyn Fn(usize) -> Computed) -> Computed {
        match self {
            Self::Bool(value) => Computed::Bool(*value),
            Self::Int(value) => Computed::Int(*value),
            Self::Float(value) => Computed::Float(*value),
            Self::Field(index, _) => field(*index),
            Self::AsFloat(operand) => Computed::Float(operand.value(field).as_float()),
            Self::Unary(operator, operand) => unary(*operator, operand.value(field)),
            Self::Binary(operator, left, right) => binary(*operator, left.value(field), right.value(field)),
            Self::If(parts) => {
                let [condition, yes, no] = &**parts;
                if condition.value(field).is_true() { yes.value(field) } else { no.value(field) }
            }
        }
    }
}

fn unary(operator: Unary, operand: Computed) -> Computed {
    match (operator, operand) {
        (Unary::Not, found) => Computed::Bool(!found.is_true()),
        (Unary::Negate, Computed::Int(value)) => Computed::Int(value.saturating_neg()),
        (Unary::Negate, found) => Computed::Float(-found.as_float()),
        (Unary::Invert, Computed::Int(value)) => Computed::Int(!value),
        // Only integers have bits; the type check rejects other operands.
        (Unary::Invert, found) => found,
    }
}

fn binary(operator: Binary, left: Computed, right: Computed) -> Computed {
    match (operator, left, right) {
        (Binary::Or, left, right) => Computed::Bool(left.is_true() || right.is_true()),
        (Binary::And, left, right) => Computed::Bool(left.is_true() && right.is_true()),
        (Binary::Equal, left, right) => Computed::Bool(left == right),
        (Binary::NotEqual, left, right) => Computed::Bool(left != right),
        (_, Computed::Int(left), Computed::Int(right)) => integers(operator, left, right),
        (_, left, right) => floats(operator, left.as_float(), right.as_float()),
    }
}

fn integers(operator: Binary, left: i128, right: i128) -> Computed {
    match operator {
        Binary::Less => Computed::Bool(left < right),
        Binary::LessOrEqual => Computed::Bool(left <= right),
        Binary::Greater => Computed::Bool(left > right),
        Binary::GreaterOrEqual => Computed::Bool(left >= right),
        Binary::BitOr => Computed::Int(left | right),
        Binary::BitXor => Computed::Int(left ^ right),
        Binary::BitAnd => Computed::Int(left & right),
        Binary::Add => Computed::Int(left.saturating_add(right)),
        Binary::Subtract => Computed::Int(left.saturating_sub(right)),
        _ => Computed::Int(left.saturating_mul(right)),
    }
}

fn floats(operator: Binary, left: f64, right: f64) -> Computed {
    match operator {
        Binary::Less => Computed::Bool(left < right),
        Binary::LessOrEqual => Computed::Bool(left <= right),
        Binary::Greater => Computed::Bool(left > right),
        Binary::GreaterOrEqual => Computed::Bool(left >= right),
        Binary::Add => Computed::Float(left + right),
        Binary::Subtract => Computed::Float(left - right),
        Binary::Divide => Computed::Float(left / right),
        _ => Computed::Float(left * right),
    }
}
