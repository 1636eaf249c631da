//! JSON Schemas of messages, for the [`schemars`] crate.
//!
//! Each schema accepts the same instances as the published schema of the message. Objects have exactly the fields of
//! the message, integers have the bounds of their types, and floats may be null. Ranges apply to all values except
//! special values. Counts must not exceed the length of their array. Nested messages are references. Only the published
//! schemas contain descriptions and units.
//!
//! Each schema is built from the message descriptor at run time, so messages need no additional code.
//!
//! ```
//! # use uavspec_runtime::{Definition, Message, record};
//! # #[derive(Clone, Default, PartialEq)]
//! # struct Wind {
//! #     speed: f32,
//! # }
//! # impl Message for Wind {
//! #     const DEFINITION: Definition = Definition::new("example", "Wind");
//! # }
//! # record! {
//! #     Wind[1];
//! #     0 speed = float32("speed", 0).within(&number().from(int(0)).not_nan());
//! # }
//! use uavspec_runtime::schemars::schema_for;
//!
//! let schema = schema_for!(Wind);
//! assert_eq!(schema.get("required").map(ToString::to_string).as_deref(), Some(r#"["speed"]"#));
//! ```

use alloc::string::ToString as _;
use alloc::vec::Vec;
use core::mem;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use crate::descriptor::{Element, FieldDescriptor, MessageDescriptor, Shape};
use crate::record::{FieldSource, Primitive, Record, Source, Value};
use crate::{Constraint, Number, Open, Scalar};

/// A message that has a schema.
#[doc(hidden)]
pub trait SchemaRecord: JsonSchema {}

impl<T: JsonSchema> SchemaRecord for T {}

