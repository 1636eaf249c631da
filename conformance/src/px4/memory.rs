//! What the values of a binary payload have to be, made once for each format and run for each message.
//!
//! The format is that which the source states, the restrictions are those of the definition, for all fields
//! that both have. A healthy message costs a few comparisons for each restricted field; only of one that isn't
//! healthy it is worked out what is wrong where.

use uavspec_codegen::dynamic::{MessageType, Placed, PlacedElement};
use uavspec_codegen::schema::{
    Dialect, Element, Field, Form, Message, MessageId, Restriction, Schema, Shape,
};
use uavspec_codegen::source::Span;
use uavspec_runtime::{Constraint, Number, Scalar};

use super::ValueRules;
use crate::model::{self, Detail, Findings, Place, Rule, hexadecimal};

/// Most steps of a plan: nested arrays of nested arrays could have any number.
const MAX_STEPS: usize = 4_096;

/// The checks of a format.
#[derive(Debug)]
pub struct Plan {
    rules: &'static ValueRules,
    steps: Vec<Step>,
    /// Rules that a message exercises, each with the number of its values.
    exercises: Vec<(&'static Rule, u64)>,
}

/// The values of a field, all of one kind.
#[derive(Debug)]
struct Step {
    /// The field, as `events[2].id`; an array without an index.
    path: String,
    /// The same without any index: equal findings have it in common.
    subject: String,
    offset: usize,
    count: usize,
    stride: usize,
    kind: Kind,
    definition: Option<Span>,
    /// What says how many of its values are in use, where something does.
    count_of_values: Option<Counter>,
    /// The entries of counted arrays that it lies in.
    entries: Vec<Entry>,
}

/// A field that says how many entries of an array are in use.
#[derive(Clone, Copy, Debug)]
struct Counter {
    offset: usize,
    scalar: Scalar,
}

/// An entry of a counted array.
#[derive(Clone, Copy, Debug)]
struct Entry {
    counter: Counter,
    index: usize,
}

/// A message within that which the plan is for.
#[derive(Clone, Copy)]
struct Within<'w> {
    /// Where it starts.
    base: usize,
    path: &'w str,
    subject: &'w str,
    entries: &'w [Entry],
}

#[derive(Debug)]
enum Kind {
    Bool,
    Text(usize),
    Number(Scalar, Box<Restriction>, Healthy),
}

/// What surely breaks nothing, so that most values need no more than two comparisons.
#[derive(Clone, Debug)]
enum Healthy {
    /// Integers between two bounds, which may all be documented.
    Between(i64, i64),
    /// Those of a small set.
    Among(Box<[bool; 256]>),
    /// Floats between two bounds; NaN is asked for.
    Floats(f64, f64),
    /// All have to be asked for.
    Unknown,
}

impl Plan {
    /// The plan for payloads laid out as `of`, which stand for `message` of `schema`; without a message only what
    /// types alone say is checked. `topic` is what findings name.
    pub fn new(
        of: MessageType<'_>,
        message: Option<MessageId>,
        schema: &Schema,
        topic: &str,
        rules: &'static ValueRules,
    ) -> Self {
        let mut plan = Self { rules, steps: Vec::new(), exercises: Vec::new() };
        plan.add(of, message, schema, Within { base: 0, path: "", subject: topic, entries: &[] });
        for step in &plan.steps {
            let count = step.count as u64;
            for rule in step.rules(rules) {
                match plan.exercises.iter_mut().find(|(known, _)| known.id == rule.id) {
                    Some((_, sum)) => *sum += count,
                    None => plan.exercises.push((rule, count)),
                }
            }
        }
        plan
    }

