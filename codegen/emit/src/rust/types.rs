//! Rust types and literals for the types and values of definitions.

use proc_macro2::{Literal, TokenStream};
use quote::quote;
use uavspec_runtime::Scalar;
use uavspec_schema::value::Value;
use uavspec_schema::{Dialect, Element, EnumRef, Field, Form, MessageId, Shape};

use super::context::Context;

/// The primitive type of a scalar.
pub(super) fn primitive(scalar: Scalar) -> TokenStream {
    match scalar {
        Scalar::Bool => quote!(bool),
        Scalar::Byte | Scalar::Char | Scalar::UInt8 => quote!(u8),
        Scalar::Int8 => quote!(i8),
        Scalar::Int16 => quote!(i16),
        Scalar::UInt16 => quote!(u16),
        Scalar::Int32 => quote!(i32),
        Scalar::UInt32 => quote!(u32),
        Scalar::Int64 => quote!(i64),
        Scalar::UInt64 => quote!(u64),
        Scalar::Float32 => quote!(f32),
        Scalar::Float64 => quote!(f64),
    }
}

/// The dialect of the package that defines a message.
pub(super) fn dialect(context: &Context<'_>, id: MessageId) -> Dialect {
    match context.schema.package_of(context.schema.message(id)).form {
        Form::Msg(dialect) => dialect,
        Form::Table | Form::Events => Dialect::Ros2,
    }
}

