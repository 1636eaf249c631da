//! JSON Schemas of messages, for the crate [`schemars`].
//!
//! Each says of an instance what the published schema of the message says, no more and no less: objects
//! are closed and have all fields, integers have the bounds of their types, floats may be null, ranges
//! hold but for the special values, counts keep to the length of what they count. Nested messages are
//! references. Descriptions and units are left to the published ones.
//!
//! They are made from the description of a message when they are asked for, so that a message costs no
//! code of its own here.
//!
//! ```
//! # use uavspec_runtime::{Definition, Message, record};
//! # #[derive(Clone, Debug, Default, PartialEq)]
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

/// The schema of an enum, flags or error codes: any number of its type, of which some have names.
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
    let Some(whole) = Constraint::NONE.asserted(scalar) else { return json_schema!({ "type": "boolean" }) };
    let used = constraint.asserted(scalar).unwrap_or(whole);
    let any = if scalar.is_float() {
        json_schema!({ "type": ["number", "null"] })
    } else {
        json_schema!({ "type": "integer" })
    };
    let mut schema = any.clone();
    let outside = constraint.special.iter().copied().filter(|value| whole.broken_by(*value).is_none());
    let outside: Vec<Number> = outside.filter(|value| used.broken_by(*value).is_some()).collect();
    let has_names = constraint.known.is_some() && !constraint.is_flags;
    if outside.is_empty() {
        insert_all(&mut schema, &used);
    } else {
        let mut within = any.clone();
        insert_all(&mut within, &used);
        // Generators make alternatives of a type only where no value fits two of them, as `oneOf` says.
        let keyword = if are_apart(&used, &outside, scalar) { "oneOf" } else { "anyOf" };
        let exact = outside.into_iter().map(|value| exactly(value, scalar));
        let alternatives: Vec<Schema> = core::iter::once(within).chain(exact).collect();
        if has_names {
            // A schema has one `anyOf`, which the names take: the alternatives stand one level below.
            let mut below = Schema::default();
            below.insert(keyword.to_string(), alternatives.into());
            schema.insert("allOf".to_string(), Vec::from([below]).into());
        } else {
            schema.insert(keyword.to_string(), alternatives.into());
        }
    }
    if has_names {
        schema.insert("anyOf".to_string(), documented(constraint, any).into());
    }
    schema
}

/// Whether every reader can tell the special values from what is used, and from each other: to those who read all
/// numbers as 64-bit floats, large integers are their neighbours.
fn are_apart(used: &Constraint<'static>, outside: &[Number], scalar: Scalar) -> bool {
    let exact = outside.iter().map(|value| bounds_of(*value, scalar));
    let all: Vec<Constraint<'_>> = core::iter::once(*used).chain(exact).collect();
    let ends = |bounds: &Constraint<'_>| (bounds.low.map(Number::as_f64), bounds.high.map(Number::as_f64));
    let is_apart = |(index, bounds): (usize, &Constraint<'_>)| {
        let (low, high) = ends(bounds);
        all[index + 1..].iter().map(ends).all(|(other_low, other_high)| high < other_low || other_high < low)
    };
    all.iter().enumerate().all(is_apart)
}

/// The documented values, and any other.
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

/// Lets through exactly `value`, in each form in which JSON may hold it: a `float32` is written widened to 64 bits or in
/// its shortest form.
#[allow(clippy::cast_possible_truncation)] // rounding is what this is about
fn bounds_of(value: Number, scalar: Scalar) -> Constraint<'static> {
    let exact = value.as_f64();
    let widened = f64::from(exact as f32);
    let shortest = (exact as f32).to_string().parse().unwrap_or(widened);
    #[allow(clippy::float_cmp)] // whether they are one number
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

/// Lets through one value.
fn exactly(value: Number, scalar: Scalar) -> Schema {
    let bounds = bounds_of(value, scalar);
    if bounds.low == bounds.high {
        let mut schema = Schema::default();
        insert(&mut schema, "const", value);
        return schema;
    }
    // Only floats have several forms.
    let mut schema = json_schema!({ "type": "number" });
    insert_all(&mut schema, &bounds);
    schema
}

/// Whole numbers are written without a fraction: not every validator takes `1` for the constant `1.0`.
fn insert(schema: &mut Schema, keyword: &str, value: Number) {
    let value = match value {
        #[allow(clippy::cast_possible_truncation)] // it is less than 2^53
        Number::Float(value) if value.abs() < 9e15 && value % 1.0 == 0.0 => (value as i64).into(),
        Number::Float(value) => value.into(),
        Number::Int(value) => match u64::try_from(value) {
            Ok(value) => value.into(),
            // The bounds of all types fit one of both.
            Err(_) => i64::try_from(value).unwrap_or(i64::MIN).into(),
        },
    };
    schema.insert(keyword.to_string(), value);
}

/// Finds the types of nested messages, which the description doesn't hold, by reading a message from
/// nothing: what is asked for in place of a field has the type of the field.
struct References<'g> {
    generator: &'g mut SchemaGenerator,
    /// The message whose fields are read.
    message: &'static MessageDescriptor,
    /// For each field of the message.
    found: Vec<Option<Schema>>,
    /// The field that is being read.
    field: usize,
    /// How many messages lie around what is being read.
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
        // One element, to see its type.
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

    fn blame(&mut self, _: usize) {}
}

/// Gives a message its schema.
#[doc(hidden)]
#[macro_export]
macro_rules! __schema_record {
    ($type:ident) => {
        $crate::__schema!(
            $type,
            <Self as $crate::record::Record>::DESCRIPTOR.name,
            $crate::schema::message::<Self>
        );
    };
}

/// Gives an enum, flags or an error code its schema.
#[doc(hidden)]
#[macro_export]
macro_rules! __schema_number {
    ($type:ident) => {
        $crate::__schema!($type, <Self as $crate::Open>::NAME, |_| $crate::schema::open::<Self>());
    };
}

/// Implements `JsonSchema` by a function.
#[doc(hidden)]
#[macro_export]
macro_rules! __schema {
    ($type:ident, $name:expr, $make:expr) => {
        impl $crate::schemars::JsonSchema for $type {
            fn schema_name() -> $crate::alloc::borrow::Cow<'static, str> {
                $crate::alloc::borrow::Cow::Borrowed($name)
            }

            fn schema_id() -> $crate::alloc::borrow::Cow<'static, str> {
                $crate::alloc::borrow::Cow::Borrowed(concat!(module_path!(), "::", stringify!($type)))
            }

            fn json_schema(generator: &mut $crate::schemars::SchemaGenerator) -> $crate::schemars::Schema {
                let make = $make;
                make(generator)
            }
        }
    };
}
