//! Candidate values: values at a bound, values just beyond it, and values of other types.

use serde_json::{Map, Value as Json};
use uavspec_schema::json_type::{Expression, Limits, Set, SetValues};
use uavspec_schema::value::Value;
use uavspec_schema::{Range, Schema};

use super::typical::Typical;
use crate::vectors::number::EXACT_WITHIN;

/// Maximum length of strings and lists in cases.
const MAX_LENGTH: u32 = 4_096;

/// Texts chosen so that most patterns reject at least one of them.
const TEXTS: [&str; 6] = ["", " ", "a", "A", "/", "é!"];

/// A candidate value.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    /// Suffix of the case id, unique within the field.
    pub(super) name: String,
    /// Description.
    pub(super) words: String,
    pub(super) value: Json,
}

pub(super) fn candidate(name: impl Into<String>, words: impl Into<String>, value: Json) -> Candidate {
    Candidate { name: name.into(), words: words.into(), value }
}

/// A value of each JSON type.
pub(super) fn kinds() -> Vec<Candidate> {
    vec![
        candidate("null", "null", Json::Null),
        candidate("boolean", "a boolean", Json::from(true)),
        candidate("integer", "an integer", Json::from(1)),
        candidate("fraction", "a fraction", Json::from(0.5)),
        candidate("string", "a string", Json::from("1")),
        candidate("array", "an array", Json::Array(Vec::new())),
        candidate("object", "an object", Json::Object(Map::new())),
    ]
}

/// A value that is not in the set.
pub(super) fn unlisted(set: &Set) -> Vec<Candidate> {
    let words = "an unlisted value";
    match &set.values {
        SetValues::Integers(values) => {
            let max = values.iter().map(|found| found.value).max().unwrap_or(0);
            let next = max.checked_add(1).filter(|next| is_exact((*next).into()));
            next.map(|next| candidate("unlisted", words, next.into())).into_iter().collect()
        }
        SetValues::Strings(_) => vec![candidate("unlisted", words, Json::from("no such value"))],
    }
}

/// All candidates for a value of `expression`.
pub(super) fn of(schema: &Schema, expression: &Expression, limits: &Limits) -> Vec<Candidate> {
    let mut found = Vec::new();
    special(schema, expression, limits, &mut found);
    found.extend(kinds());
    found
}

fn special(schema: &Schema, expression: &Expression, limits: &Limits, into: &mut Vec<Candidate>) {
    match expression {
        Expression::Integer | Expression::Number => {
            into.extend(limits.range.as_ref().map(bounds).into_iter().flatten());
        }
        Expression::String => strings(limits, into),
        Expression::OneOf(constants) => {
            let constant =
                |text: &String| candidate(format!("value-{text}"), "a constant", Json::from(text.as_str()));
            into.extend(constants.iter().map(constant));
            into.push(candidate("unlisted", "another string", Json::from("no such value")));
        }
        Expression::ErrorCode => into.push(candidate("below", "a negative number", Json::from(-1))),
        Expression::ErrorList => lists(schema, &Expression::ErrorCode, limits, into),
        Expression::List(element) => lists(schema, element, limits, into),
        Expression::Map(value) => {
            for found in of(schema, value, &limits.of_elements()) {
                let map = Map::from_iter([("key".to_owned(), found.value)]);
                into.push(candidate(
                    format!("value-{}", found.name),
                    format!("an object whose only value is {}", found.words),
                    Json::Object(map),
                ));
            }
        }
        Expression::Either(alternatives) => {
            for inner in alternatives {
                special(schema, inner, limits, into);
            }
        }
        Expression::Named(_) => {
            // The type itself has separate cases. The cases here cover restrictions added where the type is used.
            if let Some(plain) = schema.plain(expression).filter(|_| limits.is_restriction()) {
                special(schema, &plain, limits, into);
            }
        }
        Expression::Any | Expression::Null | Expression::Boolean => {}
    }
}

