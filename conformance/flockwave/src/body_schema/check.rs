//! Checks a body against its schema.

use std::borrow::Cow;
use std::collections::HashSet;
use std::sync::Arc;

use uavspec_model::json::{Tree, base64, pointer};
use uavspec_schema::json_type::Direction;

use super::bodies::{Body, DefinedSchemas};
use super::defined::{Field, List, Object, Text, Tuple, ValueSchema};
use super::{Deviation, Fault, Mismatch, Step};
use crate::limits::{MAX_COMPARED, MAX_DEVIATIONS, MAX_VISITS};

/// The cost of reporting a deviation, in visits per path step.
const VISITS_PER_DEVIATION: usize = 8;

/// The maximum number of object fields that a message lists.
const MAX_LISTED: usize = 12;

/// The maximum number of undefined fields that a message lists in place of a missing one, and their maximum length in
/// characters.
const MAX_INSTEAD: (usize, usize) = (3, 32);

/// The maximum number of allowed values that a message lists.
const MAX_VALUES: usize = 16;

/// A step of the path to a value.
#[derive(Clone, Copy, Debug)]
pub(super) enum At<'c> {
    /// A defined field.
    Field(&'c Field),
    /// An element of a tuple.
    Element(usize, &'c Field),
    /// A key of a map, or an undefined field.
    Key(&'c str),
    /// An element of a list.
    Index(usize),
}

impl DefinedSchemas {
    /// Up to ten thousand deviations of a body from the schema for its type and direction. `None` if there is no such
    /// schema.
    pub(crate) fn check(
        &self,
        type_name: &str,
        direction: Direction,
        body: &Tree<'_>,
    ) -> Option<Vec<Deviation>> {
        Some(check(self, self.body(type_name, direction)?, body))
    }

    /// The value's first deviation from the schema with this name. `None` if there is no such schema.
    pub fn mismatch(&self, name: &str, value: &Tree<'_>) -> Option<Option<Mismatch>> {
        Some(first(self, self.named.get(name)?, value))
    }
}

/// The deviations of a body from its schema.
fn check<'c>(defined_schemas: &'c DefinedSchemas, body: &'c Body, value: &'c Tree<'c>) -> Vec<Deviation> {
    let mut check = Check {
        defined_schemas,
        body: Some(body),
        path: Vec::new(),
        seen: Vec::new(),
        visits: 0,
        deviations: Vec::new(),
    };
    if let Tree::Object(members) = value {
        check.object(&defined_schemas.objects[body.object], members);
    } else {
        check.is_other("an object".to_owned(), value);
    }
    check.deviations
}

/// The value's first deviation from a schema.
fn first<'c>(
    defined_schemas: &'c DefinedSchemas,
    schema: &'c ValueSchema,
    value: &'c Tree<'c>,
) -> Option<Mismatch> {
    let mut check = Check {
        defined_schemas,
        body: None,
        path: Vec::new(),
        seen: Vec::new(),
        visits: 0,
        deviations: Vec::new(),
    };
    check.value(schema, value);
    check.deviations.into_iter().next().map(|deviation| deviation.mismatch)
}

struct Check<'c> {
    defined_schemas: &'c DefinedSchemas,
    /// The body schema. For values that belong to no defined field, the schema's location is reported.
    body: Option<&'c Body>,
    /// The path from the body to the current value.
    path: Vec<At<'c>>,
    /// One flag per field of each object on the path: true if the field was found. The innermost object is last.
    seen: Vec<bool>,
    visits: usize,
    deviations: Vec<Deviation>,
}

impl<'c> Check<'c> {
    fn is_full(&self) -> bool {
        self.deviations.len() >= MAX_DEVIATIONS || self.visits >= MAX_VISITS
    }

    /// Reports a deviation of the current value.
    fn deviates(&mut self, fault: Fault, expected: String, actual: String) {
        self.visits += self.path.len() * VISITS_PER_DEVIATION;
        let keys = [Cow::Borrowed("body")].into_iter().chain(self.path.iter().map(At::key));
        let keys: Vec<Cow<'_, str>> = keys.collect();
        let fields: Vec<&str> = self.path.iter().filter_map(|at| Some(&*at.field()?.name)).collect();
        let field = self.path.iter().rev().find_map(At::field);
        let span = field.map(|field| field.span).or_else(|| Some(self.body?.span));
        self.deviations.push(Deviation {
            steps: self.path.iter().map(At::name).collect(),
            is_optional: self.path.last().and_then(At::field).is_some_and(|field| !field.is_required),
            fault: Some(fault),
            field: fields.join("."),
            definition: span.filter(|_| !self.defined_schemas.is_foreign),
            mismatch: Mismatch { path: pointer(&keys), expected, actual },
        });
    }

