//! Which rules a JSON value breaks, from the model alone.

use std::collections::BTreeSet;

use serde_json::Value as Json;

use super::rule;
use crate::emit::json_schema::BASE64;
use crate::pattern::is_match;
use crate::schema::json_type::{Definition, Expression, Limits, Member, Object, Set, SetValues};
use crate::schema::{JsonTypeId, Range, Schema};
use crate::value::Value;

/// Ids of rules.
type Rules = BTreeSet<&'static str>;

/// Judges values by a schema.
pub(super) struct Judge<'s> {
    pub(super) schema: &'s Schema,
}

impl Judge<'_> {
    /// What a value of a type breaks.
    pub(super) fn type_broken(&self, id: JsonTypeId, value: &Json) -> Rules {
        match &self.schema.json_type(id).definition {
            Definition::Object(object) => self.object_broken(object, value),
            Definition::Tuple(elements) => self.tuple_broken(elements, value),
            Definition::Set(set) => set_broken(set, value),
            Definition::Named(typed) => self.broken(&typed.ty, &typed.limits, value),
        }
    }

    /// What an object breaks.
    pub(super) fn object_broken(&self, object: &Object, value: &Json) -> Rules {
        let Some(found) = value.as_object() else { return only(rule::TYPE) };
        let mut rules = Rules::new();
        for field in &object.fields {
            match found.get(&field.name) {
                Some(value) => rules.extend(self.broken(&field.typed.ty, &field.typed.limits, value)),
                None if field.is_required => drop(rules.insert(rule::REQUIRED)),
                None => {}
            }
        }
        let is_known = |name: &String| object.fields.iter().any(|field| field.name == *name);
        if object.is_closed && !found.keys().all(is_known) {
            rules.insert(rule::FURTHER);
        }
        rules
    }

    fn tuple_broken(&self, elements: &[Member], value: &Json) -> Rules {
        let Some(found) = value.as_array() else { return only(rule::TYPE) };
        let least = elements.iter().filter(|element| element.is_required).count();
        let mut rules = Rules::new();
        if found.len() < least || found.len() > elements.len() {
            rules.insert(rule::LENGTH);
        }
        for (element, value) in elements.iter().zip(found) {
            rules.extend(self.broken(&element.typed.ty, &element.typed.limits, value));
        }
        rules
    }

    /// What a value of an expression breaks.
    pub(super) fn broken(&self, expression: &Expression, limits: &Limits, value: &Json) -> Rules {
        match expression {
            Expression::Any => Rules::new(),
            Expression::Null => typed(value.is_null()),
            Expression::Boolean => typed(value.is_boolean()),
            Expression::Integer => numbers_broken(value.is_i64() || value.is_u64(), limits, value),
            Expression::Number => numbers_broken(value.is_number(), limits, value),
            Expression::String => {
                value.as_str().map_or_else(|| only(rule::TYPE), |text| string_broken(limits, text))
            }
            Expression::ErrorCode => typed(value.as_u64().is_some_and(|code| u32::try_from(code).is_ok())),
            Expression::ErrorList => self.list_broken(&Expression::ErrorCode, limits, value),
            Expression::OneOf(constants) => match value.as_str() {
                None => only(rule::TYPE),
                Some(text) if constants.iter().any(|constant| constant == text) => Rules::new(),
                Some(_) => only(rule::VALUE),
            },
            Expression::List(element) => self.list_broken(element, limits, value),
            Expression::Map(inner) => {
                let Some(found) = value.as_object() else { return only(rule::TYPE) };
                let limits = limits.of_elements();
                found.values().flat_map(|value| self.broken(inner, &limits, value)).collect()
            }
            Expression::Named(id) => {
                let mut rules = self.type_broken(*id, value);
                // What holds in this place, where the type itself has said of which kind the value is.
                if let Some(plain) = self.schema.plain(expression).filter(|_| !rules.contains(rule::TYPE)) {
                    rules.extend(self.broken(&plain, limits, value));
                }
                rules
            }
            Expression::Either(alternatives) => self.either_broken(alternatives, limits, value),
        }
    }

    fn list_broken(&self, element: &Expression, limits: &Limits, value: &Json) -> Rules {
        let Some(found) = value.as_array() else { return only(rule::TYPE) };
        let within = limits.of_elements();
        let mut rules: Rules = found.iter().flat_map(|value| self.broken(element, &within, value)).collect();
        if !has_length(limits, found.len()) {
            rules.insert(rule::LENGTH);
        }
        let is_twice = |(index, value): (usize, &Json)| found[..index].contains(value);
        if limits.is_unique && found.iter().enumerate().any(is_twice) {
            rules.insert(rule::UNIQUE);
        }
        rules
    }

    /// Nothing if any alternative takes the value; else what it breaks of the one that it is of the type of.
    fn either_broken(&self, alternatives: &[Expression], limits: &Limits, value: &Json) -> Rules {
        let all: Vec<Rules> = alternatives.iter().map(|inner| self.broken(inner, limits, value)).collect();
        if all.iter().any(Rules::is_empty) {
            return Rules::new();
        }
        let mut of_type = all.into_iter().filter(|rules| !rules.contains(rule::TYPE));
        match (of_type.next(), of_type.next()) {
            (Some(only), None) => only,
            _ => only(rule::TYPE),
        }
    }
}

