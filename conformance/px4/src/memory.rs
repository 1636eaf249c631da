//! Checks payloads in memory, including messages that were decoded from CDR.
//!
//! A plan is compiled once for each format. The capture provides the format, and the definition provides the
//! constraints. The constraints apply to the fields that the format and the definition share. Checking a valid message
//! takes only a few comparisons for each constrained field. Violations are examined in a second pass.

mod accepted;
mod prefilter;

use std::collections::HashMap;
use std::rc::Rc;

use uavspec_dynamic::{MessageType, Placed, PlacedElement, sequence};
use uavspec_model::text::start_of;
use uavspec_model::{Findings, Location, Rule, SubjectName, hexadecimal};
use uavspec_runtime::{Number, Scalar};
use uavspec_schema::source::Span;
use uavspec_schema::{MessageId, Restriction, Schema, Shape};

use self::accepted::Accepted;
use self::prefilter::Prefilter;
use super::ValueRules;
use super::values::{
    Constraint, Coverage, Element, Encoding, FieldPlan, MessagePlan, entries_in_use, number,
};

/// The maximum length of a path or subject in a plan, in characters. There is one of each for each field of each entry,
/// and names in captures have any length.
const MAX_PATH: usize = 256;

/// The compiled checks of a format.
#[derive(Debug)]
pub struct Plan {
    rules: &'static ValueRules,
    /// The steps of values at fixed positions.
    fixed: Vec<Step>,
    /// The fast check of the fixed steps.
    prefilter: Prefilter,
    /// The steps of sequences and strings, whose content has no fixed position.
    varying: Vec<Step>,
    /// For each rule, the number of values that it covers in a message.
    coverage: Coverage,
}

/// The values of a field, which all have the same constraints.
#[derive(Debug)]
struct Step {
    /// The path of the field, e.g. `events[2].id`. If the field itself is an array, the path contains no index into the
    /// array. In a sequence, the path is relative to the element.
    path: String,
    /// The path without indices, after the topic in the subject of findings: `.events.id`.
    subject: String,
    offset: usize,
    count: usize,
    stride: usize,
    content: Content,
    /// The field that contains the number of used values, if there is one.
    count_of_values: Option<Counter>,
    /// The entries of counted arrays that contain the field.
    entries: Vec<Entry>,
}

/// The values of a step.
#[derive(Debug)]
enum Content {
    Values(Values),
    /// The checks for each element of a sequence. The sequence's slot is at the step's offset.
    Sequence(Vec<Step>),
}

/// The constraints on values.
#[derive(Debug)]
struct Values {
    element: Element,
    /// The size of a value among the fields, in bytes. A string has a slot there.
    width: usize,
    restriction: Option<Box<Restriction>>,
    accepted: Accepted,
    definition: Option<Span>,
}

/// A field that contains the number of used entries in an array.
#[derive(Clone, Debug)]
struct Counter {
    offset: usize,
    scalar: Scalar,
    /// The field's special values, which don't say how many entries are in use. Most counts have none.
    special: Box<[Number]>,
}

/// An entry of a counted array.
#[derive(Clone, Debug)]
struct Entry {
    counter: Counter,
    index: usize,
}

/// A message nested in the plan's message.
#[derive(Clone, Copy)]
struct Within<'w> {
    /// The offset of the nested message.
    base: usize,
    path: &'w str,
    subject: &'w str,
    entries: &'w [Entry],
}

/// Compiles the steps of a format.
struct Compiler<'c> {
    schema: &'c Schema,
    rules: &'static ValueRules,
    /// The constraints of all messages compiled so far.
    messages: HashMap<MessageId, Rc<MessagePlan>>,
    coverage: Coverage,
}

impl Plan {
    /// Compiles a plan for payloads with the layout of `message_type`. The payloads are messages of the `message`
    /// definition. Without a definition, only the constraints imposed by types apply. Time and memory are proportional to the number of [nested fields](FieldCounts), which the caller limits.
    pub fn new(
        message_type: MessageType<'_>,
        message: Option<MessageId>,
        schema: &Schema,
        rules: &'static ValueRules,
    ) -> Self {
        let (messages, coverage) = (HashMap::new(), Coverage::default());
        let mut compiler = Compiler { schema, rules, messages, coverage };
        let mut steps = Vec::new();
        compiler.add(
            message_type,
            message,
            Within { base: 0, path: "", subject: "", entries: &[] },
            &mut steps,
        );
        let (fixed, varying): (Vec<Step>, Vec<Step>) = steps.into_iter().partition(Step::is_fixed);
        Self { rules, prefilter: Prefilter::new(&fixed), fixed, varying, coverage: compiler.coverage }
    }