    /// Reports a value of the wrong kind.
    fn is_other(&mut self, expected: String, value: &Tree<'_>) {
        // Tokens that aren't JSON are reported separately.
        if !matches!(value, Tree::Token(_)) {
            let fault = if *value == Tree::Null { Fault::Null } else { Fault::Kind };
            self.deviates(fault, expected, value.to_string());
        }
    }

    /// Checks the value at a step of the path.
    fn step(&mut self, at: At<'c>, schema: &'c ValueSchema, value: &'c Tree<'c>) {
        self.path.push(at);
        self.value(schema, value);
        self.path.pop();
    }

    fn value(&mut self, schema: &'c ValueSchema, value: &'c Tree<'c>) {
        self.visits += 1;
        match (schema, value) {
            (ValueSchema::Any, _) | (ValueSchema::Null, Tree::Null) | (ValueSchema::Bool, Tree::Bool(_)) => {}
            (ValueSchema::Integer(low, high), _) => match value.as_integer() {
                Some(number) if (*low..=*high).contains(&number) => {}
                Some(_) => self.deviates(Fault::Value, self.describe(schema), value.to_string()),
                None => self.is_other(self.describe(schema), value),
            },
            (ValueSchema::Integers(values), _) => match value.as_integer() {
                Some(number) if values.iter().any(|known| i128::from(*known) == number) => {}
                Some(_) => self.deviates(Fault::Value, self.describe(schema), value.to_string()),
                None => self.is_other(self.describe(schema), value),
            },
            (ValueSchema::Number(low, high), Tree::Int(_) | Tree::Float(..) | Tree::Huge(_)) => {
                let number = float(value);
                if low.is_some_and(|low| number < low) || high.is_some_and(|high| number > high) {
                    self.deviates(Fault::Value, self.describe(schema), value.to_string());
                }
            }
            (ValueSchema::Text(schema), Tree::Text(text)) => {
                if !fits(schema, text) {
                    self.deviates(Fault::Value, schema.to_string(), value.to_string());
                }
            }
            (ValueSchema::Constants(constants), Tree::Text(text)) => {
                if !constants.iter().any(|constant| constant == text) {
                    self.deviates(Fault::Value, self.describe(schema), value.to_string());
                }
            }
            (ValueSchema::List(list), Tree::List(values)) => self.list(list, values),
            (ValueSchema::Map(inner), Tree::Object(members)) => {
                let before = self.deviations.len();
                for (key, value) in members {
                    if self.is_full() || self.deviations.len() > before && !inner.is_structured() {
                        break;
                    }
                    self.step(At::Key(key), inner, value);
                }
            }
            (ValueSchema::Either(all), _) => self.either(all, value),
            (ValueSchema::Object(index), Tree::Object(members)) => {
                let defined_schemas = self.defined_schemas;
                self.object(&defined_schemas.objects[*index], members);
            }
            (ValueSchema::Tuple(index), Tree::List(values)) => {
                let defined_schemas = self.defined_schemas;
                self.tuple(&defined_schemas.tuples[*index], values);
            }
            _ => self.is_other(self.describe(schema), value),
        }
    }

    fn object(&mut self, object: &'c Object, members: &'c [(Cow<'c, str>, Tree<'c>)]) {
        let start = self.seen.len();
        self.seen.resize(start + object.fields.len(), false);
        let mut previous = None;
        for (key, value) in members {
            if self.is_full() {
                break;
            }
            match object.field(key, previous) {
                // If a key is repeated, its first value counts.
                Some(index) if self.seen[start + index] => {}
                Some(index) => {
                    self.seen[start + index] = true;
                    previous = Some(index);
                    let field = &object.fields[index];
                    self.step(At::Field(field), &field.schema, value);
                }
                None if object.is_closed => {
                    self.path.push(At::Key(key));
                    self.deviates(Fault::Additional, allowed_fields(object), value.to_string());
                    self.path.pop();
                }
                None => {}
            }
        }
        for (index, field) in object.fields.iter().enumerate() {
            if field.is_required && !self.seen[start + index] && !self.is_full() {
                self.path.push(At::Field(field));
                self.deviates(Fault::Absent, self.describe(&field.schema), nothing_but(object, members));
                self.path.pop();
            }
        }
        self.seen.truncate(start);
    }