fn only(rule: &'static str) -> Rules {
    [rule].into()
}

fn typed(is_of_type: bool) -> Rules {
    if is_of_type { Rules::new() } else { only(rule::TYPE) }
}

fn set_broken(set: &Set, value: &Json) -> Rules {
    let (is_of_type, is_known) = match &set.values {
        SetValues::Integers(values) => {
            let found = value.as_i64();
            (value.is_i64() || value.is_u64(), values.iter().any(|known| Some(known.value) == found))
        }
        SetValues::Strings(values) => {
            let found = value.as_str();
            (found.is_some(), values.iter().any(|known| Some(known.value.as_str()) == found))
        }
    };
    match (is_of_type, is_known || set.is_open) {
        (false, _) => only(rule::TYPE),
        (true, true) => Rules::new(),
        (true, false) => only(rule::VALUE),
    }
}

fn numbers_broken(is_of_type: bool, limits: &Limits, value: &Json) -> Rules {
    match &limits.range {
        _ if !is_of_type => only(rule::TYPE),
        Some(range) if !is_in(range, value) => only(rule::RANGE),
        _ => Rules::new(),
    }
}

fn is_in(range: &Range, value: &Json) -> bool {
    let found = match (value.as_i64(), value.as_u64(), value.as_f64()) {
        (Some(value), ..) => Value::Int(value.into()),
        (None, Some(value), _) => Value::Int(value.into()),
        (None, None, value) => Value::Float(value.unwrap_or(f64::NAN)),
    };
    let is_at_most = |left: &Value, right: &Value| match (left, right) {
        (Value::Int(left), Value::Int(right)) => left <= right,
        _ => left.as_f64() <= right.as_f64(),
    };
    range.low.as_ref().is_none_or(|low| is_at_most(low, &found))
        && range.high.as_ref().is_none_or(|high| is_at_most(&found, high))
}

fn string_broken(limits: &Limits, text: &str) -> Rules {
    let mut rules = Rules::new();
    if !has_length(limits, text.chars().count()) {
        rules.insert(rule::LENGTH);
    }
    let has_pattern = limits.pattern.as_ref().is_none_or(|pattern| is_match(pattern, text));
    if !has_pattern || limits.format.is_some() && !is_match(BASE64, text) {
        rules.insert(rule::PATTERN);
    }
    rules
}

fn has_length(limits: &Limits, length: usize) -> bool {
    let length = u32::try_from(length).unwrap_or(u32::MAX);
    limits.least.is_none_or(|least| least <= length) && limits.most.is_none_or(|most| length <= most)
}
