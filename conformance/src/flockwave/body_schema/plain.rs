//! Whether values have their shape, seen while they are read, and not from a tree.
//!
//! It says yes or nothing: what isn't plain to see, [`super::check`] finds out from the tree. Shapes of integers, which nearly
//! all values of states of UAVs have, are kept as ranges of 64 bits.

use super::bodies::Shapes;
use super::check::fits;
use super::defined::{Defined, Length, Object};
use crate::json::{Token, Tokens, Unclear};
use uavspec_codegen::schema::json_type::Direction;

/// The fields of the objects that a map in a body holds.
#[derive(Debug)]
pub(crate) struct Members<'s> {
    object: &'s Object,
    fields: Vec<Member<'s>>,
}

/// A field.
#[derive(Debug)]
struct Member<'s> {
    name: &'s str,
    shape: &'s Defined,
    plain: Plain<'s>,
}

/// What the values of a field have to be.
#[derive(Debug)]
enum Plain<'s> {
    One(Scalar<'s>),
    /// A list with a meaning for each position.
    Tuple(Vec<Scalar<'s>>, Length),
    /// A list of values of one shape.
    List(Scalar<'s>, Length),
}

/// What a value has to be that holds no others.
#[derive(Clone, Copy, Debug)]
enum Scalar<'s> {
    /// An integer from the first to the second.
    Range(i64, i64),
    /// The same, or null.
    Nullable(i64, i64),
    Other(&'s Defined),
}

impl Shapes {
    /// The fields of the objects that a field of a body holds, where it is a map of such.
    pub(crate) fn members(&self, type_name: &str, direction: Direction, map: &str) -> Option<Members<'_>> {
        let body = &self.objects[self.body(type_name, direction)?.object];
        let Defined::Map(inner) = &body.fields[body.field(map, 0)?].shape else { return None };
        let Defined::Object(index) = **inner else { return None };
        let object = &self.objects[index];
        let fields = object.fields.iter().map(|field| {
            let (name, shape) = (&*field.name, &field.shape);
            Member { name, shape, plain: Plain::of(self, shape) }
        });
        Some(Members { object, fields: fields.collect() })
    }
}

impl Members<'_> {
    /// How many fields there are.
    pub(crate) fn len(&self) -> usize {
        self.fields.len()
    }

    /// The name of a field.
    pub(crate) fn name(&self, field: usize) -> &str {
        self.fields[field].name
    }

    /// The field of a name.
    pub(crate) fn field(&self, name: &str) -> Option<usize> {
        self.object.field(name, 0)
    }

    /// Whether the value of a field can be this.
    pub(crate) fn holds(&self, field: usize, token: &Token<'_>) -> bool {
        holds(self.fields[field].shape, token)
    }

    /// Takes the value of a field, if that is plainly one that it can have.
    pub(crate) fn takes(&self, field: usize, tokens: &mut Tokens<'_>) -> Result<(), Unclear> {
        match &self.fields[field].plain {
            Plain::One(scalar) => scalar.takes(tokens),
            Plain::Tuple(elements, length) => list(tokens, *length, |at| elements.get(at)),
            Plain::List(element, length) => list(tokens, *length, |_| Some(element)),
        }
    }
}

impl<'s> Plain<'s> {
    fn of(shapes: &'s Shapes, shape: &'s Defined) -> Self {
        match shape {
            Defined::Tuple(index) => {
                let tuple = &shapes.tuples[*index];
                let elements = tuple.elements.iter().map(|element| Scalar::of(&element.shape));
                Self::Tuple(elements.collect(), tuple.length())
            }
            // Whether values repeat is seen from all of them.
            Defined::List(list) if !list.is_unique => Self::List(Scalar::of(&list.element), list.length),
            shape => Self::One(Scalar::of(shape)),
        }
    }
}

impl<'s> Scalar<'s> {
    fn of(shape: &'s Defined) -> Self {
        match shape {
            Defined::Integer(low, high) => {
                let bound = |bound: &i128| i64::try_from((*bound).clamp(i64::MIN.into(), i64::MAX.into()));
                bound(low)
                    .ok()
                    .zip(bound(high).ok())
                    .map_or(Self::Other(shape), |(low, high)| Self::Range(low, high))
            }
            Defined::Either(all) => match &all[..] {
                [one, Defined::Null] | [Defined::Null, one] => match Self::of(one) {
                    Self::Range(low, high) => Self::Nullable(low, high),
                    _ => Self::Other(shape),
                },
                _ => Self::Other(shape),
            },
            shape => Self::Other(shape),
        }
    }

    #[inline]
    fn takes(&self, tokens: &mut Tokens<'_>) -> Result<(), Unclear> {
        let fits = match self {
            Self::Range(low, high) => tokens.integer().is_some_and(|value| *low <= value && value <= *high),
            Self::Nullable(..) if tokens.takes_null() => true,
            Self::Nullable(low, high) => return Self::Range(*low, *high).takes(tokens),
            Self::Other(shape) => holds(shape, &tokens.token()?),
        };
        if fits { Ok(()) } else { Err(Unclear) }
    }
}

/// Takes a list whose elements have these shapes.
fn list<'s>(
    tokens: &mut Tokens<'_>,
    length: Length,
    shape: impl Fn(usize) -> Option<&'s Scalar<'s>>,
) -> Result<(), Unclear> {
    let mut count = 0;
    tokens.list(|tokens| {
        shape(count).ok_or(Unclear)?.takes(tokens)?;
        count += 1;
        Ok::<(), Unclear>(())
    })?;
    if length.holds(count) { Ok(()) } else { Err(Unclear) }
}

/// Whether a value of this shape can be this.
fn holds(shape: &Defined, token: &Token<'_>) -> bool {
    match (shape, token) {
        (Defined::Any, _) | (Defined::Null, Token::Null) | (Defined::Bool, Token::Bool(_)) => true,
        (Defined::Integer(low, high), Token::Int(value)) => (low..=high).contains(&value),
        (Defined::Integers(all), Token::Int(value)) => all.iter().any(|one| i128::from(*one) == *value),
        #[allow(clippy::cast_precision_loss)] // as bounds are
        (Defined::Number(low, high), Token::Int(value)) => {
            let value = *value as f64;
            low.is_none_or(|low| value >= low) && high.is_none_or(|high| value <= high)
        }
        (Defined::Text(text), Token::Text(value)) => fits(text, value),
        (Defined::Constants(all), Token::Text(value)) => all.iter().any(|constant| constant == value),
        (Defined::Either(all), _) => all.iter().any(|shape| holds(shape, token)),
        _ => false,
    }
}
