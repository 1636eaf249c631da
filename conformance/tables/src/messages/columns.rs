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
use serde_json::Number;
use uavspec_dynamic::{Field as Placed, MessageType, Value};
use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Field as Defined, Message, Schema, Shape};

/// The Arrow name of the elements of an array.
const ITEM: &str = "item";

/// The unit that definitions state for dimensionless values.
const NO_UNIT: &str = "-";

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
    /// Adds a value. Returns its approximate size in bytes.
    fn push(&mut self, value: Option<Value<'_>>) -> usize;

    fn finish(&mut self) -> ArrayRef;
}

struct Numbers<T: ArrowPrimitiveType> {
    builder: PrimitiveBuilder<T>,
    read: fn(Value<'_>) -> Option<T::Native>,
}

impl<T: ArrowPrimitiveType> Plain for Numbers<T> {
    fn push(&mut self, value: Option<Value<'_>>) -> usize {
        self.builder.append_option(value.and_then(self.read));
        size_of::<T::Native>()
    }

    fn finish(&mut self) -> ArrayRef {
        Arc::new(self.builder.finish())
    }
}

impl Plain for BooleanBuilder {
    fn push(&mut self, value: Option<Value<'_>>) -> usize {
        self.append_option(value.and_then(|value| match value {
            Value::Bool(flag) => Some(flag),
            _ => None,
        }));
        1
    }

    fn finish(&mut self) -> ArrayRef {
        Arc::new(Self::finish(self))
    }
}

impl Plain for StringBuilder {
    fn push(&mut self, value: Option<Value<'_>>) -> usize {
        let before = self.values_slice().len();
        match value {
            Some(Value::Text(bytes) | Value::String(bytes)) => {
                self.append_value(String::from_utf8_lossy(bytes));
            }
            _ => self.append_null(),
        }
        self.values_slice().len() - before + size_of::<i32>()
    }

    fn finish(&mut self) -> ArrayRef {
        Arc::new(Self::finish(self))
    }
}

/// The Arrow fields for a message type, with the unit, description and enum values from the definition.
pub(super) fn fields(message: MessageType<'_>, definition: Option<&Message>, schema: &Schema) -> Vec<Field> {
    let field = |placed: &Placed| {
        let known = field_of(definition, &placed.name);
        let field = Field::new(&*placed.name, data_type(message, placed, known, schema), true);
        match known {
            Some(known) => defined(field, known, schema),
            None => field,
        }
    };
    message.fields().iter().map(field).collect()
}

/// The empty columns for the fields of a message type.
pub(super) fn columns(
    message: MessageType<'_>,
    definition: Option<&Message>,
    schema: &Schema,
) -> Vec<Column> {
    let column = |placed: &Placed| column(message, placed, field_of(definition, &placed.name), schema);
    message.fields().iter().map(column).collect()
}

/// The field of a definition with this name.
fn field_of<'d>(definition: Option<&'d Message>, name: &str) -> Option<&'d Defined> {
    definition?.fields.iter().find(|field| field.name == name)
}

/// The definition of the message that a field contains.
fn nested<'s>(known: Option<&Defined>, schema: &'s Schema) -> Option<&'s Message> {
    match known?.ty.element {
        Element::Message(id) => Some(schema.message(id)),
        _ => None,
    }
}

/// Adds metadata to a field: a unit, a description, and the values of an enum as JSON.
pub(super) fn described(field: Field, unit: Option<&str>, description: &str, values: Option<&str>) -> Field {
    let texts = [("unit", unit), ("description", Some(description)), ("values", values)].into_iter();
    let known = texts
        .filter_map(|(key, text)| Some((key.to_owned(), text.filter(|text| !text.is_empty())?.to_owned())));
    field.with_metadata(known.collect::<HashMap<String, String>>())
}

/// Adds the unit, description and enum values from the definition to a field.
fn defined(field: Field, known: &Defined, schema: &Schema) -> Field {
    let values = known.enumeration.map(|reference| {
        let members = schema.enumeration(reference).members.iter();
        let values: serde_json::Map<String, serde_json::Value> = members
            .filter_map(|member| Some((member.name.clone(), Number::from_i128(member.value)?.into())))
            .collect();
        serde_json::Value::Object(values).to_string()
    });
    let unit = known.unit.as_deref().filter(|unit| *unit != NO_UNIT);
    described(field, unit, &known.description, values.as_deref())
}

