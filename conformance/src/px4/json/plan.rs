//! What each message has to be, put together once for all of a schema.

use uavspec_codegen::dynamic::members::Named;
use uavspec_codegen::schema::{self, Dialect as Language, Form, MessageId, Restriction, Schema, Shape};
use uavspec_codegen::source::Span;
use uavspec_runtime::Scalar;

use crate::model::{Findings, Rule};
use crate::px4::ValueRules;

/// The plans of all messages of a schema.
#[derive(Debug)]
pub struct Plans {
    pub(super) rules: &'static ValueRules,
    /// In the order of the schema.
    messages: Vec<MessagePlan>,
}

/// What a message has to be.
#[derive(Debug)]
pub(crate) struct MessagePlan {
    pub(super) name: String,
    pub(super) fields: Vec<FieldPlan>,
    pub(super) span: Span,
    /// How many values of a message each rule judges; sequences count as one.
    exercises: Vec<(&'static Rule, u64)>,
}

/// What a field has to be.
#[derive(Debug)]
pub(super) struct FieldPlan {
    pub(super) name: String,
    pub(super) element: Element,
    /// How many of them; text is one.
    pub(super) shape: Shape,
    pub(super) restriction: Option<Restriction>,
    /// The field that says how many of its entries are in use, where one does.
    pub(super) counted_by: Option<usize>,
    pub(super) span: Span,
    /// Where it starts in memory, from the start of its message; 0 where that has no fixed size.
    pub(super) offset: usize,
    /// Bytes from one element to the next in memory.
    pub(super) stride: usize,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Element {
    Scalar(Scalar),
    /// PX4's `char[N]`.
    Text(u32),
    String {
        bound: Option<u32>,
    },
    Message(MessageId),
}

impl Plans {
    /// The plans of a schema.
    pub fn new(schema: &Schema, rules: &'static ValueRules) -> Self {
        let messages = schema.messages.iter().map(|message| MessagePlan {
            name: message.name.clone(),
            fields: (0..message.fields.len()).map(|index| FieldPlan::new(message, index, schema)).collect(),
            span: message.span,
            exercises: Vec::new(),
        });
        let mut plans = Self { rules, messages: messages.collect() };
        for id in &schema.nested_first {
            plans.messages[id.0 as usize].exercises = plans.exercises(*id);
        }
        plans
    }

    pub(crate) fn get(&self, id: MessageId) -> &MessagePlan {
        &self.messages[id.0 as usize]
    }

    /// Counts what so many messages exercised.
    pub(crate) fn exercise(&self, id: MessageId, messages: u64, findings: &mut Findings) {
        for (rule, values) in &self.get(id).exercises {
            findings.exercise(rule, values.saturating_mul(messages));
        }
    }

    fn exercises(&self, id: MessageId) -> Vec<(&'static Rule, u64)> {
        let mut sums: Vec<(&'static Rule, u64)> = Vec::new();
        let mut add =
            |rule: &'static Rule, values: u64| match sums.iter_mut().find(|(known, _)| known.id == rule.id) {
                Some((_, sum)) => *sum = sum.saturating_add(values),
                None => sums.push((rule, values)),
            };
        add(self.rules.members, 1);
        for field in &self.get(id).fields {
            let count = match field.shape {
                Shape::Array(length) => u64::from(length),
                Shape::Single | Shape::Bounded(_) | Shape::Sequence => 1,
            };
            field.rules(self.rules).for_each(|rule| add(rule, count));
            if let Element::Message(nested) = field.element {
                for (rule, values) in &self.get(nested).exercises {
                    add(rule, values.saturating_mul(count));
                }
            }
        }
        sums
    }
}

impl Named for FieldPlan {
    fn name(&self) -> &str {
        &self.name
    }
}

impl FieldPlan {
    fn new(message: &schema::Message, index: usize, schema: &Schema) -> Self {
        let field = &message.fields[index];
        let is_px4 = schema.package_of(message).form == Form::Msg(Language::Px4);
        let (element, shape) = match (field.ty.element, field.ty.shape) {
            (schema::Element::Scalar(Scalar::Char), Shape::Array(length)) if is_px4 => {
                (Element::Text(length), Shape::Single)
            }
            (schema::Element::Scalar(scalar), shape) => (Element::Scalar(scalar), shape),
            (schema::Element::String { bound, .. }, shape) => (Element::String { bound }, shape),
            (schema::Element::Message(id), shape) => (Element::Message(id), shape),
        };
        let slots = message.uorb.iter().flat_map(|layout| &layout.slots);
        let slot = slots.into_iter().find(|slot| slot.field == Some(index));
        let (offset, size) = slot.map_or((0, 0), |slot| (slot.offset, slot.size));
        Self {
            name: field.name.clone(),
            element,
            shape,
            restriction: schema.restriction(message, field),
            counted_by: message.fields.iter().position(|other| other.counts == Some(index)),
            span: field.span,
            offset,
            stride: if let Shape::Array(length) = shape { size / (length as usize).max(1) } else { size },
        }
    }

    /// The rules that its values can break.
    fn rules(&self, rules: &ValueRules) -> impl Iterator<Item = &'static Rule> {
        let is_bounded = matches!(self.shape, Shape::Array(_) | Shape::Bounded(_))
            || matches!(self.element, Element::Text(_) | Element::String { bound: Some(_) });
        let restriction = self.restriction.as_ref();
        let asks = |what: fn(&Restriction) -> bool| restriction.is_some_and(what);
        let asked = [
            (true, rules.json_type),
            (is_bounded, rules.length),
            (matches!(self.element, Element::Text(_)), rules.text),
            (asks(|asked| asked.count.is_some()), rules.count),
            (asks(|asked| asked.low.is_some() || asked.high.is_some()), rules.range),
            (asks(|asked| asked.known.is_some()), rules.documented),
            (asks(|asked| asked.forbids_nan), rules.nan),
        ];
        asked.into_iter().filter(|(is_asked, _)| *is_asked).map(|(_, rule)| rule)
    }

    /// Whether it holds bytes, which rosbridge writes as base64.
    pub(super) fn holds_bytes(&self) -> bool {
        let is_byte = matches!(self.element, Element::Scalar(Scalar::UInt8 | Scalar::Byte | Scalar::Char));
        is_byte && self.shape != Shape::Single
    }
}
