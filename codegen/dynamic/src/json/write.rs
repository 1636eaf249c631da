//! Serialization to JSON or any other serde format.

use std::ops::ControlFlow;

use serde::ser::{Error as _, SerializeMap as _, SerializeSeq as _};
use serde::{Serialize, Serializer};
use uavspec_runtime::record::Primitive;
use uavspec_runtime::{Number, Scalar};
use uavspec_schema::{Element, Shape};

use crate::bytes::until_nul;
use crate::error::{Error, Reason};
use crate::message::DynamicMessage;
use crate::plan::{Field, Plan};
use crate::trail::Trail;
use crate::view::{DynamicView, Elements, scalar_value};
use crate::walk::{Stop, Walk, walk};

impl Serialize for DynamicMessage<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.view().serialize(serializer)
    }
}

/// Serializes all fields in declaration order. In text formats NaN is `null`, and infinity is an error. Text that is not
/// UTF-8 is an error in all formats.
impl Serialize for DynamicView<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut out = serializer.serialize_map(Some(self.plan.fields.len()))?;
        for field in &self.plan.fields {
            out.serialize_entry(&*field.name, &Member { field, elements: self.elements(field) })?;
        }
        out.end()
    }
}

/// The value of a field.
struct Member<'v> {
    field: &'v Field,
    elements: Elements<'v>,
}

impl Serialize for Member<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { field, elements } = *self;
        let is_single = field.shape == Shape::Single;
        match field.element {
            Element::Scalar(scalar) if is_single => number(field, scalar, elements.bytes(), serializer),
            Element::Scalar(scalar) => numbers(field, scalar, elements.bytes(), serializer),
            Element::Text(_) => text(field, until_nul(elements.bytes()), serializer),
            Element::String { .. } if is_single => text(field, elements.string(0), serializer),
            Element::String { .. } => {
                let string = |index| StringOf { field, bytes: elements.string(index) };
                serializer.collect_seq((0..elements.len()).map(string))
            }
            Element::Message(_) if is_single => elements.message(0).serialize(serializer),
            Element::Message(_) => {
                serializer.collect_seq((0..elements.len()).map(|index| elements.message(index)))
            }
        }
    }
}

/// Calls `$function` with the primitive type of a scalar.
macro_rules! with_primitive {
    ($scalar:expr, $function:ident($($argument:expr),*)) => {
        match $scalar {
            Scalar::Bool => $function::<bool, _>($($argument),*),
            Scalar::Byte | Scalar::Char | Scalar::UInt8 => $function::<u8, _>($($argument),*),
            Scalar::Int8 => $function::<i8, _>($($argument),*),
            Scalar::Int16 => $function::<i16, _>($($argument),*),
            Scalar::UInt16 => $function::<u16, _>($($argument),*),
            Scalar::Int32 => $function::<i32, _>($($argument),*),
            Scalar::UInt32 => $function::<u32, _>($($argument),*),
            Scalar::Int64 => $function::<i64, _>($($argument),*),
            Scalar::UInt64 => $function::<u64, _>($($argument),*),
            Scalar::Float32 => $function::<f32, _>($($argument),*),
            Scalar::Float64 => $function::<f64, _>($($argument),*),
        }
    };
}

fn number<S: Serializer>(
    field: &Field,
    scalar: Scalar,
    bytes: &[u8],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    with_primitive!(scalar, one(field, bytes, serializer))
}

fn numbers<S: Serializer>(
    field: &Field,
    scalar: Scalar,
    bytes: &[u8],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    with_primitive!(scalar, many(field, bytes, serializer))
}

fn one<P: SerializeNumber, S: Serializer>(
    field: &Field,
    bytes: &[u8],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    P::read_le(bytes).serialize_number(&field.name, serializer)
}

