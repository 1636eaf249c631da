//! Initial content of a message: the defaults of its definition, and zeros elsewhere.

use serde::de::value::Error;
use uavspec_runtime::{Number, Scalar};
use uavspec_schema::value::Value;
use uavspec_schema::{Element, Shape};

use super::bytes::number_bytes;
use super::json::Builder;
use super::message::DynamicMessage;
use super::plan::{Field, Plan};
use super::types::MessageType;

/// Creates the initial message of a type.
pub(super) fn message(ty: MessageType<'_>) -> DynamicMessage<'_> {
    let mut builder = Builder::new(ty);
    fill(&mut builder, ty, ty.plan, 0);
    builder.finish()
}

fn fill<'t>(builder: &mut Builder<'t>, ty: MessageType<'t>, plan: &Plan, base: usize) {
    if !plan.has_defaults {
        return;
    }
    for field in &plan.fields {
        let at = base + field.offset;
        match (field.element, &field.default) {
            (Element::Message(nested), _) => {
                for index in 0..field.count() {
                    fill(builder, ty, ty.nested(nested).plan, at + index * field.stride);
                }
            }
            (_, Some(default)) => write_field(builder, field, at, default),
            (_, None) => {}
        }
    }
}

fn write_field(builder: &mut Builder<'_>, field: &Field, at: usize, default: &Value) {
    match (default, field.shape) {
        (Value::List(values), Shape::Array(length)) => {
            for (index, value) in values.iter().enumerate().take(length as usize) {
                write_element(builder, field.element, at + index * field.stride, value);
            }
        }
        (Value::List(values), _) => {
            let first = builder.opened();
            for value in values {
                let at = builder.open_element(field.stride);
                write_element(builder, field.element, at, value);
            }
            // Closing fails only above 4 GiB, and no definition is that large.
            let _ = builder.close::<Error>(at, first, values.len());
        }
        (value, _) => write_element(builder, field.element, at, value),
    }
}

fn write_element(builder: &mut Builder<'_>, element: Element, at: usize, value: &Value) {
    match (element, value) {
        (Element::Scalar(scalar), value) => builder.write(at, &number(scalar, value)[..scalar.size()]),
        (Element::String { .. }, Value::Text(text)) => {
            // See above.
            let _ = builder.string::<Error>(at, text);
        }
        _ => {}
    }
}

/// The bytes of a number, followed by zeros.
fn number(scalar: Scalar, value: &Value) -> [u8; 8] {
    let number = match value {
        Value::Bool(value) => Number::Int((*value).into()),
        value => value.number().unwrap_or(Number::Int(0)),
    };
    number_bytes(scalar, number)
}