/// The schema of a message.
#[doc(hidden)]
pub fn message<T: Record>(generator: &mut SchemaGenerator) -> Schema {
    let message = T::DESCRIPTOR;
    let mut properties = Schema::default();
    let mut references = References::new(message, generator);
    T::read_fields(&mut references);
    for (field, reference) in message.fields.iter().zip(references.found) {
        let mut schema = property(field, reference);
        schema.insert("title".to_string(), field.name.into());
        properties.insert(field.name.to_string(), schema.into());
    }
    let required: Vec<&str> = message.fields.iter().map(|field| field.name).collect();
    json_schema!({
        "title": message.name,
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

/// The schema of an enum, flags or error codes. The schema allows any number of the type, and names the documented
/// values.
#[doc(hidden)]
pub fn open<T: Open>() -> Schema {
    let known =
        Constraint { known: Some(T::KNOWN), names: T::NAMES, is_flags: T::IS_FLAGS, ..Constraint::NONE };
    let mut schema = number(T::SCALAR, &known);
    schema.insert("title".to_string(), T::NAME.into());
    schema
}

fn property(field: &FieldDescriptor, reference: Option<Schema>) -> Schema {
    let element = match field.element {
        Element::Scalar(scalar) => number(scalar, field.constraint.unwrap_or(&Constraint::NONE)),
        Element::Text => {
            let bytes = field.shape.bound();
            return json_schema!({ "type": "string", "maxLength": bytes });
        }
        Element::String { bound: Some(bound), .. } => json_schema!({ "type": "string", "maxLength": bound }),
        Element::String { bound: None, .. } => json_schema!({ "type": "string" }),
        Element::Message(_) => reference.unwrap_or_default(),
    };
    match field.shape {
        Shape::Single => element,
        Shape::Sequence => json_schema!({ "type": "array", "items": element }),
        Shape::Bounded(bound) => json_schema!({ "type": "array", "items": element, "maxItems": bound }),
        Shape::Array(length) => {
            json_schema!({ "type": "array", "items": element, "minItems": length, "maxItems": length })
        }
    }
}

fn number(scalar: Scalar, constraint: &Constraint<'_>) -> Schema {
    let Some(full) = Constraint::NONE.asserted(scalar) else { return json_schema!({ "type": "boolean" }) };
    let used = constraint.asserted(scalar).unwrap_or(full);
    let any = if scalar.is_float() {
        json_schema!({ "type": ["number", "null"] })
    } else {
        json_schema!({ "type": "integer" })
    };
    let mut schema = any.clone();
    let outside = constraint.special.iter().copied().filter(|value| full.violated_by(*value).is_none());
    let outside: Vec<Number> = outside.filter(|value| used.violated_by(*value).is_some()).collect();
    let has_names = constraint.known.is_some() && !constraint.is_flags;
    if outside.is_empty() {
        insert_all(&mut schema, &used);
    } else {
        let mut within = any.clone();
        insert_all(&mut within, &used);
        // Code generators create a union type only for `oneOf`, which requires that the alternatives don't overlap.
        let keyword = if are_disjoint(&used, &outside, scalar) { "oneOf" } else { "anyOf" };
        let exact = outside.into_iter().map(|value| exactly(value, scalar));
        let alternatives: Vec<Schema> = core::iter::once(within).chain(exact).collect();
        if has_names {
            // A schema can have only one `anyOf`, and it already contains the names. The alternatives are therefore
            // nested one level deeper.
            let mut nested = Schema::default();
            nested.insert(keyword.to_string(), alternatives.into());
            schema.insert("allOf".to_string(), Vec::from([nested]).into());
        } else {
            schema.insert(keyword.to_string(), alternatives.into());
        }
    }
    if has_names {
        schema.insert("anyOf".to_string(), documented(constraint, any).into());
    }
    schema
}

/// True if the special values differ from the ordinary values and from each other. This must also hold for parsers that
/// read all numbers as 64-bit floats, which rounds large integers.
fn are_disjoint(used: &Constraint<'static>, outside: &[Number], scalar: Scalar) -> bool {
    let exact = outside.iter().map(|value| bounds_of(*value, scalar));
    let all: Vec<Constraint<'_>> = core::iter::once(*used).chain(exact).collect();
    let ends = |bounds: &Constraint<'_>| (bounds.low.map(Number::as_f64), bounds.high.map(Number::as_f64));
    let is_disjoint = |(index, bounds): (usize, &Constraint<'_>)| {
        let (low, high) = ends(bounds);
        all[index + 1..].iter().map(ends).all(|(other_low, other_high)| high < other_low || other_high < low)
    };
    all.iter().enumerate().all(is_disjoint)
}

/// Schemas for the documented values, followed by a schema for any other value.
fn documented(constraint: &Constraint<'_>, any: Schema) -> Vec<Schema> {
    let known = constraint.known.unwrap_or_default().iter().enumerate();
    let values = known.map(|(index, value)| {
        let mut schema = Schema::default();
        insert(&mut schema, "const", Number::Int(*value));
        if let Some(name) = constraint.names.get(index).filter(|name| !name.is_empty()) {
            schema.insert("title".to_string(), (*name).into());
        }
        schema
    });
    values.chain([any]).collect()
}

/// The constraint that allows exactly `value`, in any of its JSON forms. Some programs widen a `float32` to 64 bits,
/// and others write the shortest decimal.
#[allow(clippy::cast_possible_truncation)] // rounding is intended
fn bounds_of(value: Number, scalar: Scalar) -> Constraint<'static> {
    let exact = value.as_f64();
    let widened = f64::from(exact as f32);
    let shortest = (exact as f32).to_string().parse().unwrap_or(widened);
    #[allow(clippy::float_cmp)] // exact comparison is intended
    let (low, high) = if scalar == Scalar::Float32 && (exact != widened || widened != shortest) {
        let (low, high) = (exact.min(widened).min(shortest), exact.max(widened).max(shortest));
        (Number::Float(low), Number::Float(high))
    } else {
        (value, value)
    };
    Constraint::NONE.from(low).to(high)
}

fn insert_all(schema: &mut Schema, constraint: &Constraint<'_>) {
    constraint.keywords().for_each(|(keyword, value)| insert(schema, keyword, value));
}

/// The schema that allows exactly one value.
fn exactly(value: Number, scalar: Scalar) -> Schema {
    let bounds = bounds_of(value, scalar);
    if bounds.low == bounds.high {
        let mut schema = Schema::default();
        insert(&mut schema, "const", value);
        return schema;
    }
    // Only a float can have several JSON forms.
    let mut schema = json_schema!({ "type": "number" });
    insert_all(&mut schema, &bounds);
    schema
}

/// Inserts a number. Whole numbers are written without a fraction, because some validators don't accept `1` for the
/// constant `1.0`.
fn insert(schema: &mut Schema, keyword: &str, value: Number) {
    let value = match value {
        #[allow(clippy::cast_possible_truncation)] // the number is less than 2^53
        Number::Float(value) if value.abs() < 9e15 && value % 1.0 == 0.0 => (value as i64).into(),
        Number::Float(value) => value.into(),
        Number::Int(value) => match u64::try_from(value) {
            Ok(value) => value.into(),
            // The bounds of all types fit `u64` or `i64`.
            Err(_) => i64::try_from(value).unwrap_or(i64::MIN).into(),
        },
    };
    schema.insert(keyword.to_string(), value);
}

/// Finds the schemas of nested messages. The message descriptor doesn't contain the Rust types of nested messages. This
/// source therefore reads a dummy message, and records the type of each field that contains a message.
struct References<'g> {
    generator: &'g mut SchemaGenerator,
    /// The message whose fields are read.
    message: &'static MessageDescriptor,
    /// The schema of the nested message in each field, if any.
    found: Vec<Option<Schema>>,
    /// The field that is being read.
    field: usize,
    /// The nesting depth of the message that is being read.
    depth: usize,
}

impl<'g> References<'g> {
    fn new(message: &'static MessageDescriptor, generator: &'g mut SchemaGenerator) -> Self {
        let found = message.fields.iter().map(|_| None).collect();
        Self { generator, message, found, field: 0, depth: 0 }
    }
}

impl FieldSource for References<'_> {
    fn field<T: Value>(&mut self, index: usize) -> T {
        if self.depth == 0 {
            self.field = index;
        }
        T::read(self, &self.message.fields[index])
    }
}