    fn add(&mut self, of: MessageType<'_>, message: Option<MessageId>, schema: &Schema, within: Within<'_>) {
        let Within { base, path, subject, entries } = within;
        let defined = message.map(|id| schema.message(id));
        for placed in of.layout() {
            if self.steps.len() >= MAX_STEPS {
                return;
            }
            let field =
                defined.and_then(|message| message.fields.iter().find(|field| field.name == placed.name));
            let counter = defined.and_then(|message| Counter::of(placed.name, message, of, base));
            let field = field.filter(|field| is_same(placed, field));
            let offset = base + placed.offset;
            let names = || {
                let joint = if path.is_empty() { "" } else { "." };
                (format!("{path}{joint}{}", placed.name), format!("{subject}.{}", placed.name))
            };
            let PlacedElement::Message(nested) = placed.element else {
                let kind = Kind::of(placed, of, field.zip(defined), schema);
                self.steps.extend(kind.map(|kind| Step {
                    definition: field.map(|field| field.span),
                    count_of_values: counter,
                    entries: entries.to_vec(),
                    ..Step::new(placed, offset, names(), kind)
                }));
                continue;
            };
            let id = field.and_then(|field| match field.ty.element {
                Element::Message(id) => Some(id),
                Element::Scalar(_) | Element::String { .. } => None,
            });
            let (path, subject) = names();
            for index in 0..count(placed.shape) {
                let is_single = placed.shape == Shape::Single;
                let path = if is_single { path.clone() } else { format!("{path}[{index}]") };
                let before = self.steps.len();
                let entry = counter.map(|counter| Entry { counter, index });
                let entries: Vec<Entry> = entries.iter().copied().chain(entry).collect();
                let base = offset + index * placed.stride;
                self.add(
                    nested,
                    id,
                    schema,
                    Within { base, path: &path, subject: &subject, entries: &entries },
                );
                // All elements are alike, and there can be millions of them.
                if self.steps.len() == before {
                    break;
                }
            }
        }
    }

    /// How much room it takes, in steps: one for each field that is checked.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// Checks a payload, which has all fields of its format.
    pub fn check(&self, payload: &[u8], place: Place, findings: &mut Findings) {
        for step in &self.steps {
            for index in 0..step.count {
                let start = step.offset + index * step.stride;
                let Some(value) = payload.get(start..start + step.width()) else { continue };
                if !step.is_healthy(value) && step.is_in_use(index, payload) {
                    step.explain(value, index, place, self.rules, findings);
                }
            }
        }
    }

    /// Counts what so many messages exercised.
    pub fn exercise(&self, messages: u64, findings: &mut Findings) {
        for (rule, values) in &self.exercises {
            findings.exercise(rule, values * messages);
        }
    }
}

/// Whether a field of a format is the one that the definition means.
fn is_same(placed: Placed<'_>, field: &Field) -> bool {
    match (placed.element, field.ty.element) {
        (PlacedElement::Scalar(left), Element::Scalar(right)) => {
            left == right && placed.shape == field.ty.shape
        }
        (PlacedElement::Text(length), Element::Scalar(Scalar::Char)) => {
            field.ty.shape == Shape::Array(length)
        }
        (PlacedElement::Message(_), Element::Message(_)) => placed.shape == field.ty.shape,
        _ => false,
    }
}

fn count(shape: Shape) -> usize {
    match shape {
        Shape::Single => 1,
        Shape::Array(length) => length as usize,
        // Such formats have no layout of fixed size.
        Shape::Bounded(_) | Shape::Sequence => 0,
    }
}

impl Counter {
    /// The field that counts the array of a name, in a message of the format `of` that starts at `base`.
    fn of(array: &str, message: &Message, of: MessageType<'_>, base: usize) -> Option<Self> {
        let index = message.fields.iter().position(|field| field.name == array)?;
        let field = message.fields.iter().find(|field| field.counts == Some(index))?;
        let placed = of.layout().find(|placed| placed.name == field.name && placed.shape == Shape::Single)?;
        match placed.element {
            PlacedElement::Scalar(scalar) => Some(Self { offset: base + placed.offset, scalar }),
            PlacedElement::Text(_) | PlacedElement::String | PlacedElement::Message(_) => None,
        }
    }

    /// Whether a payload says that it uses the entry of this index.
    fn uses(self, index: usize, payload: &[u8]) -> bool {
        let count = payload.get(self.offset..self.offset + self.scalar.size());
        match count.and_then(|count| integer(self.scalar, count)) {
            Some(count) => usize::try_from(count).map_or(true, |count| index < count),
            None => true,
        }
    }
}

