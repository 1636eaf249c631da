//! Checks values against their schemas in one pass, without building a tree.
//!
//! This module only confirms valid values. For all other values, [`super::check`] examines a tree. Nearly all values in
//! UAV states are integers, so integer schemas are stored as 64-bit ranges.

use uavspec_model::json::{Token, Tokens, Unclear};
use uavspec_schema::json_type::Direction;

use super::bodies::DefinedSchemas;
use super::check::fits;
use super::defined::{Field, Length, Object, ValueSchema};

/// The number of positions, from the start of a list, that may have separate limits.
const MAX_LIMITED: usize = 16;

/// The fields of the objects in a map within a body.
#[derive(Debug)]
pub struct Members<'s> {
    object: &'s Object,
    fields: Vec<Member<'s>>,
}

/// A field.
#[derive(Debug)]
struct Member<'s> {
    schema: &'s ValueSchema,
    plain: Plain<'s>,
}

/// The schema of a field.
#[derive(Debug)]
enum Plain<'s> {
    One(Scalar<'s>),
    /// A list with a separate schema for each position.
    Tuple(Vec<Scalar<'s>>, Length),
    /// A list whose elements share one schema.
    List(Scalar<'s>, Length),
}

/// The schema of a scalar value.
#[derive(Clone, Copy, Debug)]
enum Scalar<'s> {
    /// An integer from the first to the second value.
    Range(i64, i64),
    /// A nullable integer from the first to the second value.
    Nullable(i64, i64),
    Other(&'s ValueSchema),
}

impl DefinedSchemas {
    /// The fields of the objects in a map. `None` if the body's `map` field isn't a map of objects. `limits` gives the
    /// range of a field's element, by index, in addition to the range in its schema.
    pub fn members(
        &self,
        type_name: &str,
        direction: Direction,
        map: &str,
        limits: fn(&str, usize) -> Option<(i64, i64)>,
    ) -> Option<Members<'_>> {
        let body = &self.objects[self.body(type_name, direction)?.object];
        let ValueSchema::Map(inner) = &body.fields[body.field(map, None)?].schema else { return None };
        let ValueSchema::Object(index) = **inner else { return None };
        let object = &self.objects[index];
        let fields = object.fields.iter().map(|field| {
            let (name, schema) = (&*field.name, &field.schema);
            Member { schema, plain: Plain::new(self, schema, |at| limits(name, at)) }
        });
        Some(Members { object, fields: fields.collect() })
    }
}

impl Members<'_> {
    /// The number of fields.
    pub fn num_fields(&self) -> usize {
        self.fields.len()
    }

    /// The index of a field. The search is fast for the field that usually follows `previous`.
    pub fn field(&self, name: &str, previous: Option<usize>) -> Option<usize> {
        self.object.field(name, previous)
    }

    /// True if the value of a field matches its schema.
    pub fn accepts(&self, field: usize, token: &Token<'_>) -> bool {
        accepts(self.fields[field].schema, token)
    }

    /// True if a string matches the schema of a field.
    pub fn accepts_text(&self, field: usize, text: &str) -> bool {
        accepts_text(self.fields[field].schema, text)
    }

    /// Reads the value of a field. Fails if the value isn't clearly valid.
    pub fn takes(&self, field: usize, tokens: &mut Tokens<'_>) -> Result<(), Unclear> {
        match &self.fields[field].plain {
            Plain::One(scalar) => scalar.takes(tokens),
            Plain::Tuple(elements, length) => {
                list(tokens, *length, |at, tokens| elements.get(at).ok_or(Unclear)?.takes(tokens))
            }
            Plain::List(element, length) => list(tokens, *length, |_, tokens| element.takes(tokens)),
        }
    }
}

impl<'s> Plain<'s> {
    fn new(
        defined_schemas: &'s DefinedSchemas,
        schema: &'s ValueSchema,
        limits: impl Fn(usize) -> Option<(i64, i64)>,
    ) -> Self {
        match schema {
            ValueSchema::Tuple(index) => {
                let tuple = &defined_schemas.tuples[*index];
                let scalar =
                    |(at, element): (usize, &'s Field)| Scalar::new(&element.schema).within(limits(at));
                let elements = tuple.elements.iter().enumerate().map(scalar);
                Self::Tuple(elements.collect(), tuple.length())
            }
            // Checking that elements are unique requires the tree.
            ValueSchema::List(list) if !list.is_unique => {
                // Limits that depend on the position require the tree, too.
                let is_limited = (0..MAX_LIMITED).any(|at| limits(at).is_some());
                let element = if is_limited { Scalar::UNCLEAR } else { Scalar::new(&list.element) };
                Self::List(element, list.length)
            }
            schema => Self::One(Scalar::new(schema)),
        }
    }
}

impl<'s> Scalar<'s> {
    /// A value that is never clearly valid.
    const UNCLEAR: Self = Self::Range(1, 0);