    /// Checks a payload of a topic. The payload must contain all fields of its format.
    pub fn check(&self, payload: &[u8], topic: SubjectName<'_>, location: Location, findings: &mut Findings) {
        let (reported, settled) = (0, Vec::new());
        let mut run = Run { payload, topic, location, rules: self.rules, findings, reported, settled };
        if !self.prefilter.accepts(payload) {
            run.steps(&self.fixed, 0, None);
        }
        run.steps(&self.varying, 0, None);
        run.finish();
    }

    /// Adds the coverage of this many messages.
    pub fn count(&self, messages: u64, findings: &mut Findings) {
        self.coverage.count(messages, findings);
    }
}

/// Counts the fields of types, including the fields of each nested message.
#[derive(Debug, Default)]
pub struct FieldCounts<'t>(HashMap<(&'t str, &'t str), usize>);

impl<'t> FieldCounts<'t> {
    /// The number of fields of a type. All types must be from the same set.
    pub fn of(&mut self, message_type: MessageType<'t>) -> usize {
        let key = (message_type.package(), message_type.name());
        if let Some(known) = self.0.get(&key) {
            return *known;
        }
        let fields = message_type.layout().map(|placed| match placed.element {
            PlacedElement::Message(nested) => count(placed.shape).max(1).saturating_mul(self.of(nested)),
            _ => 1,
        });
        let all = fields.fold(0, usize::saturating_add);
        self.0.insert(key, all);
        all
    }
}

/// The fields of a format that the definition has with the same type, and all fields. Without a definition, no fields
/// are shared.
pub fn shared_fields(
    message_type: MessageType<'_>,
    message: Option<MessageId>,
    schema: &Schema,
) -> (u64, u64) {
    let plan = message.map(|id| MessagePlan::new(schema.message(id), schema));
    let is_shared = |placed: &Placed<'_>| {
        plan.as_ref().is_some_and(|plan| {
            let field = plan.fields.iter().find(|field| field.name == placed.name);
            field.is_some_and(|field| is_same(*placed, field, plan))
        })
    };
    (message_type.layout().filter(is_shared).count() as u64, message_type.layout().len() as u64)
}

/// The offset of a field of type `uint64_t` in messages of a type, in bytes.
pub fn time_offset(message_type: MessageType<'_>, name: &str) -> Option<usize> {
    let is_time = |field: &Placed<'_>| {
        field.name == name
            && matches!(field.element, PlacedElement::Scalar(Scalar::UInt64))
            && field.shape == Shape::Single
    };
    message_type.layout().find(is_time).map(|field| field.offset)
}

