//! Access to messages in place.

use std::fmt;

use uavspec_runtime::record::Primitive;
use uavspec_runtime::{Number, Scalar};
use uavspec_schema::Element;

use super::bytes::{part, slot, until_nul};
use super::plan::{Field, Plan};
use super::types::{MessageType, Types};

/// A message inside a payload or a [`DynamicMessage`](super::DynamicMessage). Fields are read on access.
#[derive(Clone, Copy)]
pub struct DynamicView<'v> {
    pub(super) types: &'v Types,
    pub(super) plan: &'v Plan,
    /// The whole buffer.
    pub(super) bytes: &'v [u8],
    /// Offset of the first byte of this message.
    pub(super) base: usize,
}

/// The value of a field.
#[derive(Clone, Copy, Debug)]
pub enum Value<'v> {
    /// A `bool`: true unless its byte is 0.
    Bool(bool),
    /// A signed integer.
    Int(i64),
    /// An unsigned integer, a `byte` or a `char`.
    UInt(u64),
    /// A `float32`.
    Float32(f32),
    /// A `float64`.
    Float64(f64),
    /// The bytes of PX4's `char[N]` before the first NUL. The bytes may be invalid UTF-8.
    Text(&'v [u8]),
    /// The bytes of a string. They may be invalid UTF-8: in a `string`, any bytes other than NUL; in a `wstring`,
    /// unpaired surrogates of three bytes each, as in WTF-8.
    String(&'v [u8]),
    /// A nested message.
    Message(DynamicView<'v>),
    /// An array or a sequence.
    Array(Elements<'v>),
}

/// The elements of an array or a sequence.
#[derive(Clone, Copy)]
pub struct Elements<'v> {
    view: DynamicView<'v>,
    element: Element,
    /// Offset of the first element.
    start: usize,
    stride: usize,
    length: usize,
}

impl<'v> DynamicView<'v> {
    /// Type of the message.
    pub fn message_type(self) -> MessageType<'v> {
        MessageType { types: self.types, plan: self.plan }
    }

    /// The value at a path such as `events[2].id`, if it exists.
    pub fn get(self, path: &str) -> Option<Value<'v>> {
        let mut value = Value::Message(self);
        for step in path.split('.') {
            let Value::Message(view) = value else { return None };
            let (name, index) = match step.strip_suffix(']') {
                Some(step) => step.split_once('[').map(|(name, index)| (name, Some(index)))?,
                None => (step, None),
            };
            let field = view.plan.fields.iter().find(|field| *field.name == *name)?;
            value = match (index, view.value(field)) {
                (None, value) => value,
                (Some(index), Value::Array(elements)) => elements.get(index.parse().ok()?)?,
                _ => return None,
            };
        }
        Some(value)
    }

    /// Names and values of all fields, in declaration order.
    pub fn fields(self) -> impl ExactSizeIterator<Item = (&'v str, Value<'v>)> {
        self.plan.fields.iter().map(move |field| (&*field.name, self.value(field)))
    }

    /// The value of the field with this index, in declaration order.
    pub fn field(self, index: usize) -> Option<Value<'v>> {
        self.plan.fields.get(index).map(|field| self.value(field))
    }

    pub(super) fn value(self, field: &'v Field) -> Value<'v> {
        let elements = self.elements(field);
        if field.shape == uavspec_schema::Shape::Single { elements.value(0) } else { Value::Array(elements) }
    }

    /// The elements of a field. A field that isn't an array has one element.
    #[inline]
    pub(super) fn elements(self, field: &Field) -> Elements<'v> {
        let at = self.base + field.offset;
        let (start, length) = if field.is_sequence() { slot(self.bytes, at) } else { (at, field.count()) };
        Elements { view: self, element: field.element, start, stride: field.stride, length }
    }
}

impl<'v> Elements<'v> {
    /// Number of elements.
    pub fn len(self) -> usize {
        self.length
    }