    fn new(schema: &'s ValueSchema) -> Self {
        match schema {
            ValueSchema::Integer(low, high) => {
                let bound = |bound: &i128| i64::try_from((*bound).clamp(i64::MIN.into(), i64::MAX.into()));
                bound(low)
                    .ok()
                    .zip(bound(high).ok())
                    .map_or(Self::Other(schema), |(low, high)| Self::Range(low, high))
            }
            ValueSchema::Either(all) => match &all[..] {
                [one, ValueSchema::Null] | [ValueSchema::Null, one] => match Self::new(one) {
                    Self::Range(low, high) => Self::Nullable(low, high),
                    _ => Self::Other(schema),
                },
                _ => Self::Other(schema),
            },
            schema => Self::Other(schema),
        }
    }

    /// Restricts the value to a range. Only ranges of integers are compared here.
    fn within(self, limits: Option<(i64, i64)>) -> Self {
        let Some((min, max)) = limits else { return self };
        match self {
            Self::Range(low, high) => Self::Range(low.max(min), high.min(max)),
            Self::Nullable(low, high) => Self::Nullable(low.max(min), high.min(max)),
            Self::Other(_) => Self::UNCLEAR,
        }
    }

    /// Reads a value. Fails if the value isn't clearly valid.
    #[inline]
    fn takes(&self, tokens: &mut Tokens<'_>) -> Result<(), Unclear> {
        let fits = match *self {
            Self::Nullable(..) if tokens.takes_null() => true,
            Self::Range(low, high) | Self::Nullable(low, high) => {
                tokens.integer().is_some_and(|value| low <= value && value <= high)
            }
            Self::Other(schema) => match tokens.plain_text() {
                Some(text) => accepts_text(schema, text),
                None => accepts(schema, &tokens.token()?),
            },
        };
        if fits { Ok(()) } else { Err(Unclear) }
    }
}

/// Reads a list. `take` reads an element, and gets its index.
fn list(
    tokens: &mut Tokens<'_>,
    length: Length,
    mut take: impl FnMut(usize, &mut Tokens<'_>) -> Result<(), Unclear>,
) -> Result<(), Unclear> {
    let mut count = 0;
    tokens.list(|tokens| {
        take(count, tokens)?;
        count += 1;
        Ok::<(), Unclear>(())
    })?;
    if length.accepts(count) { Ok(()) } else { Err(Unclear) }
}

/// True if a value matches a schema.
fn accepts(schema: &ValueSchema, token: &Token<'_>) -> bool {
    match (schema, token) {
        // Tokens such as `NaN` aren't JSON.
        (_, Token::NotJson(_)) => false,
        (ValueSchema::Any, _) | (ValueSchema::Null, Token::Null) | (ValueSchema::Bool, Token::Bool(_)) => {
            true
        }
        (ValueSchema::Integer(low, high), Token::Int(value)) => (low..=high).contains(&value),
        (ValueSchema::Integers(all), Token::Int(value)) => all.iter().any(|one| i128::from(*one) == *value),
        #[allow(clippy::cast_precision_loss)] // bounds are rounded in the same way
        (ValueSchema::Number(low, high), Token::Int(value)) => {
            let value = *value as f64;
            low.is_none_or(|low| value >= low) && high.is_none_or(|high| value <= high)
        }
        (_, Token::Text(text)) => accepts_text(schema, text),
        (ValueSchema::Either(all), _) => all.iter().any(|schema| accepts(schema, token)),
        _ => false,
    }
}

/// True if a string matches a schema.
fn accepts_text(schema: &ValueSchema, text: &str) -> bool {
    match schema {
        ValueSchema::Any => true,
        ValueSchema::Text(schema) => fits(schema, text),
        ValueSchema::Constants(all) => all.iter().any(|constant| constant == text),
        ValueSchema::Either(all) => all.iter().any(|schema| accepts_text(schema, text)),
        _ => false,
    }
}