impl Source for References<'_> {
    fn scalar<P: Primitive>(&mut self) -> P {
        P::default()
    }

    fn scalars<P: Primitive>(&mut self, _: &mut [P]) {}

    fn length(&mut self, _: Shape, _: usize) -> usize {
        // One element is enough to find the type.
        usize::from(self.depth == 0)
    }

    fn string(&mut self, _: bool, _: Option<u32>) -> alloc::string::String {
        alloc::string::String::new()
    }

    fn message<M: Record>(&mut self) -> M {
        if self.depth == 0
            && let Some(found @ None) = self.found.get_mut(self.field)
        {
            *found = Some(self.generator.subschema_for::<M>());
        }
        self.depth += 1;
        let outer = mem::replace(&mut self.message, M::DESCRIPTOR);
        let message = M::read_fields(self);
        self.message = outer;
        self.depth -= 1;
        message
    }

    fn has_failed(&self) -> bool {
        false
    }

    fn locate_fault(&mut self, _: usize) {}
}

/// Implements `JsonSchema` for a message.
#[doc(hidden)]
#[macro_export]
macro_rules! __schema_record {
    ($type:ident) => {
        $crate::__schema!($type, generator => $crate::schema::message::<Self>(generator));
    };
}

/// Implements `JsonSchema` for an enum, flags or an error code.
#[doc(hidden)]
#[macro_export]
macro_rules! __schema_number {
    ($type:ident) => {
        $crate::__schema!($type, _generator => $crate::schema::open::<Self>());
    };
}

/// Implements `JsonSchema` with an expression for the schema.
#[doc(hidden)]
#[macro_export]
macro_rules! __schema {
    ($type:ident, $generator:ident => $schema:expr) => {
        impl $crate::schemars::JsonSchema for $type {
            fn schema_name() -> $crate::alloc::borrow::Cow<'static, str> {
                $crate::alloc::borrow::Cow::Borrowed(stringify!($type))
            }

            fn schema_id() -> $crate::alloc::borrow::Cow<'static, str> {
                $crate::alloc::borrow::Cow::Borrowed(concat!(module_path!(), "::", stringify!($type)))
            }

            fn json_schema($generator: &mut $crate::schemars::SchemaGenerator) -> $crate::schemars::Schema {
                $schema
            }
        }
    };
}