fn data_type(
    message: MessageType<'_>,
    placed: &Placed,
    known: Option<&Defined>,
    schema: &Schema,
) -> DataType {
    match (placed.shape, size(placed.shape)) {
        (Shape::Single, _) => element_type(message, placed, known, schema),
        (_, Some(size)) => DataType::FixedSizeList(item(message, placed, known, schema), size),
        (_, None) => DataType::List(item(message, placed, known, schema)),
    }
}

/// The Arrow field for the elements of an array.
fn item(message: MessageType<'_>, placed: &Placed, known: Option<&Defined>, schema: &Schema) -> FieldRef {
    Arc::new(Field::new(ITEM, element_type(message, placed, known, schema), true))
}

/// The type of a field, or of its elements.
fn element_type(
    message: MessageType<'_>,
    placed: &Placed,
    known: Option<&Defined>,
    schema: &Schema,
) -> DataType {
    match placed.element {
        Element::Scalar(scalar) => scalar_type(scalar),
        Element::Text(_) | Element::String { .. } => DataType::Utf8,
        Element::Message(id) => {
            DataType::Struct(fields(message.nested(id), nested(known, schema), schema).into())
        }
    }
}

fn column(message: MessageType<'_>, placed: &Placed, known: Option<&Defined>, schema: &Schema) -> Column {
    let column = match placed.element {
        Element::Scalar(scalar) => plain(scalar),
        Element::Text(_) | Element::String { .. } => Column::Plain(Box::new(StringBuilder::new())),
        Element::Message(id) => {
            let (message, definition) = (message.nested(id), nested(known, schema));
            let fields = Fields::from(fields(message, definition, schema));
            Column::Message { fields, columns: columns(message, definition, schema), rows: 0 }
        }
    };
    if placed.shape == Shape::Single {
        return column;
    }
    let (item, elements) = (item(message, placed, known, schema), Box::new(column));
    Column::List { item, shape: placed.shape, lengths: Vec::new(), elements }
}

/// The number of elements, if it is fixed.
fn size(shape: Shape) -> Option<i32> {
    match shape {
        Shape::Array(length) => i32::try_from(length).ok(),
        _ => None,
    }
}

fn scalar_type(scalar: Scalar) -> DataType {
    match scalar {
        Scalar::Bool => DataType::Boolean,
        Scalar::Byte | Scalar::Char | Scalar::UInt8 => DataType::UInt8,
        Scalar::UInt16 => DataType::UInt16,
        Scalar::UInt32 => DataType::UInt32,
        Scalar::UInt64 => DataType::UInt64,
        Scalar::Int8 => DataType::Int8,
        Scalar::Int16 => DataType::Int16,
        Scalar::Int32 => DataType::Int32,
        Scalar::Int64 => DataType::Int64,
        Scalar::Float32 => DataType::Float32,
        Scalar::Float64 => DataType::Float64,
    }
}

fn plain(scalar: Scalar) -> Column {
    match scalar {
        Scalar::Bool => Column::Plain(Box::new(BooleanBuilder::new())),
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

fn numbers<T: ArrowPrimitiveType>(read: fn(Value<'_>) -> Option<T::Native>) -> Column {
    Column::Plain(Box::new(Numbers::<T> { builder: PrimitiveBuilder::new(), read }))
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
    /// Adds a value. `None` adds a missing value. Returns the approximate size in bytes.
    pub(super) fn push(&mut self, value: Option<Value<'_>>) -> usize {
        match self {
            Self::Plain(plain) => plain.push(value),
            Self::Message { columns, rows, .. } => {
                *rows += 1;
                let view = value.and_then(|value| match value {
                    Value::Message(view) => Some(view),
                    _ => None,
                });
                let columns = columns.iter_mut().enumerate();
                columns.map(|(index, column)| column.push(view.and_then(|view| view.field(index)))).sum()
            }
            Self::List { shape, lengths, elements, .. } => {
                let values = value.and_then(|value| match value {
                    Value::Array(values) => Some(values),
                    _ => None,
                });
                let found = values.map_or(0, uavspec_dynamic::Elements::len);
                let length = size(*shape).and_then(|size| usize::try_from(size).ok()).unwrap_or(found);
                lengths.push(length);
                let element = |index| values.and_then(|values| values.get(index));
                let size: usize = (0..length).map(|index| elements.push(element(index))).sum();
                size_of::<usize>() + size
            }
        }
    }

    /// Returns the values, and removes them.
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
