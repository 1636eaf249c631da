//! Converts messages in their JSON form. This is the reference for conversions in memory.

use serde_json::{Map, Number, Value};
use uavspec_dynamic::Types;
use uavspec_dynamic::conversion::{
    Computed, Conversion, Copy, CountLimit, Elements, Narrowing, Neutral, Step,
};
use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Field, MessageId, Schema, Shape};

/// Converts a message in JSON form. `initial` is a message of the target type with its initial values.
pub(super) fn convert_json(
    schema: &Schema,
    conversion: &Conversion,
    message: &Value,
    initial: &Value,
) -> Value {
    let (source, target) = (schema.message(conversion.from), schema.message(conversion.to));
    let mut converted = Map::new();
    for (field, step) in target.fields.iter().zip(&conversion.steps) {
        let initial = initial.get(&field.name).cloned().unwrap_or_default();
        let value = match step {
            Step::Fill(neutral) => filled(field, *neutral, initial),
            Step::Compute(expression) => {
                let read = |at: usize| computed(&source.fields[at], message.get(&source.fields[at].name));
                let value = number(field, expression.value(&read));
                spread(field, &value)
            }
            Step::Copy(copy) => {
                let value = message.get(&source.fields[copy.source].name).unwrap_or(&Value::Null);
                Copier { schema, source: &source.fields[copy.source], target: field, copy }
                    .copied(value, &initial)
            }
        };
        converted.insert(field.name.clone(), value);
    }
    Value::Object(converted)
}

/// The value of a field that contains `value` in each element.
fn spread(field: &Field, value: &Value) -> Value {
    match field.ty.shape {
        Shape::Array(length) => Value::Array(vec![value.clone(); length as usize]),
        Shape::Single => value.clone(),
        Shape::Bounded(_) | Shape::Sequence => Value::Array(Vec::new()),
    }
}

fn filled(field: &Field, neutral: Neutral, initial: Value) -> Value {
    match neutral {
        Neutral::Default => initial,
        Neutral::Int(value) => spread(field, &number(field, Computed::Int(value))),
        Neutral::Float(value) => spread(field, &number(field, Computed::Float(value))),
    }
}

/// The value of a source field in an expression.
fn computed(field: &Field, value: Option<&Value>) -> Computed {
    let Element::Scalar(scalar) = field.ty.element else { return Computed::Bool(false) };
    let value = value.unwrap_or(&Value::Null);
    match scalar {
        Scalar::Bool => Computed::Bool(value.as_bool().unwrap_or_default()),
        scalar if scalar.is_float() => Computed::Float(value.as_f64().unwrap_or(f64::NAN)),
        _ => Computed::Int(integer(value)),
    }
}

fn integer(value: &Value) -> i128 {
    value.as_i64().map(i128::from).or_else(|| value.as_u64().map(i128::from)).unwrap_or_default()
}

/// The number, limited to the range of the field's type.
fn number(field: &Field, value: Computed) -> Value {
    let Element::Scalar(scalar) = field.ty.element else { return Value::Null };
    match value {
        Computed::Bool(value) => Value::Bool(value),
        Computed::Int(value) if scalar == Scalar::Bool => Value::Bool(value != 0),
        Computed::Int(value) if scalar.is_float() => {
            #[allow(clippy::cast_precision_loss)] // the hint or the type allows it
            let value = value as f64;
            float(scalar, value)
        }
        Computed::Int(value) => {
            let (low, high) = scalar.integer_bounds().unwrap_or((0, 0));
            Number::from_i128(value.clamp(low, high)).map_or(Value::Null, Value::Number)
        }
        Computed::Float(value) => float(scalar, value),
    }
}

fn float(scalar: Scalar, value: f64) -> Value {
    #[allow(clippy::cast_possible_truncation)] // the value of a float32
    let value = if scalar == Scalar::Float32 { f64::from(value as f32) } else { value };
    Number::from_f64(value).map_or(Value::Null, Value::Number)
}

struct Copier<'c> {
    schema: &'c Schema,
    source: &'c Field,
    target: &'c Field,
    copy: &'c Copy,
}

