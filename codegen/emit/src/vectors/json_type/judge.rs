//! Finds the rules that a JSON value violates, using only the schema.

use std::collections::BTreeSet;

use serde_json::Value as Json;
use uavspec_schema::json_type::{Definition, Expression, Limits, Member, Object, Set, SetValues};
use uavspec_schema::pattern::is_match;
use uavspec_schema::value::Value;
use uavspec_schema::{JsonTypeId, Range, Schema};

use super::rule;
use crate::json_schema::BASE64;

/// Ids of rules.
type Rules = BTreeSet<&'static str>;

/// Checks values against a schema.
pub(super) struct Judge<'s> {
    pub(super) schema: &'s Schema,
}

impl Judge<'_> {
    /// The rules that a value of a type violates.
    pub(super) fn type_violations(&self, id: JsonTypeId, value: &Json) -> Rules {
        match &self.schema.json_type(id).definition {
            Definition::Object(object) => self.object_violations(object, value),
            Definition::Tuple(elements) => self.tuple_violations(elements, value),
            Definition::Set(set) => set_violations(set, value),
            Definition::Named(typed) => self.violations(&typed.ty, &typed.limits, value),
        }
    }

    /// The rules that an object violates.
    pub(super) fn object_violations(&self, object: &Object, value: &Json) -> Rules {
        let Some(found) = value.as_object() else { return only(rule::TYPE) };
        let mut rules = Rules::new();
        for field in &object.fields {
            match found.get(&field.name) {
                Some(value) => rules.extend(self.violations(&field.typed.ty, &field.typed.limits, value)),
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

    fn tuple_violations(&self, elements: &[Member], value: &Json) -> Rules {
        let Some(found) = value.as_array() else { return only(rule::TYPE) };
        let min = elements.iter().filter(|element| element.is_required).count();
        let mut rules = Rules::new();
        if found.len() < min || found.len() > elements.len() {
            rules.insert(rule::LENGTH);
        }
        for (element, value) in elements.iter().zip(found) {
            rules.extend(self.violations(&element.typed.ty, &element.typed.limits, value));
        }
        rules
    }

    /// The rules that a value of an expression violates.
    pub(super) fn violations(&self, expression: &Expression, limits: &Limits, value: &Json) -> Rules {
        match expression {
            Expression::Any => Rules::new(),
            Expression::Null => typed(value.is_null()),
            Expression::Boolean => typed(value.is_boolean()),
            Expression::Integer => number_violations(value.is_i64() || value.is_u64(), limits, value),
            Expression::Number => number_violations(value.is_number(), limits, value),
            Expression::String => {
                value.as_str().map_or_else(|| only(rule::TYPE), |text| string_violations(limits, text))
            }
            Expression::ErrorCode => typed(value.as_u64().is_some_and(|code| u32::try_from(code).is_ok())),
            Expression::ErrorList => self.list_violations(&Expression::ErrorCode, limits, value),
            Expression::OneOf(constants) => match value.as_str() {
                None => only(rule::TYPE),
                Some(text) if constants.iter().any(|constant| constant == text) => Rules::new(),
                Some(_) => only(rule::VALUE),
            },
            Expression::List(element) => self.list_violations(element, limits, value),
            Expression::Map(inner) => {
                let Some(found) = value.as_object() else { return only(rule::TYPE) };
                let limits = limits.of_elements();
                found.values().flat_map(|value| self.violations(inner, &limits, value)).collect()
            }
            Expression::Named(id) => {
                let mut rules = self.type_violations(*id, value);
                // The restrictions added where the type is used apply only if the value has the right type.
                if let Some(plain) = self.schema.plain(expression).filter(|_| !rules.contains(rule::TYPE)) {
                    rules.extend(self.violations(&plain, limits, value));
                }
                rules
            }
            Expression::Either(alternatives) => self.either_violations(alternatives, limits, value),
        }
    }

    fn list_violations(&self, element: &Expression, limits: &Limits, value: &Json) -> Rules {
        let Some(found) = value.as_array() else { return only(rule::TYPE) };
        let within = limits.of_elements();
        let mut rules: Rules =
            found.iter().flat_map(|value| self.violations(element, &within, value)).collect();
        if !has_length(limits, found.len()) {
            rules.insert(rule::LENGTH);
        }
        let is_duplicate = |(index, value): (usize, &Json)| found[..index].contains(value);
        if limits.is_unique && found.iter().enumerate().any(is_duplicate) {
            rules.insert(rule::UNIQUE);
        }
        rules
    }

    /// The rules that a value violates if several alternatives are allowed. Empty if any alternative accepts the value.
    /// If exactly one alternative has the value's JSON type, the result contains the rules of that alternative that the
    /// value violates. Otherwise, the type rule is the only violated rule.
    fn either_violations(&self, alternatives: &[Expression], limits: &Limits, value: &Json) -> Rules {
        let all: Vec<Rules> =
            alternatives.iter().map(|inner| self.violations(inner, limits, value)).collect();
        if all.iter().any(Rules::is_empty) {
            return Rules::new();
        }
        let mut with_type = all.into_iter().filter(|rules| !rules.contains(rule::TYPE));
        match (with_type.next(), with_type.next()) {
            (Some(only), None) => only,
            _ => only(rule::TYPE),
        }
    }
}

fn only(rule: &'static str) -> Rules {
    [rule].into()
}

fn typed(has_type: bool) -> Rules {
    if has_type { Rules::new() } else { only(rule::TYPE) }
}

fn set_violations(set: &Set, value: &Json) -> Rules {
    let (has_type, is_known) = match &set.values {
        SetValues::Integers(values) => {
            let found = value.as_i64();
            (value.is_i64() || value.is_u64(), values.iter().any(|known| Some(known.value) == found))
        }
        SetValues::Strings(values) => {
            let found = value.as_str();
            (found.is_some(), values.iter().any(|known| Some(known.value.as_str()) == found))
        }
    };
    match (has_type, is_known || set.is_open) {
        (false, _) => only(rule::TYPE),
        (true, true) => Rules::new(),
        (true, false) => only(rule::VALUE),
    }
}

fn number_violations(has_type: bool, limits: &Limits, value: &Json) -> Rules {
    match &limits.range {
        _ if !has_type => only(rule::TYPE),
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

fn string_violations(limits: &Limits, text: &str) -> Rules {
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
    limits.min.is_none_or(|min| min <= length) && limits.max.is_none_or(|max| length <= max)
}