    fn list(&mut self, list: &'c List, values: &'c [Tree<'c>]) {
        let before = self.deviations.len();
        for (at, value) in values.iter().enumerate() {
            if self.is_full() || self.deviations.len() > before && !list.element.is_structured() {
                break;
            }
            self.step(At::Index(at), &list.element, value);
        }
        if !list.length.accepts(values.len()) {
            self.deviates(Fault::Value, list.to_string(), format!("{} elements", values.len()));
        } else if list.is_unique
            && let Some(repeated) = repeated(values)
        {
            self.deviates(Fault::Value, list.to_string(), format!("{repeated} twice"));
        }
    }

    fn tuple(&mut self, tuple: &'c Tuple, values: &'c [Tree<'c>]) {
        if !tuple.length().accepts(values.len()) {
            return self.deviates(Fault::Value, tuple.to_string(), format!("{} elements", values.len()));
        }
        let before = self.deviations.len();
        for (at, (element, value)) in tuple.elements.iter().zip(values).enumerate() {
            self.step(At::Element(at, element), &element.schema, value);
            if let Some(deviation) = self.deviations.get_mut(before) {
                let expected = &mut deviation.mismatch.expected;
                *expected = format!("{expected} ({})", element.name);
                break;
            }
        }
    }

    /// Reports a value that matches no alternative. If exactly one alternative has the value's kind, the deviations
    /// from that alternative are reported.
    fn either(&mut self, all: &'c [ValueSchema], value: &'c Tree<'c>) {
        let start = self.deviations.len();
        let mut of_kind: Vec<Vec<Deviation>> = Vec::new();
        for schema in all {
            self.value(schema, value);
            let found = self.deviations.split_off(start);
            if found.is_empty() {
                return;
            }
            if is_of_kind(schema, value) {
                of_kind.push(found);
            }
        }
        let expected = || all.iter().map(|schema| self.describe(schema)).collect::<Vec<_>>().join(", or ");
        match (of_kind.pop(), of_kind.is_empty()) {
            (Some(found), true) => self.deviations.extend(found),
            (Some(_), false) => self.deviates(Fault::Value, expected(), value.to_string()),
            (None, _) => self.is_other(expected(), value),
        }
    }

    /// The description of a schema.
    fn describe(&self, schema: &ValueSchema) -> String {
        match schema {
            ValueSchema::Any => "anything".to_owned(),
            ValueSchema::Null => "null".to_owned(),
            ValueSchema::Bool => "true or false".to_owned(),
            ValueSchema::Integer(low, high) => super::ExpectedValue::Integer(*low, *high).to_string(),
            ValueSchema::Number(None, None) => "a number".to_owned(),
            ValueSchema::Number(Some(low), None) => format!("a number of at least {low}"),
            ValueSchema::Number(None, Some(high)) => format!("a number of at most {high}"),
            ValueSchema::Number(Some(low), Some(high)) => format!("a number from {low} to {high}"),
            ValueSchema::Text(text) => text.to_string(),
            ValueSchema::Constants(all) => one_of(all.iter().map(|one| format!("`{one}`"))),
            ValueSchema::Integers(all) => one_of(all.iter().map(ToString::to_string)),
            ValueSchema::List(list) => list.to_string(),
            ValueSchema::Map(inner) => match &**inner {
                ValueSchema::Any => "an object".to_owned(),
                inner => format!("an object where each value is {}", self.describe(inner)),
            },
            ValueSchema::Either(all) => {
                all.iter().map(|one| self.describe(one)).collect::<Vec<_>>().join(", or ")
            }
            ValueSchema::Object(index) => {
                format!("an object of type {}", self.defined_schemas.objects[*index].name)
            }
            ValueSchema::Tuple(index) => self.defined_schemas.tuples[*index].to_string(),
        }
    }
}

impl<'c> At<'c> {
    /// The defined field or tuple element. `None` for map keys, undefined fields and list elements.
    pub(super) fn field(&self) -> Option<&'c Field> {
        match self {
            Self::Field(field) | Self::Element(_, field) => Some(field),
            Self::Key(_) | Self::Index(_) => None,
        }
    }

    fn name(&self) -> Step {
        match self {
            Self::Field(field) => Step::Field(Arc::clone(&field.name)),
            Self::Element(..) | Self::Key(_) | Self::Index(_) => Step::Other,
        }
    }

    fn key(&self) -> Cow<'c, str> {
        match self {
            Self::Field(field) => Cow::Borrowed(&field.name),
            Self::Key(key) => Cow::Borrowed(key),
            Self::Element(index, _) | Self::Index(index) => Cow::Owned(index.to_string()),
        }
    }
}