impl Compiler<'_> {
    fn add(
        &mut self,
        message_type: MessageType<'_>,
        message: Option<MessageId>,
        within: Within<'_>,
        steps: &mut Vec<Step>,
    ) {
        let defined = message.map(|id| {
            let plan = || Rc::new(MessagePlan::new(self.schema.message(id), self.schema));
            Rc::clone(self.messages.entry(id).or_insert_with(plan))
        });
        let defined = defined.as_deref();
        for placed in message_type.layout() {
            let index =
                defined.and_then(|message| message.fields.iter().position(|field| field.name == placed.name));
            let field = defined.zip(index).map(|(message, index)| (message, &message.fields[index]));
            let counter =
                field.and_then(|(message, field)| Counter::new(field, message, message_type, within.base));
            let field = field.filter(|(message, field)| is_same(placed, field, message));
            match placed.shape {
                Shape::Bounded(_) | Shape::Sequence => {
                    self.sequence(placed, message_type, field, counter, within, steps);
                }
                Shape::Single | Shape::Array(_) => {
                    self.field(placed, message_type, field, counter, within, steps);
                }
            }
        }
    }

    /// Adds a field of fixed size.
    fn field(
        &mut self,
        placed: Placed<'_>,
        message_type: MessageType<'_>,
        field: Option<(&MessagePlan, &FieldPlan)>,
        counter: Option<Counter>,
        within: Within<'_>,
        steps: &mut Vec<Step>,
    ) {
        let offset = within.base + placed.offset;
        let PlacedElement::Message(nested) = placed.element else {
            let Some(values) = Values::new(placed, message_type, field) else { return };
            let (path, subject) = within.names(placed.name);
            let count = if matches!(values.element, Element::Text(_)) { 1 } else { count(placed.shape) };
            // A message may use fewer entries of a counted array, or none.
            if counter.is_none() && within.entries.is_empty() {
                for rule in values.constraint().rules(Encoding::Memory, self.rules) {
                    self.coverage.add(rule, count as u64);
                }
            }
            steps.push(Step {
                path,
                subject,
                offset,
                count,
                stride: placed.stride,
                content: Content::Values(values),
                count_of_values: counter,
                entries: within.entries.to_vec(),
            });
            return;
        };
        let (path, subject) = within.names(placed.name);
        for index in 0..count(placed.shape) {
            let path = if placed.shape == Shape::Single { path.clone() } else { format!("{path}[{index}]") };
            let before = steps.len();
            let entry = counter.clone().map(|counter| Entry { counter, index });
            let entries: Vec<Entry> = within.entries.iter().cloned().chain(entry).collect();
            let base = offset + index * placed.stride;
            let within = Within { base, path: &path, subject: &subject, entries: &entries };
            self.add(nested, nested_id(field), within, steps);
            // If one element needs no steps, the other elements need none either. There can be millions of elements.
            if steps.len() == before {
                break;
            }
        }
    }

    /// Adds a sequence. The elements have separate steps. The number of elements is unknown, so elements aren't part of
    /// the coverage.
    fn sequence(
        &mut self,
        placed: Placed<'_>,
        message_type: MessageType<'_>,
        field: Option<(&MessagePlan, &FieldPlan)>,
        counter: Option<Counter>,
        within: Within<'_>,
        steps: &mut Vec<Step>,
    ) {
        let (path, subject) = within.names(placed.name);
        let (mut inner, covered) = (Vec::new(), std::mem::take(&mut self.coverage));
        let element = Within { base: 0, path: "", subject: &subject, entries: &[] };
        match placed.element {
            PlacedElement::Message(nested) => self.add(nested, nested_id(field), element, &mut inner),
            _ => inner.extend(Values::new(placed, message_type, field).map(|values| Step {
                path: String::new(),
                subject: subject.clone(),
                offset: 0,
                count: 1,
                stride: placed.stride,
                content: Content::Values(values),
                count_of_values: None,
                entries: Vec::new(),
            })),
        }
        self.coverage = covered;
        if inner.is_empty() {
            return;
        }
        steps.push(Step {
            path,
            subject,
            offset: within.base + placed.offset,
            count: 1,
            stride: placed.stride,
            content: Content::Sequence(inner),
            count_of_values: counter,
            entries: within.entries.to_vec(),
        });
    }
}

impl Within<'_> {
    /// The path and the subject of a field.
    fn names(self, field: &str) -> (String, String) {
        let joint = if self.path.is_empty() { "" } else { "." };
        let field = start_of(field, MAX_PATH);
        let names = [format!("{}{joint}{field}", self.path), format!("{}.{field}", self.subject)];
        let [path, subject] = names.map(|name| start_of(&name, MAX_PATH).into_owned());
        (path, subject)
    }
}

fn nested_id(field: Option<(&MessagePlan, &FieldPlan)>) -> Option<MessageId> {
    match field?.1.element {
        Element::Message(id) => Some(id),
        Element::Scalar(_) | Element::Text(_) | Element::String { .. } => None,
    }
}

/// True if a field of a format matches this field of the definition.
fn is_same(placed: Placed<'_>, field: &FieldPlan, message: &MessagePlan) -> bool {
    match (placed.element, field.element) {
        (PlacedElement::Scalar(left), Element::Scalar(right)) => left == right && placed.shape == field.shape,
        // A ROS 2 schema doesn't distinguish text from numbers.
        (PlacedElement::Scalar(Scalar::Char), Element::Text(length)) => {
            message.has_text && placed.shape == Shape::Array(length)
        }
        (PlacedElement::Text(length), Element::Text(room)) => length == room,
        (PlacedElement::Text(length), Element::Scalar(Scalar::Char)) => field.shape == Shape::Array(length),
        // The decoder checks only the bound of the format.
        (PlacedElement::String { is_wide, bound }, Element::String { is_wide: wide, bound: defined }) => {
            is_wide == wide && bound == defined && placed.shape == field.shape
        }
        (PlacedElement::Message(_), Element::Message(_)) => placed.shape == field.shape,
        _ => false,
    }
}

fn count(shape: Shape) -> usize {
    match shape {
        Shape::Single => 1,
        Shape::Array(length) => length as usize,
        Shape::Bounded(_) | Shape::Sequence => 0,
    }
}

