//! The columns of messages: a column for each field.

use std::collections::HashMap;
use std::sync::Arc;

use arrow_array::builder::{BooleanBuilder, PrimitiveBuilder, StringBuilder};
use arrow_array::types::{
    ArrowPrimitiveType, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type,
    UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array as _, ArrayRef, FixedSizeListArray, ListArray, StructArray};
use arrow_schema::{ArrowError, DataType, Field, FieldRef, Fields};
use uavspec_codegen::dynamic::{MessageType, Placed, PlacedElement, Value};
use uavspec_codegen::schema::{Element, Field as Defined, Message, Schema, Shape};
use uavspec_runtime::Scalar;

/// The name of the elements of an array.
const ITEM: &str = "item";

/// The values of a field.
pub(super) enum Column {
    Plain(Box<dyn Plain>),
    Message {
        fields: Fields,
        columns: Vec<Column>,
        rows: usize,
    },
    /// An array or a sequence.
    List {
        item: FieldRef,
        shape: Shape,
        lengths: Vec<usize>,
        elements: Box<Column>,
    },
}

/// Numbers, flags or texts.
pub(super) trait Plain {
    fn push(&mut self, value: Option<Value<'_>>);

    fn finish(&mut self) -> ArrayRef;
}

struct Numbers<T: ArrowPrimitiveType> {
    builder: PrimitiveBuilder<T>,
    read: fn(Value<'_>) -> Option<T::Native>,
}

impl<T: ArrowPrimitiveType> Plain for Numbers<T> {
    fn push(&mut self, value: Option<Value<'_>>) {
        self.builder.append_option(value.and_then(self.read));
    }

    fn finish(&mut self) -> ArrayRef {
        Arc::new(self.builder.finish())
    }
}

impl Plain for BooleanBuilder {
    fn push(&mut self, value: Option<Value<'_>>) {
        self.append_option(value.and_then(|value| match value {
            Value::Bool(flag) => Some(flag),
            _ => None,
        }));
    }

    fn finish(&mut self) -> ArrayRef {
        Arc::new(Self::finish(self))
    }
}

impl Plain for StringBuilder {
    fn push(&mut self, value: Option<Value<'_>>) {
        match value {
            Some(Value::String(text)) => self.append_value(text),
            Some(Value::Text(bytes)) => self.append_value(String::from_utf8_lossy(bytes)),
            _ => self.append_null(),
        }
    }

