//! Sample messages: the message nearest to zero, and one message for each rule that can be violated.

use std::collections::BTreeSet;

use uavspec_schema::{Element, Message, MessageId, Schema};

use super::case::{Sample, Verdict, rule};
use super::field::FieldSamples;
use super::part::{Part, Parts};

/// Maximum nesting depth of messages with vectors. JSON readers have slightly higher limits.
const DEEPEST: usize = 32;

/// Maximum length, in bytes, of messages with vectors. This maximum exceeds the limit of `ULog`.
const LONGEST: u64 = 1 << 16;

/// A name that is not a valid field name, because field names start with a letter.
const FOREIGN: &str = "_extra";

/// All messages for which vectors can be created.
pub(super) fn parts(schema: &Schema) -> Parts {
    let mut parts = Parts(schema.messages.iter().map(|_| None).collect());
    for level in levels(schema) {
        for id in level {
            let part = MessageSamples::new(schema, schema.message(id), &parts).map(MessageSamples::part);
            if let Some(place) = parts.0.get_mut(id.0 as usize) {
                *place = part;
            }
        }
    }
    parts
}

/// Groups of messages. Each message depends only on messages in earlier groups. Messages that are too long or nested
/// too deeply are omitted.
fn levels(schema: &Schema) -> Vec<Vec<MessageId>> {
    let mut is_done = vec![false; schema.messages.len()];
    let mut levels = Vec::new();
    let mut open: Vec<MessageId> = (0..schema.messages.len())
        .map(|index| MessageId(u32::try_from(index).unwrap_or(u32::MAX)))
        .filter(|id| schema.message(*id).cdr.min <= LONGEST)
        .collect();
    while !open.is_empty() && levels.len() < DEEPEST {
        let is_ready = |id: &MessageId| {
            schema.message(*id).fields.iter().all(|field| match field.ty.element {
                Element::Message(nested) => is_done[nested.0 as usize],
                Element::Scalar(_) | Element::Text(_) | Element::String { .. } => true,
            })
        };
        let (ready, rest): (Vec<MessageId>, Vec<MessageId>) = open.iter().partition(|id| is_ready(id));
        if ready.is_empty() {
            break;
        }
        for id in &ready {
            is_done[id.0 as usize] = true;
        }
        levels.push(ready);
        open = rest;
    }
    levels
}

/// A message with the samples of its fields.
pub(super) struct MessageSamples<'s> {
    pub(super) message: &'s Message,
    /// The value nearest to zero for each field.
    zeros: Vec<String>,
    /// The samples for each field.
    pub(super) samples: Vec<Vec<Sample>>,
}

impl<'s> MessageSamples<'s> {
    /// Returns `None` if a field has no valid value.
    pub(super) fn new(schema: &'s Schema, message: &'s Message, parts: &'s Parts) -> Option<Self> {
        let fields = || message.fields.iter().map(|field| FieldSamples { schema, message, field, parts });
        let zeros: Option<Vec<String>> = fields().map(FieldSamples::zero).collect();
        Some(Self { message, zeros: zeros?, samples: fields().map(FieldSamples::samples).collect() })
    }

    /// The message with the value nearest to zero in all fields.
    pub(super) fn zero(&self) -> String {
        self.json(None, |_| None)
    }

    /// The message with the value of one field replaced.
    pub(super) fn with(&self, field: usize, json: &str) -> String {
        self.json(None, |index| (index == field).then_some(json))
    }

    /// The message without one field.
    pub(super) fn without(&self, field: usize) -> String {
        self.json(Some(field), |_| None)
    }

    /// The message with an additional field.
    pub(super) fn extended(&self) -> String {
        let mut json = self.zero();
        json.pop();
        let comma = if self.zeros.is_empty() { "" } else { "," };
        json + comma + "\"" + FOREIGN + "\":0}"
    }

    fn json<'j>(&'j self, missing: Option<usize>, other: impl Fn(usize) -> Option<&'j str>) -> String {
        let mut json = String::from("{");
        for (index, (field, zero)) in self.message.fields.iter().zip(&self.zeros).enumerate() {
            if missing == Some(index) {
                continue;
            }
            if json.len() > 1 {
                json.push(',');
            }
            json.extend(["\"", &field.name, "\":", other(index).unwrap_or(zero)]);
        }
        json.push('}');
        json
    }

    fn part(self) -> Part {
        let fields = Verdict::malformed(rule::FIELDS);
        let mut samples = vec![
            Sample::mistyped("null", "null", "null"),
            Sample::new("in-extra", "a message with an additional field", self.extended(), fields),
        ];
        if !self.zeros.is_empty() {
            samples.push(Sample::new(
                "in-missing",
                "a message without its first field",
                self.without(0),
                fields,
            ));
        }
        let mut seen: BTreeSet<&str> = [rule::FIELDS].into();
        for (index, field) in self.message.fields.iter().enumerate() {
            for sample in &self.samples[index] {
                if !sample.verdict.rule.is_some_and(|rule| seen.insert(rule)) {
                    continue;
                }
                samples.push(Sample {
                    name: format!("in-{}-{}", field.name, sample.name),
                    words: format!("a message with {}: {}", field.name, sample.words),
                    ..sample.within(|json| self.with(index, json))
                });
            }
        }
        Part { zero: self.zero(), samples }
    }
}