impl Kind {
    /// What is checked of a field of the format `of`, for which the definition has this one.
    fn of(
        placed: Placed<'_>,
        of: MessageType<'_>,
        field: Option<(&Field, &Message)>,
        schema: &Schema,
    ) -> Option<Self> {
        let is_text = |message| schema.package_of(message).form == Form::Msg(Dialect::Px4);
        match placed.element {
            // What comes from ROS 2 doesn't tell text from numbers.
            PlacedElement::Scalar(Scalar::Char) if field.is_some_and(|(_, message)| is_text(message)) => {
                Some(Self::Text(count(placed.shape)))
            }
            PlacedElement::Scalar(Scalar::Bool) => Some(Self::Bool),
            PlacedElement::Text(length) => Some(Self::Text(length as usize)),
            PlacedElement::Scalar(scalar) => {
                let (field, message) = field?;
                let mut restriction = schema.restriction(message, field)?;
                let counted = field.counts.and_then(|array| message.fields.get(array));
                // The array has the length that the format says; another than that of the definition is no breach.
                restriction.count = counted.and_then(|array| most(&array.name, of));
                let healthy = Healthy::of(scalar, &restriction);
                let says_nothing = restriction.constraint() == Constraint::NONE;
                (!says_nothing).then(|| Self::Number(scalar, Box::new(restriction), healthy))
            }
            PlacedElement::String | PlacedElement::Message(_) => None,
        }
    }
}

/// How many entries the array of a name can have in a format.
fn most(array: &str, of: MessageType<'_>) -> Option<u32> {
    let placed = of.layout().find(|placed| placed.name == array)?;
    match (placed.element, placed.shape) {
        (PlacedElement::Text(length), _) | (_, Shape::Array(length) | Shape::Bounded(length)) => Some(length),
        (_, Shape::Single | Shape::Sequence) => None,
    }
}

impl Step {
    fn new(placed: Placed<'_>, offset: usize, (path, subject): (String, String), kind: Kind) -> Self {
        Self {
            path,
            subject,
            offset,
            count: if matches!(kind, Kind::Text(_)) { 1 } else { count(placed.shape) },
            stride: placed.stride,
            kind,
            definition: None,
            count_of_values: None,
            entries: Vec::new(),
        }
    }

    fn width(&self) -> usize {
        match &self.kind {
            Kind::Bool => 1,
            Kind::Text(length) => *length,
            Kind::Number(scalar, ..) => scalar.size(),
        }
    }

    /// The rules that its values can break.
    fn rules(&self, rules: &ValueRules) -> Vec<&'static model::Rule> {
        use uavspec_runtime::Rule;
        match &self.kind {
            Kind::Bool => vec![rules.bool],
            Kind::Text(_) => vec![rules.text],
            Kind::Number(_, restriction, _) => {
                let asked = [
                    (restriction.count.is_some(), Rule::Count),
                    (restriction.low.is_some() || restriction.high.is_some(), Rule::Range),
                    (restriction.known.is_some(), Rule::Enum),
                    (restriction.forbids_nan, Rule::Nan),
                ];
                asked.into_iter().filter(|(is_asked, _)| *is_asked).map(|(_, rule)| rules.on(rule)).collect()
            }
        }
    }

    fn is_healthy(&self, value: &[u8]) -> bool {
        match &self.kind {
            Kind::Bool => value[0] < 2,
            Kind::Text(_) => std::str::from_utf8(until_nul(value)).is_ok(),
            Kind::Number(scalar, _, healthy) => match healthy {
                Healthy::Between(low, high) => {
                    integer(*scalar, value).is_some_and(|value| (*low..=*high).contains(&value))
                }
                Healthy::Among(set) => set[usize::from(value[0])],
                Healthy::Floats(low, high) => {
                    float(*scalar, value).is_some_and(|value| *low <= value && value <= *high)
                }
                Healthy::Unknown => false,
            },
        }
    }

    /// Whether a value counts: what lies beyond the entries in use is ignored, whatever it is.
    fn is_in_use(&self, index: usize, payload: &[u8]) -> bool {
        // The letters of a text are one value.
        let of_values = self.count_of_values.filter(|_| !matches!(self.kind, Kind::Text(_)));
        of_values.is_none_or(|counter| counter.uses(index, payload))
            && self.entries.iter().all(|entry| entry.counter.uses(entry.index, payload))
    }

    /// Works out what a value that may be unhealthy breaks, and reports it.
    fn explain(&self, value: &[u8], index: usize, place: Place, rules: &ValueRules, findings: &mut Findings) {
        let mut report = |rule: &'static model::Rule, detail: Detail| {
            let path = self.path_of(index);
            // Without an index the subject says it all.
            let detail = if path.contains('[') { detail.at(path) } else { detail.located(path) };
            let detail = detail.excerpt(hexadecimal(value));
            findings.report(rule, &self.subject, place, self.definition, || detail);
        };
        match &self.kind {
            Kind::Bool => {
                let detail = Detail::new(format!("{} where a bool is 0 or 1", value[0]));
                report(rules.bool, detail.expected("0 or 1").actual(value[0].to_string()));
            }
            Kind::Text(_) => {
                if let Err(error) = std::str::from_utf8(until_nul(value)) {
                    let text = format!("no UTF-8 from its byte {} on", error.valid_up_to());
                    report(rules.text, Detail::new(text).expected("UTF-8"));
                }
            }
            Kind::Number(scalar, restriction, _) => {
                let Some(found) = number(*scalar, value) else { return };
                let Some(broken) = restriction.constraint().broken_by(found) else { return };
                report(rules.on(broken), Detail::of_number(broken, found, restriction));
            }
        }
    }

    /// The path of a value: which element is meant, where there are several.
    fn path_of(&self, index: usize) -> String {
        if self.count > 1 { format!("{}[{index}]", self.path) } else { self.path.clone() }
    }
}

