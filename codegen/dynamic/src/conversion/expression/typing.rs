//! Checks the types of expressions.

use uavspec_schema::span::Span;

use super::tree::{Binary, Expression, Name, Node, NodeKind, Unary, ValueKind};

/// Looks up the names in an expression.
pub(in crate::conversion) trait Names {
    /// The value that a name refers to, or the reason why there is none.
    fn value(&self, name: &Name) -> Result<Expression, String>;
}

/// An error with its location.
type Error = (Span, String);

/// Checks an expression. Integers are converted if floats are expected.
pub(in crate::conversion) fn typed(node: &Node, names: &dyn Names) -> Result<Expression, Error> {
    match &node.kind {
        NodeKind::Bool(value) => Ok(Expression::Bool(*value)),
        NodeKind::Int(value) => Ok(Expression::Int(*value)),
        NodeKind::Float(value) => Ok(Expression::Float(*value)),
        NodeKind::Name(name) => names.value(name).map_err(|message| (name.span, message)),
        NodeKind::Unary(operator, operand) => {
            let found = typed(operand, names)?;
            let is_valid = match operator {
                Unary::Not => found.kind() == ValueKind::Bool,
                Unary::Negate => found.kind() != ValueKind::Bool,
                Unary::Invert => found.kind() == ValueKind::Int,
            };
            if !is_valid {
                let message = format!("`{}` can't be applied to {}", operator.symbol(), found.kind().name());
                return Err((operand.span, message));
            }
            Ok(Expression::Unary(*operator, Box::new(found)))
        }
        NodeKind::Binary(operator, left, right) => {
            binary(*operator, (left, typed(left, names)?), (right, typed(right, names)?))
        }
        NodeKind::If(parts) => {
            let [condition, yes, no] = &**parts;
            let (found, first, second) = (typed(condition, names)?, typed(yes, names)?, typed(no, names)?);
            if found.kind() != ValueKind::Bool {
                let message =
                    format!("the condition is {}; compare it, for example with 0", found.kind().name());
                return Err((condition.span, message));
            }
            let (first, second) = unified(first, second).map_err(|message| (no.span, message))?;
            Ok(Expression::If(Box::new([found, first, second])))
        }
    }
}

fn binary(
    operator: Binary,
    (left_node, left): (&Node, Expression),
    (right_node, right): (&Node, Expression),
) -> Result<Expression, Error> {
    let invalid = |node: &Node, found: &Expression| {
        (node.span, format!("`{}` can't be applied to {}", operator.symbol(), found.kind().name()))
    };
    let is_valid = |found: &Expression| match operator {
        Binary::Or | Binary::And => found.kind() == ValueKind::Bool,
        Binary::Equal | Binary::NotEqual => true,
        Binary::BitOr | Binary::BitXor | Binary::BitAnd => found.kind() == ValueKind::Int,
        _ => found.kind() != ValueKind::Bool,
    };
    if !is_valid(&left) {
        return Err(invalid(left_node, &left));
    }
    if !is_valid(&right) {
        return Err(invalid(right_node, &right));
    }
    let (left, right) = if operator == Binary::Divide {
        (left.into_float(), right.into_float())
    } else {
        unified(left, right).map_err(|message| (right_node.span, message))?
    };
    Ok(Expression::Binary(operator, Box::new(left), Box::new(right)))
}

/// If only one of two expressions is an integer, converts it to a float. Fails for other expressions of different
/// kinds.
fn unified(left: Expression, right: Expression) -> Result<(Expression, Expression), String> {
    match (left.kind(), right.kind()) {
        (one, other) if one == other => Ok((left, right)),
        (ValueKind::Float, ValueKind::Int) => Ok((left, right.into_float())),
        (ValueKind::Int, ValueKind::Float) => Ok((left.into_float(), right)),
        (one, other) => Err(format!("expected {}, found {}", one.name(), other.name())),
    }
}

impl Expression {
    /// The kind of the value.
    pub fn kind(&self) -> ValueKind {
        match self {
            Self::Bool(_) | Self::Unary(Unary::Not, _) => ValueKind::Bool,
            Self::Int(_) => ValueKind::Int,
            Self::Float(_) | Self::AsFloat(_) => ValueKind::Float,
            Self::Field(_, kind) => *kind,
            Self::Unary(_, operand) => operand.kind(),
            Self::Binary(operator, left, _) => {
                if operator.is_comparison() {
                    ValueKind::Bool
                } else {
                    left.kind()
                }
            }
            Self::If(parts) => parts[1].kind(),
        }
    }

    /// Converts an integer to a float.
    pub(in crate::conversion) fn into_float(self) -> Self {
        match (&self, self.kind()) {
            #[allow(clippy::cast_precision_loss)] // the language documents the conversion
            (Self::Int(value), _) => Self::Float(*value as f64),
            (_, ValueKind::Int) => Self::AsFloat(Box::new(self)),
            _ => self,
        }
    }

    /// Calls `visit` with the index of each field that the expression reads.
    pub fn fields(&self, visit: &mut dyn FnMut(usize)) {
        match self {
            Self::Bool(_) | Self::Int(_) | Self::Float(_) => {}
            Self::Field(field, _) => visit(*field),
            Self::AsFloat(operand) | Self::Unary(_, operand) => operand.fields(visit),
            Self::Binary(_, left, right) => {
                left.fields(visit);
                right.fields(visit);
            }
            Self::If(parts) => parts.iter().for_each(|part| part.fields(visit)),
        }
    }
}

impl Unary {
    fn symbol(self) -> &'static str {
        match self {
            Self::Not => "not",
            Self::Negate => "-",
            Self::Invert => "~",
        }
    }
}

impl Binary {
    /// True if the result is a truth value.
    pub fn is_comparison(self) -> bool {
        !matches!(
            self,
            Self::BitOr
                | Self::BitXor
                | Self::BitAnd
                | Self::Add
                | Self::Subtract
                | Self::Multiply
                | Self::Divide
        )
    }

    fn symbol(self) -> &'static str {
        match self {
            Self::Or => "or",
            Self::And => "and",
            Self::Equal => "==",
            Self::NotEqual => "!=",
            Self::Less => "<",
            Self::LessOrEqual => "<=",
            Self::Greater => ">",
            Self::GreaterOrEqual => ">=",
            Self::BitOr => "|",
            Self::BitXor => "^",
            Self::BitAnd => "&",
            Self::Add => "+",
            Self::Subtract => "-",
            Self::Multiply => "*",
            Self::Divide => "/",
        }
    }
}