/// Both bounds of a range, and the next value beyond each bound.
fn bounds(range: &Range) -> Vec<Candidate> {
    let mut found = Vec::new();
    let mut bound = |value: Option<&Value>, step: i32, at: &str, beyond: &str, words: [&str; 2]| {
        let (value, neighbour) = match value {
            Some(Value::Int(value)) if is_exact(*value) => (json(*value), json(*value + i128::from(step))),
            Some(Value::Float(value)) => (Json::from(*value), Json::from(value + f64::from(step))),
            _ => return,
        };
        found.push(candidate(at, words[0], value));
        found.push(candidate(beyond, words[1], neighbour));
    };
    bound(range.low.as_ref(), -1, "least", "below-range", ["the minimum of its range", "below its range"]);
    bound(range.high.as_ref(), 1, "greatest", "above-range", ["the maximum of its range", "above its range"]);
    found
}

/// True if 64-bit floats distinguish an integer from both adjacent integers.
fn is_exact(value: i128) -> bool {
    value.unsigned_abs() < EXACT_WITHIN
}

fn json(value: i128) -> Json {
    i64::try_from(value).map_or(Json::Null, Json::from)
}

fn strings(limits: &Limits, into: &mut Vec<Candidate>) {
    let text = |length: u32| "a".repeat(length as usize);
    let mut length = |name: &str, words: &str, length: Option<u32>| {
        into.extend(
            length
                .filter(|length| *length <= MAX_LENGTH)
                .map(|length| candidate(name, words, text(length).into())),
        );
    };
    length("shortest", "the minimum length", limits.min);
    length("too-short", "one character too short", limits.min.and_then(|min| min.checked_sub(1)));
    length("longest", "the maximum length", limits.max);
    length("too-long", "one character too long", limits.max.and_then(|max| max.checked_add(1)));
    if let Some(max) = limits.max.filter(|max| *max > 0 && *max <= MAX_LENGTH) {
        // Lengths count characters, not bytes or UTF-16 code units.
        into.push(candidate(
            "longest-wide",
            "the maximum length, with multibyte characters",
            "🚁".repeat(max as usize).into(),
        ));
    }
    for (index, text) in TEXTS.iter().enumerate() {
        into.push(candidate(format!("text-{index}"), format!("the text {text:?}"), Json::from(*text)));
    }
}

fn lists(schema: &Schema, element: &Expression, limits: &Limits, into: &mut Vec<Candidate>) {
    let mut typical = Typical::new(schema);
    let within = limits.of_elements();
    let mut filled = |length: u32| -> Option<Json> {
        (0..length).map(|_| typical.value(element, &within)).collect::<Option<Vec<_>>>().map(Json::from)
    };
    let mut length = |name: &str, words: &str, length: Option<u32>| {
        let list = length.filter(|length| *length <= MAX_LENGTH).and_then(&mut filled);
        into.extend(list.map(|list| candidate(name, words, list)));
    };
    length("shortest", "the minimum length", limits.min);
    length("too-short", "one element too short", limits.min.and_then(|min| min.checked_sub(1)));
    length("longest", "the maximum length", limits.max);
    length("too-long", "one element too long", limits.max.and_then(|max| max.checked_add(1)));
    let Some(Json::Array(whole)) =
        Typical::new(schema).value(&Expression::List(Box::new(element.clone())), limits)
    else {
        return;
    };
    if let Some(first) = whole.first() {
        let twice: Vec<Json> = [first.clone()].into_iter().chain(whole.iter().cloned()).collect();
        into.push(candidate("twice", "a list with a duplicate element", Json::from(twice)));
        for found in of(schema, element, &within) {
            let mut with = whole.clone();
            with[0] = found.value;
            into.push(candidate(
                format!("item-{}", found.name),
                format!("a list whose first element is {}", found.words),
                Json::from(with),
            ));
        }
    }
}