impl Copier<'_> {
    fn copied(&self, value: &Value, initial: &Value) -> Value {
        if let (Elements::Text, Value::String(text)) = (&self.copy.elements, value) {
            return Value::String(cut_bytes(text, self.length(usize::MAX)).to_owned());
        }
        let Value::Array(values) = value else {
            return self.element(value, initial);
        };
        let length = match self.target.ty.shape {
            Shape::Bounded(bound) => values.len().min(bound as usize),
            _ => self.length(values.len()),
        };
        let elements = (0..length).map(|at| {
            let initial = initial.get(at).cloned().unwrap_or_default();
            match values.get(at) {
                Some(value) => self.element(value, &initial),
                None => self.rest(initial),
            }
        });
        Value::Array(elements.collect())
    }

    /// The number of elements if the target is an array, or `otherwise` for any other target.
    fn length(&self, otherwise: usize) -> usize {
        match self.target.ty.written().shape {
            Shape::Array(length) => length as usize,
            Shape::Single | Shape::Bounded(_) | Shape::Sequence => otherwise,
        }
    }

    fn rest(&self, initial: Value) -> Value {
        match self.copy.rest {
            Neutral::Default => initial,
            Neutral::Int(value) => number(self.target, Computed::Int(value)),
            Neutral::Float(value) => number(self.target, Computed::Float(value)),
        }
    }

    /// The number of elements, limited to the length of an array that was cut.
    fn limited(&self, value: i128) -> i128 {
        self.copy.limit.as_ref().map_or(value, |limit| limited(limit, value))
    }

    fn element(&self, value: &Value, initial: &Value) -> Value {
        match &self.copy.elements {
            Elements::Message(nested) => {
                let initial =
                    if initial.is_null() { initial_of(self.schema, nested.to) } else { initial.clone() };
                convert_json(self.schema, nested, value, &initial)
            }
            Elements::String(Some(bound)) => {
                let text = value.as_str().unwrap_or_default();
                Value::String(text.chars().take(*bound as usize).collect())
            }
            Elements::Values(pairs) => {
                let value = integer(value);
                let named = || pairs.iter().find(|(from, _)| *from == value).map_or(value, |(_, to)| *to);
                // A limit of a count also converts the named values.
                let converted = self.copy.limit.as_ref().map_or_else(named, |limit| limited(limit, value));
                number(self.target, Computed::Int(converted))
            }
            Elements::Flags(pairs) => number(self.target, Computed::Int(flags(pairs, integer(value)))),
            Elements::Narrow(Narrowing::Neutral) => {
                let value = integer(value);
                let is_valid = matches!(self.target.ty.element, Element::Scalar(scalar)
                    if scalar.integer_bounds().is_some_and(|(low, high)| (low..=high).contains(&value)));
                let converted = || number(self.target, Computed::Int(self.limited(value)));
                if is_valid { converted() } else { self.rest(Value::from(0)) }
            }
            Elements::Narrow(Narrowing::Nearest) | Elements::Widen => {
                match computed(self.source, Some(value)) {
                    Computed::Int(value) => number(self.target, Computed::Int(self.limited(value))),
                    value => number(self.target, value),
                }
            }
            Elements::Same | Elements::Text | Elements::String(None) => match &self.copy.limit {
                Some(limit) => number(self.target, Computed::Int(limited(limit, integer(value)))),
                None => value.clone(),
            },
        }
    }
}

/// The initial value of a nested message in a sequence.
fn initial_of(schema: &Schema, id: MessageId) -> Value {
    let types = Types::new(schema);
    types.get(id).default().to_json().unwrap_or_default()
}

/// Limits a count, unless it has a special meaning.
fn limited(limit: &CountLimit, value: i128) -> i128 {
    limit.special.get(&value).copied().unwrap_or(value.min(limit.max.into()))
}

/// Moves flags to their target masks. Other bits stay the same.
fn flags(pairs: &[(i128, i128)], value: i128) -> i128 {
    let moved = pairs.iter().fold(0, |all, (from, _)| all | from);
    let set = pairs.iter().filter(|(from, _)| value & from == *from && *from != 0);
    set.fold(value & !moved, |all, (_, to)| all | to)
}

/// The start of a text, at most `length` bytes long and without an incomplete character.
fn cut_bytes(text: &str, length: usize) -> &str {
    let mut end = text.len().min(length);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    &text[..end]
}