impl Healthy {
    /// Worked out by asking the restriction itself, so that the two can't differ.
    fn of(scalar: Scalar, restriction: &Restriction) -> Self {
        let constraint = restriction.constraint();
        if let Scalar::UInt8 | Scalar::Byte | Scalar::Char | Scalar::Int8 = scalar {
            let is_healthy =
                |byte: u8| number(scalar, &[byte]).is_some_and(|value| constraint.broken_by(value).is_none());
            return Self::Among(Box::new(std::array::from_fn(|byte| {
                u8::try_from(byte).is_ok_and(is_healthy)
            })));
        }
        let bound = |number: Option<Number>, none: i64| match number {
            None => Some(none),
            Some(Number::Int(value)) => i64::try_from(value).ok(),
            Some(Number::Float(_)) => None,
        };
        if scalar.is_float() {
            let bound = |number: Option<Number>, none: f64| match number {
                None => none,
                #[allow(clippy::cast_precision_loss)] // what is rounded away is asked for
                Some(Number::Int(value)) => value as f64,
                Some(Number::Float(value)) => value,
            };
            return Self::Floats(
                bound(restriction.low, f64::NEG_INFINITY),
                bound(restriction.high, f64::INFINITY),
            );
        }
        let is_plain = restriction.known.is_none() && scalar != Scalar::UInt64;
        let high = match (restriction.high, restriction.count) {
            (None, Some(count)) => Some(Number::Int(count.into())),
            (high, None) => high,
            (Some(_), Some(_)) => return Self::Unknown,
        };
        match (bound(restriction.low, i64::MIN), bound(high, i64::MAX)) {
            (Some(low), Some(high)) if is_plain => Self::Between(low, high),
            _ => Self::Unknown,
        }
    }
}

fn until_nul(text: &[u8]) -> &[u8] {
    text.iter().position(|byte| *byte == 0).map_or(text, |end| &text[..end])
}

fn integer(scalar: Scalar, bytes: &[u8]) -> Option<i64> {
    match number(scalar, bytes)? {
        Number::Int(value) => i64::try_from(value).ok(),
        Number::Float(_) => None,
    }
}

fn float(scalar: Scalar, bytes: &[u8]) -> Option<f64> {
    match scalar {
        Scalar::Float32 => Some(f64::from(f32::from_le_bytes(bytes.try_into().ok()?))),
        Scalar::Float64 => Some(f64::from_le_bytes(bytes.try_into().ok()?)),
        _ => None,
    }
}

/// The number that little-endian bytes stand for.
fn number(scalar: Scalar, bytes: &[u8]) -> Option<Number> {
    let integer = match scalar {
        Scalar::Bool | Scalar::UInt8 | Scalar::Byte | Scalar::Char => i128::from(*bytes.first()?),
        Scalar::Int8 => i128::from(i8::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::UInt16 => i128::from(u16::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::Int16 => i128::from(i16::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::UInt32 => i128::from(u32::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::Int32 => i128::from(i32::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::UInt64 => i128::from(u64::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::Int64 => i128::from(i64::from_le_bytes(bytes.try_into().ok()?)),
        Scalar::Float32 | Scalar::Float64 => return float(scalar, bytes).map(Number::Float),
    };
    Some(Number::Int(integer))
}