impl Counter {
    /// The field that counts the entries of an array, in a message of type `message_type` at offset `base`.
    fn new(
        array: &FieldPlan,
        message: &MessagePlan,
        message_type: MessageType<'_>,
        base: usize,
    ) -> Option<Self> {
        let field = &message.fields[array.counted_by?];
        let placed = message_type
            .layout()
            .find(|placed| placed.name == field.name && placed.shape == Shape::Single)?;
        match placed.element {
            PlacedElement::Scalar(scalar) => {
                Some(Self { offset: base + placed.offset, scalar, special: field.special.as_slice().into() })
            }
            PlacedElement::Text(_) | PlacedElement::String { .. } | PlacedElement::Message(_) => None,
        }
    }

    /// The number of entries in use in the message at offset `base`. If the count isn't an integer, all entries are in
    /// use.
    fn in_use(&self, base: usize, payload: &[u8]) -> usize {
        let start = base + self.offset;
        let count = payload.get(start..start + self.scalar.size());
        match count.and_then(|count| number(self.scalar, count)) {
            Some(Number::Int(count)) => entries_in_use(count, &self.special),
            Some(Number::Float(_)) | None => usize::MAX,
        }
    }
}

impl Values {
    /// The constraints on a field of `message_type` with this definition.
    fn new(
        placed: Placed<'_>,
        message_type: MessageType<'_>,
        field: Option<(&MessagePlan, &FieldPlan)>,
    ) -> Option<Self> {
        let definition = field.map(|(_, field)| field.span);
        let (element, restriction) = match placed.element {
            // A single `char` is a number.
            PlacedElement::Scalar(Scalar::Char)
                if placed.shape != Shape::Single && field.is_some_and(|(message, _)| message.has_text) =>
            {
                (Element::Text(u32::try_from(count(placed.shape)).ok()?), None)
            }
            PlacedElement::Scalar(Scalar::Bool) => (Element::Scalar(Scalar::Bool), None),
            PlacedElement::Text(length) => (Element::Text(length), None),
            // The decoder has checked the bound.
            PlacedElement::String { is_wide, .. } => (Element::String { is_wide, bound: None }, None),
            PlacedElement::Scalar(scalar) => {
                let (message, field) = field?;
                let mut restriction = Box::new(field.restriction.clone()?);
                let counted = field.counts.map(|array| &message.fields[array]);
                // The array has the length that the format states, even if the definition states a different one.
                restriction.limits.count = counted.and_then(|array| max_length(&array.name, message_type));
                // If that array is shorter, the limit may exclude special values that the definition's array allows.
                restriction.special.clone_from(&field.special);
                (Element::Scalar(scalar), Some(restriction))
            }
            PlacedElement::Message(_) => return None,
        };
        let width = match element {
            Element::Scalar(scalar) => scalar.size(),
            Element::Text(room) => room as usize,
            Element::String { .. } => placed.stride,
            Element::Message(_) => return None,
        };
        let mut values = Self { element, width, restriction, accepted: Accepted::Unknown, definition };
        values.accepted = Accepted::new(values.constraint())?;
        Some(values)
    }

    fn constraint(&self) -> Constraint<'_> {
        Constraint { element: self.element, shape: Shape::Single, restriction: self.restriction.as_deref() }
    }

    /// The bytes of the value at `start`, if the payload contains all of them.
    #[inline]
    fn bytes<'p>(&self, start: usize, payload: &'p [u8]) -> Option<&'p [u8]> {
        let (start, length) = match self.element {
            Element::String { .. } => sequence(payload, start),
            _ => (start, self.width),
        };
        payload.get(start..start + length)
    }
}

/// The maximum number of entries that an array has in a format.
fn max_length(array: &str, message_type: MessageType<'_>) -> Option<u32> {
    let placed = message_type.layout().find(|placed| placed.name == array)?;
    match (placed.element, placed.shape) {
        (PlacedElement::Text(length), _) | (_, Shape::Array(length) | Shape::Bounded(length)) => Some(length),
        (_, Shape::Single | Shape::Sequence) => None,
    }
}

/// The number of findings in a payload that are reported separately. A small compressed payload can contain millions.
const MAX_REPORTED: usize = 10_000;

/// The maximum number of rules and steps whose further findings are only counted.
const MAX_SETTLED: usize = 16;

/// The check of one payload.
struct Run<'r> {
    payload: &'r [u8],
    topic: SubjectName<'r>,
    location: Location,
    rules: &'static ValueRules,
    findings: &'r mut Findings,
    /// The number of findings.
    reported: usize,
    /// The rules and steps whose further findings are only counted, each with the field's definition and the number.
    settled: Vec<(&'static Rule, &'r Step, Option<Span>, u64)>,
}

impl<'r> Run<'r> {
    /// Checks the values of the message, or of the sequence element, at offset `base`.
    fn steps(&mut self, steps: &'r [Step], base: usize, trail: Option<&Trail<'_>>) {
        for step in steps {
            match &step.content {
                Content::Values(values) => self.values(step, values, base, trail),
                Content::Sequence(inner) => self.sequence(step, inner, base, trail),
            }
        }
    }

