//! Cases of the types and messages defined on pages.
//!
//! `candidate` creates values and `judge` finds the rules that they violate. A candidate that violates several rules is
//! dropped, because an implementation could report any of them.

mod candidate;
mod judge;
mod rule;
mod typical;

use std::collections::BTreeSet;

use serde_json::{Map, Value as Json};
use uavspec_schema::json_type::{Definition, Expression, Limits, Member, Object, SetValues};
use uavspec_schema::{JsonTypeId, Schema};

use self::candidate::{Candidate, candidate};
use self::judge::Judge;
use self::typical::Typical;
use super::case::Case;

/// Maximum estimated size, in bytes, of the cases for one object. Larger objects have no cases for single fields.
const MAX_BYTES: usize = 16 << 20;

/// Approximate number of cases per field.
const CASES_OF_FIELD: usize = 16;

/// Name of an undefined field.
const FURTHER_FIELD: &str = "no_such_field";

/// Cases of a type.
pub(super) fn of_type(schema: &Schema, id: JsonTypeId) -> Vec<Case> {
    let mut writer = Writer::new(schema);
    match &schema.json_type(id).definition {
        Definition::Object(object) => writer.object(object),
        Definition::Tuple(elements) => writer.tuple(elements),
        Definition::Set(set) => {
            match &set.values {
                SetValues::Integers(values) => values.iter().for_each(|found| {
                    writer.push(candidate(
                        format!("value-{}", found.value),
                        "a listed value",
                        found.value.into(),
                    ));
                }),
                SetValues::Strings(values) => values.iter().for_each(|found| {
                    let value = Json::from(found.value.as_str());
                    writer.push(candidate(format!("value-{}", found.value), "a listed value", value));
                }),
            }
            writer.push_all(candidate::unlisted(set));
            writer.push_all(candidate::kinds());
        }
        Definition::Named(typed) => {
            writer.typical(&typed.ty, &typed.limits);
            let candidates = candidate::of(schema, &typed.ty, &typed.limits);
            writer.push_all(candidates);
        }
    }
    writer.finish(|judge, value| judge.type_violations(id, value))
}

/// Test cases for a message body that is sent in one direction.
pub(super) fn of_object(schema: &Schema, object: &Object) -> Vec<Case> {
    let mut writer = Writer::new(schema);
    writer.object(object);
    writer.finish(|judge, value| judge.object_violations(object, value))
}

struct Writer<'s> {
    schema: &'s Schema,
    candidates: Vec<Candidate>,
}

impl<'s> Writer<'s> {
    fn new(schema: &'s Schema) -> Self {
        Self { schema, candidates: Vec::new() }
    }

    fn push(&mut self, candidate: Candidate) {
        self.candidates.push(candidate);
    }

    fn push_all(&mut self, candidates: Vec<Candidate>) {
        self.candidates.extend(candidates);
    }

    fn typical(&mut self, expression: &Expression, limits: &Limits) {
        if let Some(value) = Typical::new(self.schema).value(expression, limits) {
            self.push(candidate("typical", "a typical value", value));
        }
    }

    fn object(&mut self, object: &Object) {
        let mut typical = Typical::new(self.schema);
        let (Some(minimal), Some(full)) =
            (typical.object(object, false), Typical::new(self.schema).object(object, true))
        else {
            return;
        };
        self.push(candidate("typical", "all fields", Json::Object(full.clone())));
        self.push(candidate("minimal", "only required fields", Json::Object(minimal)));
        let bytes = Json::Object(full.clone()).to_string().len().saturating_mul(CASES_OF_FIELD);
        if bytes.saturating_mul(object.fields.len()) <= MAX_BYTES {
            object.fields.iter().for_each(|field| self.field(field, &full));
        }
        let mut further = full;
        further.insert(FURTHER_FIELD.to_owned(), Json::from(0));
        self.push(candidate("further-field", "an additional field", Json::Object(further)));
        self.push_all(candidate::kinds());
    }

    fn field(&mut self, field: &Member, full: &Map<String, Json>) {
        let name = &field.name;
        let mut without = full.clone();
        // Preserves the order of the other fields.
        if without.shift_remove(name).is_some() {
            let words = format!("without `{name}`");
            self.push(candidate(format!("{name}-absent"), words, Json::Object(without)));
        }
        for found in candidate::of(self.schema, &field.typed.ty, &field.typed.limits) {
            let mut with = full.clone();
            with.insert(name.clone(), found.value);
            let words = format!("`{name}` is {}", found.words);
            self.push(candidate(format!("{name}-{}", found.name), words, Json::Object(with)));
        }
    }

    fn tuple(&mut self, elements: &[Member]) {
        let mut typical = Typical::new(self.schema);
        let full: Option<Vec<Json>> =
            elements.iter().map(|element| typical.value(&element.typed.ty, &element.typed.limits)).collect();
        let Some(full) = full else { return };
        for length in 0..=full.len() {
            let words = format!("the first {length} of {} elements", full.len());
            self.push(candidate(format!("length-{length}"), words, Json::from(&full[..length])));
        }
        let longer: Vec<Json> = full.iter().cloned().chain([Json::from(0)]).collect();
        self.push(candidate("too-long", "one element too many", Json::from(longer)));
        for (index, element) in elements.iter().enumerate() {
            for found in candidate::of(self.schema, &element.typed.ty, &element.typed.limits) {
                let mut with = full.clone();
                with[index] = found.value;
                let words = format!("`{}` is {}", element.name, found.words);
                self.push(candidate(format!("{}-{}", element.name, found.name), words, Json::from(with)));
            }
        }
        self.push_all(candidate::kinds());
    }

    /// Cases for the candidates that violate at most one rule. Duplicate ids and values are dropped.
    fn finish(self, violations: impl Fn(&Judge<'_>, &Json) -> BTreeSet<&'static str>) -> Vec<Case> {
        let judge = Judge { schema: self.schema };
        let mut ids = BTreeSet::new();
        let mut values = BTreeSet::new();
        let mut cases = Vec::with_capacity(self.candidates.len());
        for Candidate { name, words, value } in self.candidates {
            let rules = violations(&judge, &value);
            let json = value.to_string();
            if rules.len() > 1 || !values.insert(json.clone()) || !ids.insert(name.clone()) {
                continue;
            }
            let rule = rules.first().copied();
            cases.push(Case {
                id: name,
                description: words,
                rule,
                json: Some(json),
                schema_verdict: Some(rule.is_none()),
                ..Case::default()
            });
        }
        cases
    }
}
