//! Typical valid values that differ from each other.

use serde_json::{Map, Value as Json};
use uavspec_schema::json_type::{Definition, Expression, Limits, Object, SetValues};
use uavspec_schema::value::Value;
use uavspec_schema::{JsonTypeId, Range, Schema, pattern};

use super::judge::Judge;

/// Maximum nesting depth at which values include all optional fields. Deeper values are as short as possible.
const MAX_OPTIONAL_DEPTH: usize = 2;

/// Maximum depth of values.
const MAX_DEPTH: usize = 16;

/// Maximum length of lists and strings.
const MAX_LENGTH: usize = 1_000;

/// Maximum total number of values, which limits the size of nested types with many fields.
const MAX_PARTS: usize = 2_000;

/// A generator of values with distinct numbers and texts.
pub(super) struct Typical<'s> {
    schema: &'s Schema,
    depth: usize,
    count: i64,
    parts: usize,
}

impl<'s> Typical<'s> {
    pub(super) fn new(schema: &'s Schema) -> Self {
        Self { schema, depth: 0, count: 0, parts: 0 }
    }

    /// A valid value, or `None` if none is found.
    pub(super) fn value(&mut self, expression: &Expression, limits: &Limits) -> Option<Json> {
        let value = self.any(expression, limits)?;
        Judge { schema: self.schema }.violations(expression, limits, &value).is_empty().then_some(value)
    }

    /// The fields of an object: either all fields, or only the required fields.
    pub(super) fn object(&mut self, object: &Object, with_optional: bool) -> Option<Map<String, Json>> {
        let mut fields = Map::new();
        for field in object.fields.iter().filter(|field| with_optional || field.is_required) {
            match self.value(&field.typed.ty, &field.typed.limits) {
                Some(value) => drop(fields.insert(field.name.clone(), value)),
                None if field.is_required => return None,
                None => {}
            }
        }
        Some(fields)
    }

    fn any(&mut self, expression: &Expression, limits: &Limits) -> Option<Json> {
        self.parts += 1;
        if self.parts > MAX_PARTS {
            return None;
        }
        match expression {
            Expression::Any | Expression::ErrorCode => Some(Json::from(self.next())),
            Expression::Null => Some(Json::Null),
            Expression::Boolean => Some(Json::from(self.next() % 2 == 1)),
            Expression::Integer => Some(Json::from(integer(limits.range.as_ref(), self.next())?)),
            Expression::Number => Some(number(limits.range.as_ref(), self.next())),
            Expression::String => self.string(limits).map(Json::from),
            Expression::ErrorList => self.list(&Expression::ErrorCode, limits),
            Expression::OneOf(constants) => {
                let index = usize::try_from(self.next()).unwrap_or(0) % constants.len().max(1);
                constants.get(index).map(|constant| Json::from(constant.as_str()))
            }
            Expression::Named(id) => self.named(*id, limits),
            Expression::List(element) => self.list(element, limits),
            Expression::Map(inner) => {
                let mut map = Map::new();
                if self.depth <= MAX_OPTIONAL_DEPTH {
                    let key = format!("key{}", self.next());
                    map.extend(self.value(inner, &limits.of_elements()).map(|value| (key, value)));
                }
                Some(Json::Object(map))
            }
            Expression::Either(alternatives) => {
                // In deeply nested values, null ends the recursion.
                let is_short = self.depth > MAX_OPTIONAL_DEPTH && expression.is_nullable();
                if is_short {
                    return Some(Json::Null);
                }
                alternatives.iter().find_map(|inner| self.value(inner, limits))
            }
        }
    }

    fn next(&mut self) -> i64 {
        self.count += 1;
        self.count
    }

    fn named(&mut self, id: JsonTypeId, limits: &Limits) -> Option<Json> {
        if self.depth >= MAX_DEPTH {
            return None;
        }
        self.depth += 1;
        let with_optional = self.depth <= MAX_OPTIONAL_DEPTH;
        let value = match &self.schema.json_type(id).definition {
            Definition::Object(object) => self.object(object, with_optional).map(Json::Object),
            Definition::Tuple(elements) => elements
                .iter()
                .filter(|element| with_optional || element.is_required)
                .map(|element| self.value(&element.typed.ty, &element.typed.limits))
                .collect(),
            Definition::Set(set) => match &set.values {
                SetValues::Integers(values) => values.first().map(|found| Json::from(found.value)),
                SetValues::Strings(values) => values.first().map(|found| Json::from(found.value.as_str())),
            },
            Definition::Named(typed) => {
                // The value must satisfy the limits of the type and the limits added where the type is used.
                self.any(&typed.ty, &narrower(&typed.limits, limits))
            }
        };
        self.depth -= 1;
        value
    }

