//! Computed values as Rust expressions. Integers are `i128`, floats `f64`.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::quote;
use uavspec_dynamic::conversion::{Binary, Expression, Unary, ValueKind};
use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Field};

use crate::rust::types;

/// The fields of the source message with their Rust names.
pub(super) struct Source<'s> {
    pub(super) fields: &'s [Field],
    pub(super) names: &'s [Ident],
}

impl Source<'_> {
    /// An expression without enclosing parentheses.
    pub(super) fn value(&self, expression: &Expression) -> TokenStream {
        match expression {
            Expression::Bool(value) => quote!(#value),
            Expression::Int(value) if i32::try_from(*value).is_ok() => types::integer(*value),
            Expression::Int(value) => {
                // Add a suffix, because the compiler assumes i32 if all operands are literals.
                let magnitude = Literal::i128_suffixed(value.saturating_abs());
                if value.is_negative() { quote!(-#magnitude) } else { quote!(#magnitude) }
            }
            Expression::Float(value) => types::float64(*value),
            Expression::Field(index, kind) => self.field(*index, *kind),
            Expression::AsFloat(operand) => {
                let operand = self.operand(operand);
                quote!(#operand as f64)
            }
            Expression::Unary(operator, operand) => self.unary(*operator, operand),
            Expression::Binary(operator, left, right) => self.binary(*operator, left, right),
            Expression::If(parts) => {
                let [condition, yes, no] = &**parts;
                let (condition, yes, no) = (self.value(condition), self.value(yes), self.value(no));
                quote!(if #condition { #yes } else { #no })
            }
        }
    }

    fn field(&self, index: usize, kind: ValueKind) -> TokenStream {
        let name = &self.names[index];
        let number = self.fields[index].enumeration.map(|_| quote!(.0));
        let is_double = self.fields[index].ty.element == Element::Scalar(Scalar::Float64);
        match kind {
            ValueKind::Int => quote!(i128::from(from.#name #number)),
            ValueKind::Float if !is_double => quote!(f64::from(from.#name)),
            ValueKind::Bool | ValueKind::Float => quote!(from.#name),
        }
    }

    /// An expression that can be the operand of any operator.
    pub(super) fn operand(&self, expression: &Expression) -> TokenStream {
        let value = self.value(expression);
        let is_atomic = match expression {
            Expression::Bool(_) | Expression::Field(..) => true,
            Expression::Int(value) => *value >= 0,
            Expression::Float(value) => !value.is_sign_negative(),
            Expression::Unary(Unary::Negate, operand) => operand.kind() == ValueKind::Int,
            Expression::Binary(Binary::Add | Binary::Subtract | Binary::Multiply, left, _) => {
                left.kind() == ValueKind::Int
            }
            _ => false,
        };
        if is_atomic { value } else { quote!((#value)) }
    }

    fn unary(&self, operator: Unary, operand: &Expression) -> TokenStream {
        if operator == Unary::Negate && operand.kind() == ValueKind::Int {
            let value = self.value(operand);
            return quote!(0_i128.saturating_sub(#value));
        }
        let value = self.operand(operand);
        match operator {
            Unary::Negate => quote!(-#value),
            Unary::Not | Unary::Invert => quote!(!#value),
        }
    }

    fn binary(&self, operator: Binary, left: &Expression, right: &Expression) -> TokenStream {
        let function = match operator {
            Binary::Add => Some(quote!(saturating_add)),
            Binary::Subtract => Some(quote!(saturating_sub)),
            Binary::Multiply => Some(quote!(saturating_mul)),
            _ => None,
        };
        if let Some(function) = function.filter(|_| left.kind() == ValueKind::Int) {
            let (one, other) = (self.value(left), self.value(right));
            return quote!(i128::#function(#one, #other));
        }
        let (one, other) = (self.operand(left), self.operand(right));
        let symbol = match operator {
            Binary::Or => quote!(||),
            Binary::And => quote!(&&),
            Binary::Equal => quote!(==),
            Binary::NotEqual => quote!(!=),
            Binary::Less => quote!(<),
            Binary::LessOrEqual => quote!(<=),
            Binary::Greater => quote!(>),
            Binary::GreaterOrEqual => quote!(>=),
            Binary::BitOr => quote!(|),
            Binary::BitXor => quote!(^),
            Binary::BitAnd => quote!(&),
            Binary::Add => quote!(+),
            Binary::Subtract => quote!(-),
            Binary::Multiply => quote!(*),
            Binary::Divide => quote!(/),
        };
        quote!(#one #symbol #other)
    }
}
