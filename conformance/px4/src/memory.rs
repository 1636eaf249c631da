//! Checks payloads in memory, including messages that were decoded from CDR.
//!
//! A plan is compiled once for each format. The capture provides the format, and the definition provides the
//! constraints. The constraints apply to the fields that the format and the definition share. Checking a valid value
//! takes only a few comparisons. Other values are examined further.

mod accepted;

use std::collections::HashMap;

use uavspec_dynamic::{Field, MessageType, ValueType, number, sequence};
use uavspec_model::text::start_of;
use uavspec_model::{Findings, Location, Rule, SubjectName, hexadecimal};
use uavspec_runtime::{Number, Scalar};
use uavspec_schema::source::Span;
use uavspec_schema::{Element, MessageId, Restriction, Shape};

use self::accepted::{Accepted, Block};
use super::ValueRules;
use super::values::{Coverage, Encoding, detail, entries_in_use, rules_on};
use crate::limits::{MAX_PATH, MAX_REPORTED};

/// The compiled checks of a format.
#[derive(Debug)]
pub struct Plan {
    rules: &'static ValueRules,
    steps: Vec<Step>,
    /// The fast check of all values. `None` if their number or size varies.
    fast: Option<Vec<Block>>,
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
struct Compiler {
    rules: &'static ValueRules,
    coverage: Coverage,
}

impl Plan {
    /// Compiles a plan for payloads with the layout of `format`. The payloads are messages of the type `defined`.
    /// Without a definition, only the constraints imposed by types apply. Time and memory are proportional to the number
    /// of [nested fields](FieldCounts), which the caller limits.
    pub fn new(
        format: MessageType<'_>,
        defined: Option<MessageType<'_>>,
        rules: &'static ValueRules,
    ) -> Self {
        let mut compiler = Compiler { rules, coverage: Coverage::default() };
        let mut steps = Vec::new();
        let within = Within { base: 0, path: "", subject: "", entries: &[] };
        compiler.add(format, defined, within, &mut steps);
        let blocks: Option<Vec<Block>> = steps.iter().map(Step::block).collect();
        let fast = blocks.map(Block::merge);
        Self { rules, steps, fast, coverage: compiler.coverage }
    }

    /// Checks a payload of a topic. The payload must contain all fields of its format.
    #[inline]
    pub fn check(&self, payload: &[u8], topic: SubjectName<'_>, location: Location, findings: &mut Findings) {
        let is_accepted = |blocks: &Vec<Block>| blocks.iter().all(|block| block.accepts(payload));
        if !self.fast.as_ref().is_some_and(is_accepted) {
            self.check_each(payload, topic, location, findings);
        }
    }

    /// Checks each value, and reports the violations.
    fn check_each(
        &self,
        payload: &[u8],
        topic: SubjectName<'_>,
        location: Location,
        findings: &mut Findings,
    ) {
        let (reported, settled) = (0, Vec::new());
        let mut run = Run { payload, topic, location, rules: self.rules, findings, reported, settled };
        run.steps(&self.steps, 0, None);
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
        if message_type.defect().is_some() {
            return 1;
        }
        let key = (message_type.package(), message_type.name());
        if let Some(known) = self.0.get(&key) {
            return *known;
        }
        let fields = message_type.fields().iter().map(|field| match field.element {
            Element::Message(id) => field.count().max(1).saturating_mul(self.of(message_type.nested(id))),
            _ => 1,
        });
        let all = fields.fold(0, usize::saturating_add);
        self.0.insert(key, all);
        all
    }
}

/// The number of fields that the format and the definition share with the same type, and the number of all fields.
/// Without a definition, no fields are shared.
pub fn shared_fields(format: MessageType<'_>, defined: Option<MessageType<'_>>) -> (u64, u64) {
    let is_shared = |field: &&Field| {
        let defined = defined.and_then(|defined| defined.field(&field.name));
        defined.is_some_and(|defined| is_same(field, defined))
    };
    (format.fields().iter().filter(is_shared).count() as u64, format.fields().len() as u64)
}

/// The offset of a field of type `uint64_t` in messages of a type, in bytes.
pub fn time_offset(message_type: MessageType<'_>, name: &str) -> Option<usize> {
    let is_time =
        |field: &&Field| field.element == Element::Scalar(Scalar::UInt64) && field.shape == Shape::Single;
    message_type.field(name).filter(is_time).map(|field| field.offset)
}

/// A field of a format with its definition.
#[derive(Clone, Copy)]
struct Source<'s> {
    format: MessageType<'s>,
    field: &'s Field,
    /// The definition, if it has the same type.
    defined: Option<(MessageType<'s>, &'s Field)>,
}