    fn list(&mut self, element: &Expression, limits: &Limits) -> Option<Json> {
        let min = limits.min.map_or(0, |min| min as usize);
        let max = limits.max.map_or(usize::MAX, |max| max as usize);
        let preferred = if self.depth <= MAX_OPTIONAL_DEPTH { 2 } else { 0 };
        let length = preferred.clamp(min, max.max(min));
        if length > MAX_LENGTH {
            return None;
        }
        let mut list: Vec<Json> = Vec::with_capacity(length);
        for _ in 0..length {
            let Some(value) = self.value(element, &limits.of_elements()) else { break };
            if !limits.is_unique || !list.contains(&value) {
                list.push(value);
            }
        }
        Some(Json::from(list))
    }

    fn string(&mut self, limits: &Limits) -> Option<String> {
        if let Some(found) = &limits.pattern {
            return lengthened(&pattern::example(found)?, limits);
        }
        if limits.format.is_some() {
            // Base64 of the bytes 0 to 3.
            return Some("AAECAw==".to_owned());
        }
        let max = limits.max.map_or(usize::MAX, |max| max as usize);
        lengthened(&format!("{}é", self.next()).chars().take(max).collect::<String>(), limits)
    }
}

/// Repeats the last character until the text has the minimum length.
fn lengthened(text: &str, limits: &Limits) -> Option<String> {
    let min = limits.min.map_or(0, |min| min as usize);
    let missing = min.saturating_sub(text.chars().count());
    let filler = text.chars().next_back().unwrap_or('a');
    (missing <= MAX_LENGTH).then(|| text.chars().chain(std::iter::repeat_n(filler, missing)).collect())
}

/// An integer in the range.
fn integer(range: Option<&Range>, count: i64) -> Option<i64> {
    let bound = |value: &Option<Value>, round: fn(f64) -> f64| match value.as_ref()? {
        Value::Int(value) => i64::try_from(*value).ok(),
        #[allow(clippy::cast_possible_truncation)] // the bound of an integer
        other => other.as_f64().map(|value| round(value) as i64),
    };
    let (low, high) =
        range.map_or((None, None), |range| (bound(&range.low, f64::ceil), bound(&range.high, f64::floor)));
    match (low, high) {
        (Some(low), Some(high)) => {
            let span = high.checked_sub(low)?.saturating_add(1);
            (span > 0).then(|| low + count % span)
        }
        (Some(low), None) => low.checked_add(count),
        (None, Some(high)) => high.checked_sub(count),
        (None, None) => Some(count),
    }
}

/// A number in the range.
fn number(range: Option<&Range>, count: i64) -> Json {
    #[allow(clippy::cast_precision_loss)] // the count is small
    let step = count as f64 + 0.25;
    let bound = |value: &Option<Value>| value.as_ref().and_then(Value::as_f64);
    let (low, high) = range.map_or((None, None), |range| (bound(&range.low), bound(&range.high)));
    Json::from(match (low, high) {
        (Some(low), Some(high)) => low + (high - low) * (step / (step + 1.0)),
        (Some(low), None) => low + step,
        (None, Some(high)) => high - step,
        (None, None) => step,
    })
}

/// The intersection of two limits. For patterns and formats, the second limit takes precedence.
fn narrower(own: &Limits, place: &Limits) -> Limits {
    let range = |own: &Option<Range>, place: &Option<Range>| match (own, place) {
        (Some(own), Some(place)) => Some(Range {
            low: pick(own.low.as_ref(), place.low.as_ref(), |left, right| left >= right),
            high: pick(own.high.as_ref(), place.high.as_ref(), |left, right| left <= right),
        }),
        (own, place) => place.clone().or_else(|| own.clone()),
    };
    Limits {
        unit: None,
        range: range(&own.range, &place.range),
        min: own.min.max(place.min),
        max: own.max.into_iter().chain(place.max).min(),
        is_unique: own.is_unique || place.is_unique,
        pattern: place.pattern.clone().or_else(|| own.pattern.clone()),
        format: place.format.clone().or_else(|| own.format.clone()),
    }
}

fn pick(left: Option<&Value>, right: Option<&Value>, is_narrower: fn(f64, f64) -> bool) -> Option<Value> {
    let (Some(first), Some(second)) = (left, right) else { return left.or(right).cloned() };
    let (a, b) = (first.as_f64()?, second.as_f64()?);
    Some(if is_narrower(a, b) { first.clone() } else { second.clone() })
}