fn many<P: SerializeNumber, S: Serializer>(
    field: &Field,
    bytes: &[u8],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut out = serializer.serialize_seq(Some(bytes.len() / P::SIZE))?;
    for bytes in bytes.chunks_exact(P::SIZE) {
        out.serialize_element(&ElementOf { field: &field.name, number: P::read_le(bytes) })?;
    }
    out.end()
}

struct ElementOf<'f, P> {
    field: &'f str,
    number: P,
}

impl<P: SerializeNumber> Serialize for ElementOf<'_, P> {
    #[inline]
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.number.serialize_number(self.field, serializer)
    }
}

/// A primitive type that serde can serialize.
trait SerializeNumber: Primitive {
    fn serialize_number<S: Serializer>(self, field: &str, serializer: S) -> Result<S::Ok, S::Error>;
}

macro_rules! exact {
    ($($type:ty),*) => {$(
        impl SerializeNumber for $type {
            #[inline]
            fn serialize_number<S: Serializer>(self, _: &str, serializer: S) -> Result<S::Ok, S::Error> {
                self.serialize(serializer)
            }
        }
    )*};
}

exact!(bool, u8, i8, u16, i16, u32, i32, u64, i64);

macro_rules! floats {
    ($($type:ty),*) => {$(
        impl SerializeNumber for $type {
            #[inline]
            fn serialize_number<S: Serializer>(self, field: &str, serializer: S) -> Result<S::Ok, S::Error> {
                if self.is_finite() || !serializer.is_human_readable() {
                    self.serialize(serializer)
                } else if self.is_nan() {
                    serializer.serialize_none()
                } else {
                    Err(S::Error::custom(format_args!("{field} is {self}, which JSON can't represent")))
                }
            }
        }
    )*};
}

floats!(f32, f64);

/// An element of an array of strings.
struct StringOf<'v> {
    field: &'v Field,
    bytes: &'v [u8],
}

impl Serialize for StringOf<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        text(self.field, self.bytes, serializer)
    }
}

fn text<S: Serializer>(field: &Field, bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    let text = std::str::from_utf8(bytes);
    let text = text.map_err(|error| S::Error::custom(format_args!("{}: {error}", field.name)))?;
    serializer.serialize_str(text)
}

/// Finds the value that prevents a message from having a JSON form.
#[cold]
pub(crate) fn explain(view: DynamicView<'_>, fallback: &serde_json::Error) -> Error {
    let mut search = Search { message: &view.plan.name, found: None };
    // If the serializer failed for another reason, the walk finds nothing.
    let _ = walk(view, &mut Trail::default(), &mut search);
    search.found.unwrap_or_else(|| Error {
        reason: Reason::Json(fallback.to_string()),
        path: view.plan.name.to_string(),
        offset: None,
    })
}

struct Search<'v> {
    message: &'v str,
    found: Option<Error>,
}

impl<'v> Walk<'v> for Search<'v> {
    fn enters(&self, _: &[Plan], field: &Field) -> bool {
        match field.element {
            Element::Scalar(scalar) => scalar.is_float(),
            Element::Text(_) | Element::String { .. } | Element::Message(_) => true,
        }
    }

    fn stop(&mut self, trail: &Trail<'v>, _: &'v Field, stop: Stop<'v>) -> ControlFlow<()> {
        let text = match stop {
            Stop::Number(scalar, bytes, _) => match scalar_value(scalar, bytes).number() {
                Some(Number::Float(value)) if value.is_infinite() => {
                    format!("{value}, which JSON can't represent")
                }
                _ => return ControlFlow::Continue(()),
            },
            Stop::Text(bytes) | Stop::String(bytes) => match std::str::from_utf8(bytes) {
                Ok(_) => return ControlFlow::Continue(()),
                Err(error) => error.to_string(),
            },
            Stop::Length(_) => return ControlFlow::Continue(()),
        };
        let path = trail.text(self.message);
        self.found = Some(Error { reason: Reason::Json(text), path, offset: None });
        ControlFlow::Break(())
    }
}