    fn values(&mut self, step: &'r Step, values: &'r Values, base: usize, trail: Option<&Trail<'_>>) {
        let (payload, mut start) = (self.payload, base + step.offset);
        for index in 0..step.count {
            if let Some(bytes) = values.bytes(start, payload)
                && !values.accepted.accepts(bytes)
                && step.is_in_use(index, values, base, payload)
            {
                self.explain(step, values, bytes, index, trail);
            }
            start += step.stride;
        }
    }

    fn sequence(&mut self, step: &'r Step, inner: &'r [Step], base: usize, trail: Option<&Trail<'_>>) {
        let (start, length) = sequence(self.payload, base + step.offset);
        if !step.entries.iter().all(|entry| entry.is_in_use(base, self.payload)) {
            return;
        }
        let counter = step.count_of_values.as_ref();
        let in_use = counter.map_or(length, |counter| counter.in_use(base, self.payload).min(length));
        for index in 0..in_use {
            let trail = Trail { outer: trail, sequence: &step.path, index };
            self.steps(inner, start + index * step.stride, Some(&trail));
        }
    }

    /// Reports the violation, if any, in a value that failed the fast check.
    fn explain(
        &mut self,
        step: &'r Step,
        values: &'r Values,
        bytes: &[u8],
        index: usize,
        trail: Option<&Trail<'_>>,
    ) {
        let Err(violation) = values.constraint().check_bytes(bytes) else { return };
        let rule = violation.rule(self.rules);
        let mut settled = self.settled.iter_mut();
        let same = settled.find(|(known, at, ..)| std::ptr::eq(*known, rule) && std::ptr::eq(*at, step));
        if let Some((.., more)) = same {
            *more += 1;
            return;
        }
        let name = &self.subject_of(step);
        let subject = SubjectName { name, ..self.topic };
        self.findings.report(rule, subject, self.location, values.definition, || {
            let path = joined(&trail.map(Trail::path).unwrap_or_default(), &step.path);
            let path = if step.count > 1 { format!("{path}[{index}]") } else { path };
            let detail = violation.detail(&"", "");
            // Without an index, the subject contains the whole path.
            let detail = if path.contains('[') { detail.at(path) } else { detail.located(path) };
            detail.excerpt(hexadecimal(bytes))
        });
        self.reported += 1;
        let is_full = self.reported > MAX_REPORTED && self.settled.len() < MAX_SETTLED;
        if is_full && self.findings.settle(rule, subject, values.definition) {
            self.settled.push((rule, step, values.definition, 0));
        }
    }

    /// Adds the findings that were only counted.
    fn finish(self) {
        for (rule, step, definition, more) in &self.settled {
            let subject = SubjectName { name: &self.subject_of(step), ..self.topic };
            self.findings.count(rule, subject, *definition, *more);
        }
    }

    /// The topic and the path of the field.
    fn subject_of(&self, step: &Step) -> String {
        format!("{}{}", self.topic.name, step.subject)
    }
}

/// The path to an element of a sequence.
#[derive(Clone, Copy)]
struct Trail<'t> {
    outer: Option<&'t Trail<'t>>,
    sequence: &'t str,
    index: usize,
}

impl Trail<'_> {
    fn path(&self) -> String {
        let outer = self.outer.map(Self::path).unwrap_or_default();
        format!("{}[{}]", joined(&outer, self.sequence), self.index)
    }
}

fn joined(prefix: &str, path: &str) -> String {
    let joint = if prefix.is_empty() || path.is_empty() { "" } else { "." };
    format!("{prefix}{joint}{path}")
}

impl Entry {
    fn is_in_use(&self, base: usize, payload: &[u8]) -> bool {
        self.index < self.counter.in_use(base, payload)
    }
}

impl Step {
    /// True if the values have fixed positions.
    fn is_fixed(&self) -> bool {
        match &self.content {
            Content::Values(values) => !matches!(values.element, Element::String { .. }),
            Content::Sequence(_) => false,
        }
    }

    /// True if a value is in use. Unused values are ignored.
    fn is_in_use(&self, index: usize, values: &Values, base: usize, payload: &[u8]) -> bool {
        // All characters of a text form a single value.
        let counter = self.count_of_values.as_ref().filter(|_| !matches!(values.element, Element::Text(_)));
        counter.is_none_or(|counter| index < counter.in_use(base, payload))
            && self.entries.iter().all(|entry| entry.is_in_use(base, payload))
    }
}
