//! The values of the fields of a converted message.

use std::collections::BTreeMap;

use proc_macro2::{Ident, Literal, TokenStream};
use quote::quote;
use uavspec_dynamic::conversion::{Conversion, Copy, Elements, Expression, Narrowing, Neutral, Step};
use uavspec_runtime::Scalar;
use uavspec_schema::value::Value;
use uavspec_schema::{Element, Field, Message, Shape};

use super::expression::Source;
use super::way::Way;
use crate::rust::message::field_names;
use crate::rust::types;

pub(super) struct Fields<'f> {
    pub(super) way: &'f Way<'f>,
    pub(super) conversion: &'f Conversion,
}

/// A value of the source: a place expression, or a reference to the value.
enum Origin {
    Place(TokenStream),
    Reference(TokenStream),
}

impl Fields<'_> {
    fn source(&self) -> &Message {
        self.way.context.schema.message(self.conversion.from)
    }

    fn target(&self) -> &Message {
        self.way.context.schema.message(self.conversion.to)
    }

    /// The initializers of all fields.
    pub(super) fn values(&self) -> Vec<TokenStream> {
        let names = field_names(self.target());
        let sources = field_names(self.source());
        let steps = self.target().fields.iter().zip(&self.conversion.steps).zip(&names);
        steps
            .map(|((field, step), name)| {
                let value = match step {
                    Step::Fill(neutral) => self.filled(field, name, *neutral),
                    Step::Compute(expression) => self.computed(field, expression, &sources),
                    Step::Copy(copy) => {
                        let origin = &sources[copy.source];
                        let source = &self.source().fields[copy.source];
                        Copied { fields: self, source, target: field, name, copy }
                            .value(&quote!(from.#origin))
                    }
                };
                quote!(#name: #value)
            })
            .collect()
    }

    /// Converts a number to the element type of a field.
    fn wrapped(&self, field: &Field, number: TokenStream) -> TokenStream {
        let Some(reference) = field.enumeration else { return number };
        let path = self.way.enumeration(reference, 1);
        quote!(#path(#number))
    }

    /// The value of a field that contains `element` in each element.
    fn spread(field: &Field, element: TokenStream) -> TokenStream {
        match field.ty.shape {
            Shape::Single => element,
            Shape::Array(length) => {
                let length = Literal::u32_unsuffixed(length);
                quote!([#element; #length])
            }
            Shape::Bounded(_) | Shape::Sequence => quote!(::core::default::Default::default()),
        }
    }

    fn filled(&self, field: &Field, name: &Ident, neutral: Neutral) -> TokenStream {
        match neutral {
            Neutral::Default if field.default.is_some() => {
                let path = self.way.path(self.conversion.to, 1);
                quote!(#path::default().#name)
            }
            Neutral::Default => quote!(::uavspec_runtime::record::Value::initial()),
            Neutral::Int(_) | Neutral::Float(_) => Self::spread(field, self.neutral(field, neutral)),
        }
    }

    /// The neutral value of an element.
    fn neutral(&self, field: &Field, neutral: Neutral) -> TokenStream {
        match neutral {
            Neutral::Default => quote!(::core::default::Default::default()),
            Neutral::Int(value) => {
                self.wrapped(field, types::literal(field.ty.element, &Value::Int(clamped(field, value))))
            }
            Neutral::Float(value) => types::literal(field.ty.element, &Value::Float(value)),
        }
    }

    fn computed(&self, field: &Field, expression: &Expression, names: &[Ident]) -> TokenStream {
        let source = Source { fields: &self.source().fields, names };
        let Element::Scalar(scalar) = field.ty.element else { return source.value(expression) };
        let element = match (expression, scalar.integer_bounds()) {
            (Expression::Float(value), _) => types::literal(field.ty.element, &Value::Float(*value)),
            (Expression::Int(value), Some(_)) => types::integer(clamped(field, *value)),
            (_, Some((low, high))) => {
                let (low, high, ty) = (types::integer(low), types::integer(high), types::primitive(scalar));
                let value = source.value(expression);
                quote!(i128::clamp(#value, #low, #high) as #ty)
            }
            (_, None) if scalar == Scalar::Float32 => {
                let value = source.operand(expression);
                quote!(#value as f32)
            }
            (_, None) => source.value(expression),
        };
        Self::spread(field, self.wrapped(field, element))
    }
}

/// An integer in the range of a field's type.
fn clamped(field: &Field, value: i128) -> i128 {
    let Element::Scalar(scalar) = field.ty.element else { return value };
    scalar.integer_bounds().map_or(value, |(low, high)| value.clamp(low, high))
}

/// A copied field.
struct Copied<'c> {
    fields: &'c Fields<'c>,
    source: &'c Field,
    target: &'c Field,
    name: &'c Ident,
    copy: &'c Copy,
}

impl Copied<'_> {
    fn value(&self, place: &TokenStream) -> TokenStream {
        let (before, after) = (self.source.ty.shape, self.target.ty.shape);
        if matches!(self.copy.elements, Elements::Text) {
            return if self.source.ty == self.target.ty { quote!(#place) } else { quote!(#place.resized()) };
        }
        if after == Shape::Single {
            return self.element(&Origin::Place(place.clone()));
        }
        if before == after && self.is_plain() {
            let is_copied = matches!((after, &self.copy.elements), (Shape::Array(_), Elements::Same));
            return if is_copied { quote!(#place) } else { quote!(#place.clone()) };
        }
        match (before, after) {
            (Shape::Array(length), Shape::Array(room)) if room <= length => {
                let element = self.element(&Origin::Place(quote!(#place[at])));
                quote!(::core::array::from_fn(|at| #element))
            }
            (_, Shape::Array(_)) => {
                let (element, rest) = (self.element(&Origin::Reference(quote!(value))), self.rest());
                quote! {
                    ::core::array::from_fn(|at| match #place.get(at) {
                        ::core::option::Option::Some(value) => #element,
                        ::core::option::Option::None => #rest,
                    })
                }
            }
            _ => {
                let take = after.bound().filter(|room| before.bound().is_none_or(|length| length > *room));
                let take = take.map(|room| {
                    let room = Literal::u32_unsuffixed(room);
                    quote!(.take(#room))
                });
                if take.is_none() && self.is_plain() {
                    let is_array = matches!(before, Shape::Array(_));
                    return if is_array { quote!(#place.to_vec()) } else { quote!(#place.clone()) };
                }
                let each = self.each();
                quote!(#place.iter()#take #each.collect())
            }
        }
    }

    /// The call that converts the elements of an iterator.
    fn each(&self) -> TokenStream {
        match &self.copy.elements {
            Elements::Same if self.is_plain() => quote!(.copied()),
            Elements::String(_) | Elements::Message(_) if self.is_plain() => quote!(.cloned()),
            Elements::Message(_) => quote!(.map(::core::convert::Into::into)),
            _ => {
                let element = self.element(&Origin::Reference(quote!(value)));
                quote!(.map(|value| #element))
            }
        }
    }

    /// True if the elements of both fields have the same Rust type and values.
    fn is_plain(&self) -> bool {
        match &self.copy.elements {
            Elements::Same => self.source.enumeration.is_none() && self.target.enumeration.is_none(),
            Elements::String(_) => !self.cuts_strings(),
            Elements::Message(nested) => nested.from == nested.to,
            _ => false,
        }
    }

    fn cuts_strings(&self) -> bool {
        let bound = |field: &Field| match field.ty.element {
            Element::String { bound, .. } => bound.unwrap_or(u32::MAX),
            Element::Scalar(_) | Element::Text(_) | Element::Message(_) => u32::MAX,
        };
        bound(self.source) > bound(self.target)
    }

    /// The value of an element that the source lacks.
    fn rest(&self) -> TokenStream {
        if self.target.default.is_some() && self.copy.rest == Neutral::Default {
            let (path, name) = (self.fields.way.path(self.fields.conversion.to, 1), self.name);
            let clone = (!matches!(self.target.ty.element, Element::Scalar(_))).then(|| quote!(.clone()));
            return quote!(#path::default().#name[at] #clone);
        }
        self.fields.neutral(self.target, self.copy.rest)
    }

    fn element(&self, origin: &Origin) -> TokenStream {
        match (&self.copy.elements, origin) {
            (Elements::Message(nested), Origin::Place(value)) if nested.from == nested.to => {
                quote!(#value.clone())
            }
            (Elements::Message(nested), Origin::Reference(value)) if nested.from == nested.to => {
                quote!(#value.clone())
            }
            (Elements::Message(_), Origin::Place(value)) => quote!((&#value).into()),
            (Elements::Message(_), Origin::Reference(value)) => quote!(#value.into()),
            (Elements::String(bound), Origin::Place(value) | Origin::Reference(value)) => match bound {
                Some(bound) if self.cuts_strings() => {
                    let bound = Literal::u32_unsuffixed(*bound);
                    quote!(#value.chars().take(#bound).collect())
                }
                _ => quote!(#value.clone()),
            },
            (_, origin) => {
                let number = self.number(&self.raw(origin));
                self.fields.wrapped(self.target, number)
            }
        }
    }

    /// The source value as a number.
    fn raw(&self, origin: &Origin) -> TokenStream {
        match (self.source.enumeration, origin) {
            (Some(_), Origin::Place(value) | Origin::Reference(value)) => quote!(#value.0),
            (None, Origin::Place(value)) => quote!(#value),
            (None, Origin::Reference(value)) => quote!(*#value),
        }
    }

    /// The converted number. The special values of a count are not limited.
    fn number(&self, raw: &TokenStream) -> TokenStream {
        let mut special: BTreeMap<i128, Vec<TokenStream>> = BTreeMap::new();
        for (from, to) in self.copy.limit.iter().flat_map(|limit| &limit.special) {
            special.entry(clamped(self.target, *to)).or_default().push(types::integer(*from));
        }
        let arms: Vec<_> = special
            .into_iter()
            .map(|(to, from)| {
                let to = types::integer(to);
                quote!(#(#from)|* => #to,)
            })
            .collect();
        if arms.is_empty() {
            return self.limited(raw.clone());
        }
        let count = self.limited(quote!(count));
        quote!(match #raw { #(#arms)* count => #count })
    }

    /// The converted number, limited if it is a count.
    fn limited(&self, raw: TokenStream) -> TokenStream {
        let (Element::Scalar(from), Element::Scalar(to)) = (self.source.ty.element, self.target.ty.element)
        else {
            return raw;
        };
        let ty = types::primitive(to);
        let max = self.copy.limit.as_ref().map(|limit| limit.max);
        let number = match &self.copy.elements {
            Elements::Widen => quote!(#ty::from(#raw)),
            Elements::Narrow(Narrowing::Neutral) => {
                let neutral = match self.copy.rest {
                    Neutral::Int(value) => types::integer(clamped(self.target, value)),
                    Neutral::Default | Neutral::Float(_) => types::integer(0),
                };
                let Some(max) = max else {
                    return quote!(#ty::try_from(#raw).unwrap_or(#neutral));
                };
                // Limit only the number. The neutral value may exceed the length of an array that was cut.
                let max = types::integer(clamped(self.target, max.into()));
                return quote!(#ty::try_from(#raw).map_or(#neutral, |number| number.min(#max)));
            }
            Elements::Narrow(Narrowing::Nearest) => {
                let Some((low, high)) = to.integer_bounds() else { return quote!(#raw as #ty) };
                // A count is limited to the length of the array that was cut.
                let high = max.map_or(high, |max| high.min(max.into()));
                let (low, high) = (types::integer(low), types::integer(high));
                return quote!(i128::from(#raw).clamp(#low, #high) as #ty);
            }
            Elements::Values(pairs) if max.is_none() => return self.values(&raw, pairs, (from, to)),
            // Only cast the number, because the limit of a count also converts the named values.
            Elements::Values(_) => cast(&raw, from, to),
            Elements::Flags(pairs) => return self.flags(&raw, pairs, (from, to)),
            _ => raw,
        };
        match max {
            Some(max) => {
                let max = types::integer(clamped(self.target, max.into()));
                quote!(#number.min(#max))
            }
            None => number,
        }
    }

    /// The pairs with valid source values. Target values are limited to the range of the target type.
    fn pairs(&self, pairs: &[(i128, i128)], from: Scalar) -> Vec<(i128, i128)> {
        let (low, high) = from.integer_bounds().unwrap_or((0, 0));
        let fitting = pairs.iter().filter(|(from, _)| (low..=high).contains(from));
        fitting.map(|(from, to)| (*from, clamped(self.target, *to))).collect()
    }

    fn values(&self, raw: &TokenStream, pairs: &[(i128, i128)], (from, to): (Scalar, Scalar)) -> TokenStream {
        let pairs = self.pairs(pairs, from);
        let arms = pairs.iter().filter(|(from, to)| from != to).map(|(from, to)| {
            let (from, to) = (types::integer(*from), types::integer(*to));
            quote!(#from => #to,)
        });
        let other = cast(&quote!(other), from, to);
        quote!(match #raw { #(#arms)* other => #other })
    }

    fn flags(&self, raw: &TokenStream, pairs: &[(i128, i128)], (from, to): (Scalar, Scalar)) -> TokenStream {
        let pairs: Vec<_> = self.pairs(pairs, from).into_iter().filter(|(mask, _)| *mask != 0).collect();
        let moved = types::integer(pairs.iter().fold(0, |all, (mask, _)| all | mask));
        let rest = cast(&quote!(from & !#moved), from, to);
        let bits = pairs.iter().map(|(mask, flag)| {
            let (mask, flag) = (types::integer(*mask), types::integer(*flag));
            quote!(if from & #mask == #mask { converted |= #flag; })
        });
        quote!({ let from = #raw; let mut converted = #rest; #(#bits)* converted })
    }
}

/// Converts an integer to a type that has all of its values.
fn cast(value: &TokenStream, from: Scalar, to: Scalar) -> TokenStream {
    let ty = types::primitive(to);
    if types::primitive(from).to_string() == ty.to_string() {
        value.clone()
    } else {
        quote!(#ty::from(#value))
    }
}