impl<'s> Source<'s> {
    /// The type of a nested message, and its definition.
    fn nested(self, id: MessageId) -> (MessageType<'s>, Option<MessageType<'s>>) {
        let defined = self.defined.and_then(|(message, field)| match field.element {
            Element::Message(id) => Some(message.nested(id)),
            Element::Scalar(_) | Element::Text(_) | Element::String { .. } => None,
        });
        (self.format.nested(id), defined)
    }
}

impl Compiler {
    fn add(
        &mut self,
        format: MessageType<'_>,
        defined: Option<MessageType<'_>>,
        within: Within<'_>,
        steps: &mut Vec<Step>,
    ) {
        for field in format.fields() {
            let found = defined.and_then(|message| Some((message, message.field(&field.name)?)));
            let counter =
                found.and_then(|(message, array)| Counter::new(array, message, format, within.base));
            let source =
                Source { format, field, defined: found.filter(|(_, defined)| is_same(field, defined)) };
            if field.is_sequence() {
                self.sequence(source, counter, within, steps);
            } else {
                self.field(source, counter, within, steps);
            }
        }
    }

    /// Adds a field of fixed size.
    fn field(
        &mut self,
        source: Source<'_>,
        counter: Option<Counter>,
        within: Within<'_>,
        steps: &mut Vec<Step>,
    ) {
        let field = source.field;
        let offset = within.base + field.offset;
        let Element::Message(id) = field.element else {
            let Some(values) = Values::new(source) else { return };
            let (path, subject) = within.names(&field.name);
            let count = if matches!(values.element, Element::Text(_)) { 1 } else { field.count() };
            // A message may use fewer entries of a counted array, or none.
            if counter.is_none() && within.entries.is_empty() {
                for rule in rules_on(values.value_type(), Encoding::Memory, self.rules) {
                    self.coverage.add(rule, count as u64);
                }
            }
            steps.push(Step {
                path,
                subject,
                offset,
                count,
                stride: field.stride,
                content: Content::Values(values),
                count_of_values: counter,
                entries: within.entries.to_vec(),
            });
            return;
        };
        let (path, subject) = within.names(&field.name);
        let (nested, defined) = source.nested(id);
        for index in 0..field.count() {
            let path = if field.shape == Shape::Single { path.clone() } else { format!("{path}[{index}]") };
            let before = steps.len();
            let entry = counter.clone().map(|counter| Entry { counter, index });
            let entries: Vec<Entry> = within.entries.iter().cloned().chain(entry).collect();
            let base = offset + index * field.stride;
            let within = Within { base, path: &path, subject: &subject, entries: &entries };
            self.add(nested, defined, within, steps);
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
        source: Source<'_>,
        counter: Option<Counter>,
        within: Within<'_>,
        steps: &mut Vec<Step>,
    ) {
        let field = source.field;
        let (path, subject) = within.names(&field.name);
        let (mut inner, covered) = (Vec::new(), std::mem::take(&mut self.coverage));
        if let Element::Message(id) = field.element {
            let (nested, defined) = source.nested(id);
            let element = Within { base: 0, path: "", subject: &subject, entries: &[] };
            self.add(nested, defined, element, &mut inner);
        } else {
            inner.extend(Values::new(source).map(|values| Step {
                path: String::new(),
                subject: subject.clone(),
                offset: 0,
                count: 1,
                stride: field.stride,
                content: Content::Values(values),
                count_of_values: None,
                entries: Vec::new(),
            }));
        }
        self.coverage = covered;
        if inner.is_empty() {
            return;
        }
        steps.push(Step {
            path,
            subject,
            offset: within.base + field.offset,
            count: 1,
            stride: field.stride,
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

/// True if a field of a format has the type of its definition.
fn is_same(field: &Field, defined: &Field) -> bool {
    match (field.element, defined.element) {
        // A ROS 2 schema doesn't distinguish text from numbers.
        (Element::Scalar(Scalar::Char), Element::Text(length)) => field.shape == Shape::Array(length),
        (Element::Text(length), Element::Scalar(Scalar::Char)) => defined.shape == Shape::Array(length),
        (Element::Message(_), Element::Message(_)) => field.shape == defined.shape,
        // The decoder checks only the bound of the format.
        (element, other) => element == other && field.shape == defined.shape,
    }
}

impl Counter {
    /// The field that counts the entries of an array, in a message of type `format` at offset `base`.
    fn new(array: &Field, defined: MessageType<'_>, format: MessageType<'_>, base: usize) -> Option<Self> {
        let defined = &defined.fields()[array.counted_by?];
        let field = format.field(&defined.name).filter(|field| field.shape == Shape::Single)?;
        match field.element {
            Element::Scalar(scalar) => {
                Some(Self { offset: base + field.offset, scalar, special: defined.special.as_slice().into() })
            }
            Element::Text(_) | Element::String { .. } | Element::Message(_) => None,
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
    /// The constraints on the values of a field.
    fn new(source: Source<'_>) -> Option<Self> {
        let (field, defined) = (source.field, source.defined.map(|(_, defined)| defined));
        let (element, restriction) = match (field.element, defined.map(|defined| defined.element)) {
            (Element::Scalar(Scalar::Char), Some(text @ Element::Text(_))) => (text, None),
            (Element::Scalar(Scalar::Bool) | Element::Text(_), _) => (field.element, None),
            // The decoder has checked the bound.
            (Element::String { wide, .. }, _) => (Element::String { wide, bound: None }, None),
            (Element::Scalar(_), _) => (field.element, Some(restriction(source)?)),
            (Element::Message(_), _) => return None,
        };
        let width = match element {
            Element::Scalar(scalar) => scalar.size(),
            Element::Text(room) => room as usize,
            Element::String { .. } => field.stride,
            Element::Message(_) => return None,
        };
        let definition = defined.map(|defined| defined.span);
        let mut values = Self { element, width, restriction, accepted: Accepted::Unknown, definition };
        values.accepted = Accepted::new(values.value_type())?;
        Some(values)
    }

    fn value_type(&self) -> ValueType<'_> {
        ValueType { element: self.element, shape: Shape::Single, restriction: self.restriction.as_deref() }
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

/// The restriction that the definition of a field imposes on numbers, if there is one.
fn restriction(source: Source<'_>) -> Option<Box<Restriction>> {
    let (message, defined) = source.defined?;
    let mut restriction = Box::new(defined.restriction.clone()?);
    let counted = defined.counts.map(|array| &message.fields()[array]);
    // The array has the length in the format, even if the definition has a different one.
    restriction.limits.count =
        counted.and_then(|array| source.format.field(&array.name)).and_then(|array| array.ty().max_length());
    // If the array in the format is shorter, the limit may exclude special values that the definition's array allows.
    restriction.special.clone_from(&defined.special);
    Some(restriction)
}

/// The maximum number of pairs of a rule and a step whose further findings are only counted.
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
    /// The pairs of a rule and a step whose further findings are only counted, each with the field's definition and the
    /// count.
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
        let Err(violation) = values.value_type().check_bytes(bytes) else { return };
        let rule = self.rules.violated_by(&violation);
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
            let detail = detail(&violation, &"", "");
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
    /// The fast check of the values. `None` if their number or size varies.
    fn block(&self) -> Option<Block> {
        match &self.content {
            Content::Values(Values { element: Element::String { .. }, .. }) | Content::Sequence(_) => None,
            Content::Values(Values { width, accepted, .. }) => {
                let Self { offset, count, stride, .. } = *self;
                Some(Block { offset, count, stride, width: *width, accepted: *accepted })
            }
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