/// A description of the allowed values.
fn one_of(values: impl ExactSizeIterator<Item = String>) -> String {
    let count = values.len();
    let reported = values.take(MAX_VALUES).collect::<Vec<_>>().join(", ");
    match count {
        1 => reported,
        ..=MAX_VALUES => format!("one of {reported}"),
        _ => format!("one of {reported} and {} more", count - MAX_VALUES),
    }
}

/// A description of the allowed fields.
fn allowed_fields(object: &Object) -> String {
    let names = object.fields.iter().map(|field| format!("`{}`", field.name));
    let names = names.take(MAX_LISTED).collect::<Vec<_>>().join(", ");
    let more = if object.fields.len() > MAX_LISTED { " and other defined fields" } else { "" };
    format!("only the fields {names}{more}")
}

/// True if a string matches a schema.
pub(super) fn fits(schema: &Text, text: &str) -> bool {
    let is_any = schema.length == super::defined::Length::ANY;
    (is_any || schema.length.accepts(text.chars().count()))
        && schema.patterns.iter().all(|pattern| pattern.is_match(text))
        && (!schema.is_base64 || base64::decode(text).is_some())
}

/// A number as a float. A number beyond the range of a float becomes infinity.
fn float(value: &Tree<'_>) -> f64 {
    match value {
        #[allow(clippy::cast_precision_loss)] // bounds are rounded in the same way
        Tree::Int(value) => *value as f64,
        Tree::Float(value, _) => *value,
        Tree::Huge(text) if text.starts_with('-') => f64::NEG_INFINITY,
        _ => f64::INFINITY,
    }
}

/// True if a value has the JSON type of a schema.
fn is_of_kind(schema: &ValueSchema, value: &Tree<'_>) -> bool {
    match schema {
        ValueSchema::Any => true,
        ValueSchema::Null => *value == Tree::Null,
        ValueSchema::Bool => matches!(value, Tree::Bool(_)),
        ValueSchema::Integer(..) | ValueSchema::Integers(_) | ValueSchema::Number(..) => {
            matches!(value, Tree::Int(_) | Tree::Float(..) | Tree::Huge(_))
        }
        ValueSchema::Text(_) | ValueSchema::Constants(_) => matches!(value, Tree::Text(_)),
        ValueSchema::List(_) | ValueSchema::Tuple(_) => matches!(value, Tree::List(_)),
        ValueSchema::Map(_) | ValueSchema::Object(_) => matches!(value, Tree::Object(_)),
        ValueSchema::Either(all) => all.iter().any(|one| is_of_kind(one, value)),
    }
}

/// The first repeated element of a list. Strings and integers are compared by value, and other values by their text.
/// Two objects that differ only in key order therefore count as different.
fn repeated<'v>(values: &'v [Tree<'_>]) -> Option<&'v Tree<'v>> {
    let (mut texts, mut integers, mut others) = (HashSet::new(), HashSet::new(), HashSet::new());
    values.iter().find(|value| match (value, value.as_integer()) {
        (Tree::Text(text), _) => !texts.insert(text.as_ref()),
        (_, Some(number)) => !integers.insert(number),
        (other, None) => others.len() < MAX_COMPARED && !others.insert(format!("{other:?}")),
    })
}

/// Describes the absence of a field, and lists the object's undefined fields, one of which may have been sent in its
/// place.
fn nothing_but(object: &Object, members: &[(Cow<'_, str>, Tree<'_>)]) -> String {
    let keys = members.iter().map(|(key, _)| key.as_ref());
    let undefined =
        keys.filter(|key| object.field(key, None).is_none() && key.chars().count() <= MAX_INSTEAD.1);
    let listed: Vec<String> = undefined.take(MAX_INSTEAD.0).map(|key| format!("`{key}`")).collect();
    match listed.len() {
        0 => "nothing".to_owned(),
        1 => format!("nothing, but the undefined field {}", listed[0]),
        _ => format!("nothing, but the undefined fields {}", listed.join(", ")),
    }
}