    /// True if there are no elements.
    pub fn is_empty(self) -> bool {
        self.length == 0
    }

    /// The element with this index, if it exists.
    pub fn get(self, index: usize) -> Option<Value<'v>> {
        (index < self.length).then(|| self.value(index))
    }

    /// All elements in order.
    pub fn iter(self) -> impl ExactSizeIterator<Item = Value<'v>> + DoubleEndedIterator {
        (0..self.length).map(move |index| self.value(index))
    }

    fn value(self, index: usize) -> Value<'v> {
        match self.element {
            Element::Scalar(scalar) => scalar_value(scalar, self.element_bytes(index)),
            Element::Text(_) => Value::Text(until_nul(self.element_bytes(index))),
            Element::String { .. } => Value::String(self.string(index)),
            Element::Message(_) => Value::Message(self.message(index)),
        }
    }

    /// The offset of an element in the buffer.
    #[inline]
    pub(super) fn at(self, index: usize) -> usize {
        self.start + index * self.stride
    }

    /// The bytes of an element of fixed size.
    #[inline]
    pub(super) fn element_bytes(self, index: usize) -> &'v [u8] {
        part(self.view.bytes, self.at(index), self.stride)
    }

    /// The bytes of all elements.
    #[inline]
    pub(super) fn bytes(self) -> &'v [u8] {
        part(self.view.bytes, self.start, self.length * self.stride)
    }

    #[inline]
    pub(super) fn string(self, index: usize) -> &'v [u8] {
        let (start, length) = slot(self.view.bytes, self.at(index));
        part(self.view.bytes, start, length)
    }

    #[inline]
    pub(super) fn message(self, index: usize) -> DynamicView<'v> {
        let plan = match self.element {
            Element::Message(id) => self.view.types.get(id).plan,
            Element::Scalar(_) | Element::Text(_) | Element::String { .. } => self.view.plan,
        };
        DynamicView { plan, base: self.at(index), ..self.view }
    }
}

pub(super) fn scalar_value(scalar: Scalar, bytes: &[u8]) -> Value<'static> {
    match scalar {
        Scalar::Bool => Value::Bool(bool::read_le(bytes)),
        Scalar::Byte | Scalar::Char | Scalar::UInt8 => Value::UInt(u8::read_le(bytes).into()),
        Scalar::Int8 => Value::Int(i8::read_le(bytes).into()),
        Scalar::Int16 => Value::Int(i16::read_le(bytes).into()),
        Scalar::UInt16 => Value::UInt(u16::read_le(bytes).into()),
        Scalar::Int32 => Value::Int(i32::read_le(bytes).into()),
        Scalar::UInt32 => Value::UInt(u32::read_le(bytes).into()),
        Scalar::Int64 => Value::Int(i64::read_le(bytes)),
        Scalar::UInt64 => Value::UInt(u64::read_le(bytes)),
        Scalar::Float32 => Value::Float32(f32::read_le(bytes)),
        Scalar::Float64 => Value::Float64(f64::read_le(bytes)),
    }
}

impl Value<'_> {
    /// The value as a number, if it is numeric. A `bool` is 0 or 1.
    pub fn number(self) -> Option<Number> {
        match self {
            Self::Bool(value) => Some(Number::Int(value.into())),
            Self::Int(value) => Some(Number::Int(value.into())),
            Self::UInt(value) => Some(Number::Int(value.into())),
            Self::Float32(value) => Some(Number::Float(value.into())),
            Self::Float64(value) => Some(Number::Float(value)),
            Self::Text(_) | Self::String(_) | Self::Message(_) | Self::Array(_) => None,
        }
    }
}

impl fmt::Debug for DynamicView<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut out = formatter.debug_struct(&self.plan.name);
        for (name, value) in self.fields() {
            out.field(name, &value);
        }
        out.finish()
    }
}

impl fmt::Debug for Elements<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_list().entries(self.iter()).finish()
    }
}