/// The type of a field.
pub(super) fn field(context: &Context<'_>, id: MessageId, field: &Field) -> TokenStream {
    let element = element(context, id, field);
    match field.ty.shape {
        Shape::Single => element,
        Shape::Array(length) => {
            let length = Literal::u32_unsuffixed(length);
            quote!([#element; #length])
        }
        Shape::Bounded(_) | Shape::Sequence => quote!(::uavspec_runtime::alloc::vec::Vec<#element>),
    }
}

/// The type of a field in the view of a fixed-size message. The type may use `'b`, the lifetime of the bytes.
pub(super) fn view(context: &Context<'_>, id: MessageId, viewed: &Field) -> TokenStream {
    let element = match viewed.ty.element {
        Element::Message(nested) => {
            let view = context.view_path(id, nested);
            quote!(#view<'b>)
        }
        _ => element(context, id, viewed),
    };
    match viewed.ty.shape {
        Shape::Array(length) => {
            let length = Literal::u32_unsuffixed(length);
            quote!(::uavspec_runtime::view::Elements<'b, #element, #length>)
        }
        Shape::Single => element,
        _ => field(context, id, viewed),
    }
}

fn element(context: &Context<'_>, id: MessageId, field: &Field) -> TokenStream {
    match (field.ty.element, field.enumeration) {
        (Element::Text(length), _) => {
            let length = Literal::u32_unsuffixed(length);
            quote!(::uavspec_runtime::Text<#length>)
        }
        (_, Some(reference)) => enumeration(context, id, reference),
        (Element::Scalar(scalar), None) => primitive(scalar),
        (Element::String { .. }, None) => quote!(::uavspec_runtime::alloc::string::String),
        (Element::Message(nested), None) => context.path(id, nested),
    }
}

/// The path of an enum type, relative to the module of the message `id`.
pub(super) fn enumeration(context: &Context<'_>, id: MessageId, reference: EnumRef) -> TokenStream {
    let name = &context.enum_names[reference.message.0 as usize][reference.index];
    context.enum_path(id, reference.message, name)
}

/// True if `Default` can be derived for a field. Arrays implement `Default` only up to 32 elements.
pub(super) fn derives_default(field: &Field) -> bool {
    field.default.is_none()
        && match field.ty.shape {
            Shape::Array(length) => length <= 32,
            Shape::Single | Shape::Bounded(_) | Shape::Sequence => true,
        }
}

/// The default of a field.
pub(super) fn default(context: &Context<'_>, id: MessageId, field: &Field) -> TokenStream {
    if let Some(default) = &field.default {
        return default_value(context, id, field, default);
    }
    if derives_default(field) {
        return quote!(::core::default::Default::default());
    }
    quote!(::core::array::from_fn(|_| ::core::default::Default::default()))
}

fn default_value(context: &Context<'_>, id: MessageId, field: &Field, value: &Value) -> TokenStream {
    let element_value = |value: &Value| {
        let plain = literal(field.ty.element, value);
        let plain = if matches!(value, Value::Text(_)) {
            quote!(::uavspec_runtime::alloc::string::String::from(#plain))
        } else {
            plain
        };
        match field.enumeration {
            Some(reference) => {
                let path = enumeration(context, id, reference);
                quote!(#path(#plain))
            }
            None => plain,
        }
    };
    match value {
        Value::List(values) => {
            let values = values.iter().map(element_value);
            if matches!(field.ty.shape, Shape::Array(_)) {
                quote!([#(#values),*])
            } else {
                quote!(::uavspec_runtime::alloc::vec![#(#values),*])
            }
        }
        value => element_value(value),
    }
}

/// The type of a constant.
pub(super) fn constant(ty: Element) -> TokenStream {
    match ty {
        Element::Scalar(scalar) => primitive(scalar),
        Element::Text(_) | Element::String { .. } | Element::Message(_) => quote!(&'static str),
    }
}

/// A value as a literal of the type `element`.
pub(super) fn literal(element: Element, value: &Value) -> TokenStream {
    match (value, element) {
        (Value::Bool(value), _) => quote!(#value),
        (Value::Int(value), Element::Scalar(Scalar::Bool)) => {
            let value = *value != 0;
            quote!(#value)
        }
        (Value::Int(value), _) => integer(*value),
        #[allow(clippy::cast_possible_truncation)]
        // the constant is a float32, which is infinite beyond its range
        (Value::Float(value), Element::Scalar(Scalar::Float32)) => {
            float(f64::from(*value as f32), &quote!(f32), |value| Literal::f32_unsuffixed(value as f32))
        }
        (Value::Float(value), _) => float(*value, &quote!(f64), Literal::f64_unsuffixed),
        (Value::Text(value), _) => quote!(#value),
        (Value::List(values), element) => {
            let values = values.iter().map(|value| literal(element, value));
            quote!([#(#values),*])
        }
    }
}

/// An `Option` expression.
pub(super) fn option(value: Option<TokenStream>) -> TokenStream {
    value.map_or_else(
        || quote!(::core::option::Option::None),
        |value| quote!(::core::option::Option::Some(#value)),
    )
}

/// An integer literal without a suffix.
pub(super) fn integer(value: i128) -> TokenStream {
    let magnitude = Literal::u128_unsuffixed(value.unsigned_abs());
    if value < 0 { quote!(-#magnitude) } else { quote!(#magnitude) }
}

/// A `float64` as a literal.
pub(super) fn float64(value: f64) -> TokenStream {
    float(value, &quote!(f64), Literal::f64_unsuffixed)
}

fn float(value: f64, ty: &TokenStream, literal: fn(f64) -> Literal) -> TokenStream {
    if value.is_nan() {
        quote!(#ty::NAN)
    } else if value == f64::INFINITY {
        quote!(#ty::INFINITY)
    } else if value == f64::NEG_INFINITY {
        quote!(#ty::NEG_INFINITY)
    } else {
        let magnitude = literal(value.abs());
        if value.is_sign_negative() { quote!(-#magnitude) } else { quote!(#magnitude) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn float32_values_beyond_the_range_are_infinite() {
        for (value, expected) in [(1e39, "f32 :: INFINITY"), (-1e39, "f32 :: NEG_INFINITY"), (-0.5, "- 0.5")]
        {
            let tokens = literal(Element::Scalar(Scalar::Float32), &Value::Float(value));
            assert_eq!(tokens.to_string(), expected);
        }
    }
}