    fn finish(&mut self) -> ArrayRef {
        Arc::new(Self::finish(self))
    }
}

/// The fields and columns of a message type.
pub(super) fn of(
    message: MessageType<'_>,
    definition: Option<&Message>,
    schema: &Schema,
) -> (Vec<Field>, Vec<Column>) {
    let columns = message.layout().map(|placed| {
        let known =
            definition.and_then(|message| message.fields.iter().find(|field| field.name == placed.name));
        let (data_type, column) = column(placed, known, schema);
        let field = Field::new(placed.name, data_type, true);
        let field = match known {
            Some(known) => defined(field, known, schema),
            None => field,
        };
        (field, column)
    });
    columns.unzip()
}

/// Adds a unit, a description, and the values of an enum in JSON to a field.
pub(super) fn described(field: Field, unit: Option<&str>, description: &str, values: Option<&str>) -> Field {
    let texts = [("unit", unit), ("description", Some(description)), ("values", values)].into_iter();
    let known = texts
        .filter_map(|(key, text)| Some((key.to_owned(), text.filter(|text| !text.is_empty())?.to_owned())));
    field.with_metadata(known.collect::<HashMap<String, String>>())
}

/// Adds the facts of the definition to a field.
fn defined(field: Field, known: &Defined, schema: &Schema) -> Field {
    let values = known.enumeration.map(|reference| {
        let members = schema.enumeration(reference).members.iter();
        let values: serde_json::Map<String, serde_json::Value> = members
            .filter_map(|member| Some((member.name.clone(), i64::try_from(member.value).ok()?.into())))
            .collect();
        serde_json::Value::Object(values).to_string()
    });
    described(field, known.unit.as_deref(), &known.description, values.as_deref())
}

fn column(placed: Placed<'_>, known: Option<&Defined>, schema: &Schema) -> (DataType, Column) {
    let (data_type, column) = match placed.element {
        PlacedElement::Scalar(scalar) => plain(scalar),
        PlacedElement::Text(_) | PlacedElement::String => {
            (DataType::Utf8, Column::Plain(Box::new(StringBuilder::new())))
        }
        PlacedElement::Message(message) => {
            let inner = known.and_then(|known| match known.ty.element {
                Element::Message(id) => Some(schema.message(id)),
                _ => None,
            });
            let (fields, columns) = of(message, inner, schema);
            let fields = Fields::from(fields);
            (DataType::Struct(fields.clone()), Column::Message { fields, columns, rows: 0 })
        }
    };
    if placed.shape == Shape::Single {
        return (data_type, column);
    }
    let item: FieldRef = Arc::new(Field::new(ITEM, data_type, true));
    let data_type = match size(placed.shape) {
        Some(size) => DataType::FixedSizeList(Arc::clone(&item), size),
        None => DataType::List(Arc::clone(&item)),
    };
    let elements = Box::new(column);
    (data_type, Column::List { item, shape: placed.shape, lengths: Vec::new(), elements })
}

/// The number of elements, if it is fixed.
fn size(shape: Shape) -> Option<i32> {
    match shape {
        Shape::Array(length) => i32::try_from(length).ok(),
        _ => None,
    }
}

fn plain(scalar: Scalar) -> (DataType, Column) {
    match scalar {
        Scalar::Bool => (DataType::Boolean, Column::Plain(Box::new(BooleanBuilder::new()))),
        Scalar::Byte | Scalar::Char | Scalar::UInt8 => numbers::<UInt8Type>(unsigned),
        Scalar::UInt16 => numbers::<UInt16Type>(unsigned),
        Scalar::UInt32 => numbers::<UInt32Type>(unsigned),
        Scalar::UInt64 => numbers::<UInt64Type>(unsigned),
        Scalar::Int8 => numbers::<Int8Type>(signed),
        Scalar::Int16 => numbers::<Int16Type>(signed),
        Scalar::Int32 => numbers::<Int32Type>(signed),
        Scalar::Int64 => numbers::<Int64Type>(signed),
        Scalar::Float32 => numbers::<Float32Type>(|value| match value {
            Value::Float32(number) => Some(number),
            _ => None,
        }),
        Scalar::Float64 => numbers::<Float64Type>(|value| match value {
            Value::Float64(number) => Some(number),
            _ => None,
        }),
    }
}

fn numbers<T: ArrowPrimitiveType>(read: fn(Value<'_>) -> Option<T::Native>) -> (DataType, Column) {
    (T::DATA_TYPE, Column::Plain(Box::new(Numbers::<T> { builder: PrimitiveBuilder::new(), read })))
}

fn unsigned<N: TryFrom<u64>>(value: Value<'_>) -> Option<N> {
    match value {
        Value::UInt(number) => number.try_into().ok(),
        _ => None,
    }
}

fn signed<N: TryFrom<i64>>(value: Value<'_>) -> Option<N> {
    match value {
        Value::Int(number) => number.try_into().ok(),
        _ => None,
    }
}

impl Column {
    /// Adds a value. `None` adds a missing one.
    pub(super) fn push(&mut self, value: Option<Value<'_>>) {
        match self {
            Self::Plain(plain) => plain.push(value),
            Self::Message { columns, rows, .. } => {
                *rows += 1;
                let view = value.and_then(|value| match value {
                    Value::Message(view) => Some(view),
                    _ => None,
                });
                for (index, column) in columns.iter_mut().enumerate() {
                    column.push(view.and_then(|view| view.field(index)));
                }
            }
            Self::List { shape, lengths, elements, .. } => {
                let values = value.and_then(|value| match value {
                    Value::Array(values) => Some(values),
                    _ => None,
                });
                let found = values.map_or(0, uavspec_codegen::dynamic::Elements::len);
                let length = size(*shape).and_then(|size| usize::try_from(size).ok()).unwrap_or(found);
                lengths.push(length);
                (0..length).for_each(|index| elements.push(values.and_then(|values| values.get(index))));
            }
        }
    }

    /// The values, which are then dropped.
    pub(super) fn finish(&mut self) -> Result<ArrayRef, ArrowError> {
        match self {
            Self::Plain(plain) => Ok(plain.finish()),
            Self::Message { fields, columns, rows } => {
                let arrays: Result<Vec<ArrayRef>, ArrowError> =
                    columns.iter_mut().map(Self::finish).collect();
                let rows = std::mem::take(rows);
                Ok(Arc::new(StructArray::try_new_with_length(fields.clone(), arrays?, None, rows)?))
            }
            Self::List { item, shape, lengths, elements } => {
                let (item, lengths) = (Arc::clone(item), std::mem::take(lengths));
                let values = elements.finish()?;
                if let Some(size) = size(*shape) {
                    let array =
                        FixedSizeListArray::try_new_with_length(item, size, values, None, lengths.len())?;
                    return Ok(Arc::new(array));
                }
                if i32::try_from(values.len()).is_err() {
                    return Err(ArrowError::ComputeError("the arrays have too many elements".to_owned()));
                }
                let offsets = arrow_buffer::OffsetBuffer::from_lengths(lengths);
                Ok(Arc::new(ListArray::try_new(item, offsets, values, None)?))
            }
        }
    }
}
