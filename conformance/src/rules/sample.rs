//! Recordings that conform, made from any definitions: what rules must find nothing in, and what the mutants of
//! rules are made of.
//!
//! The same definitions give the same bytes. All values are typical ones of the test vectors, so neighbours differ
//! and nothing is zero by chance; time, and the session between flight controller and external component, are as they
//! would be.

mod bag;
mod encoding;
mod lines;
mod log;

use std::collections::BTreeMap;

use serde_json::Value;
use uavspec_codegen::dynamic::{DynamicMessage, MessageType, Placed};
use uavspec_codegen::emit::vectors;
use uavspec_codegen::msg::{Dialect, Kind};
use uavspec_codegen::schema::{Element, Field, Form, Message, MessageId, Restriction, Shape};
use uavspec_runtime::{Constraint, Number, Rule};

pub(crate) use self::bag::Bag;
pub(crate) use self::encoding::Encoding;
pub(crate) use self::lines::Lines;
pub(crate) use self::log::{Entry, Log};
use crate::definitions::Definitions;

/// How many messages a topic has, if it comes regularly: enough for rules that learn its period.
pub(crate) const ROUNDS: u64 = 48;

/// From one round to the next, in µs.
pub(crate) const PERIOD: u64 = 20_000;

/// When the first round is, in µs since system start.
pub(crate) const START: u64 = 1_000_000;

/// The external components: the id that each gets for its arming checks, and the last round in which it is there.
const COMPONENTS: [(u64, u64); 2] = [(3, ROUNDS - 1), (5, 31)];

/// Components refuse in each round of so many.
const REFUSED: u64 = 4;

/// A short flight: all messages of PX4 that the definitions have.
#[derive(Clone, Debug)]
pub(crate) struct Flight<'d> {
    /// What it keeps to.
    pub definitions: &'d Definitions,
    /// Its topics.
    pub topics: Vec<Topic>,
    /// Its messages, in order of time.
    pub messages: Vec<Sent>,
}

/// A topic.
#[derive(Clone, Debug)]
pub(crate) struct Topic {
    /// Its name.
    pub name: String,
    /// The type of its messages.
    pub message: MessageId,
}

/// A message that was published.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sent {
    /// Index of its topic.
    pub topic: usize,
    /// What it says, as JSON.
    pub value: Value,
}

impl<'d> Flight<'d> {
    /// The flight of some definitions. Messages that don't lie in memory, or have no time, aren't part of it.
    pub(crate) fn new(definitions: &'d Definitions) -> Self {
        let mut topics = Vec::new();
        let mut first = Vec::new();
        let schema = &definitions.schema;
        for ((index, message), text) in (0..).zip(&schema.messages).zip(vectors::typical(schema)) {
            let id = MessageId(index);
            let topic = message.topics.first().filter(|_| is_published(message, definitions));
            let value = text.and_then(|text| serde_json::from_str::<Value>(&text).ok());
            let Some((topic, value)) = topic.zip(value) else { continue };
            let is_sized = definitions.types().get(id).size().is_some();
            if is_sized && value["timestamp"].is_u64() {
                topics.push(Topic { name: topic.clone(), message: id });
                first.push(value);
            }
        }
        let mut flight = Self { definitions, topics, messages: Vec::new() };
        for round in 0..ROUNDS {
            for topic in flight.in_order() {
                let name = &definitions.schema.message(flight.topics[topic].message).name;
                let values = messages_of_round(name, round, &first[topic]);
                flight.messages.extend(values.into_iter().map(|value| Sent { topic, value }));
            }
        }
        flight
    }

    /// The topics in the order in which a round publishes them: questions come before their answers.
    fn in_order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.topics.len()).collect();
        order.sort_by_key(|topic| {
            let name = &self.definitions.schema.message(self.topics[*topic].message).name;
            SESSION_TOPICS.iter().position(|known| known == name)
        });
        order
    }

    /// The type of a topic.
    pub(crate) fn type_of(&self, topic: usize) -> MessageType<'d> {
        self.definitions.types().get(self.topics[topic].message)
    }

    /// A message as it lies in memory; none where its values don't fit its type.
    pub(crate) fn message(&self, sent: &Sent) -> Option<DynamicMessage<'d>> {
        self.type_of(sent.topic).from_json(&sent.value).ok()
    }

    /// The topic of a message.
    pub(crate) fn topic(&self, message: &str) -> Option<usize> {
        let schema = &self.definitions.schema;
        self.topics.iter().position(|topic| schema.message(topic.message).name == message)
    }

    /// The index of the last message of a topic.
    pub(crate) fn last_of(&self, topic: usize) -> Option<usize> {
        self.messages.iter().rposition(|sent| sent.topic == topic)
    }

    /// Changes a value in the last message of some topic so that it breaks a rule on numbers; of arrays the first
    /// element.
    pub(crate) fn violating(&self, rule: Rule) -> Option<Self> {
        let schema = &self.definitions.schema;
        for topic in 0..self.topics.len() {
            let message = schema.message(self.topics[topic].message);
            for field in &message.fields {
                let restriction = schema.restriction(message, field);
                let Some(value) = restriction.and_then(|requested| violating_value(rule, field, &requested))
                else {
                    continue;
                };
                let mut changed = self.clone();
                let last = self.last_of(topic)?;
                let location = &mut changed.messages[last].value[&field.name];
                match field.ty.shape {
                    Shape::Single => *location = value,
                    _ => *location.get_mut(0)? = value,
                }
                return Some(changed);
            }
        }
        None
    }

    /// The first topic that has a field like this, and where in a payload the field starts.
    pub(crate) fn find_field(&self, is_wanted: impl Fn(&Placed<'_>) -> bool) -> Option<(usize, usize)> {
        let find = |topic| Some((topic, self.type_of(topic).layout().find(&is_wanted)?.offset));
        (0..self.topics.len()).find_map(find)
    }

    /// The first topic that comes regularly and for which something holds.
    pub(crate) fn regular(&self, holds: impl Fn(&Message) -> bool) -> Option<usize> {
        let counts = self.counts();
        let is_regular = |topic: &Topic| counts.get(topic.name.as_str()) == Some(&ROUNDS);
        let schema = &self.definitions.schema;
        self.topics.iter().position(|topic| is_regular(topic) && holds(schema.message(topic.message)))
    }

    /// Changes the last message of a topic.
    pub(crate) fn with_last(&self, topic: usize, change: impl FnOnce(&mut Value)) -> Option<Self> {
        let last = self.last_of(topic)?;
        let mut changed = self.clone();
        change(&mut changed.messages[last].value);
        Some(changed)
    }

    /// The index of a reply of an external component, some rounds before the end.
    pub(crate) fn late_reply(&self) -> Option<usize> {
        let topic = self.topic("ArmingCheckReply")?;
        let time = START + (ROUNDS - REFUSED) * PERIOD;
        self.messages.iter().position(|sent| sent.topic == topic && sent.value["timestamp"] == time)
    }

    /// Adds a reply of an external component like the one before it, with a change.
    pub(crate) fn with_reply(&self, change: impl FnOnce(&mut Value)) -> Option<Self> {
        let at = self.late_reply()?;
        let mut changed = self.clone();
        let mut reply = self.messages[at].clone();
        change(&mut reply.value);
        changed.messages.insert(at + 1, reply);
        Some(changed)
    }

    /// Changes the last reply in which an external component refuses to arm.
    pub(crate) fn with_refusal(&self, change: impl FnOnce(&mut Value)) -> Option<Self> {
        let topic = self.topic("ArmingCheckReply")?;
        let is_refused = |sent: &Sent| sent.topic == topic && sent.value["can_arm_and_run"] == false;
        let last = self.messages.iter().rposition(is_refused)?;
        let mut changed = self.clone();
        change(&mut changed.messages[last].value);
        Some(changed)
    }

    /// As a log of PX4.
    pub(crate) fn log(&self) -> Log {
        Log::from_flight(self)
    }

    /// As MCAP.
    pub(crate) fn bag(&self) -> Bag {
        Bag::from_flight(self)
    }

    /// As JSON Lines that name the type of each message.
    pub(crate) fn lines(&self) -> Lines {
        Lines::typed(self)
    }

    /// As JSON Lines of rosbridge.
    pub(crate) fn rosbridge(&self) -> Lines {
        Lines::published(self)
    }

    /// How many messages each topic has, by its name.
    pub(crate) fn counts(&self) -> BTreeMap<&str, u64> {
        let mut counts = BTreeMap::new();
        for sent in &self.messages {
            *counts.entry(self.topics[sent.topic].name.as_str()).or_default() += 1;
        }
        counts
    }
}

/// A value that breaks this rule in this field, and no other; none where the field has nothing to do with it.
fn violating_value(rule: Rule, field: &Field, requested: &Restriction) -> Option<Value> {
    let Element::Scalar(scalar) = field.ty.element else { return None };
    let beyond = |bound: Option<Number>, by: i32| match bound? {
        Number::Int(value) => Some(Number::Int(value + i128::from(by))),
        Number::Float(value) => Some(Number::Float(value + f64::from(by))),
    };
    let Constraint { low, high, count, .. } = requested.constraint();
    let beyond = [beyond(high, 1), beyond(low, -1)].into_iter().flatten();
    let beyond = beyond.chain(count.map(|count| Number::Int(i128::from(count) + 1)));
    let others = [Number::Float(0.1), Number::Float(f64::NAN)];
    let candidates = beyond.chain((0..256).map(Number::Int)).chain(others);
    let fits = |number: &Number| match (*number, scalar.integer_bounds()) {
        (Number::Int(value), Some((low, high))) => (low..=high).contains(&value),
        (_, bounds) => bounds.is_none(),
    };
    let breaks = |number: &Number| requested.constraint().violated_by(*number) == Some(rule);
    Some(match candidates.filter(fits).find(breaks)? {
        Number::Int(value) => i64::try_from(value).ok()?.into(),
        // NaN is null.
        Number::Float(value) => value.into(),
    })
}

fn is_published(message: &Message, definitions: &Definitions) -> bool {
    let package = definitions.schema.package_of(message);
    package.form == Form::Msg(Dialect::Px4) && message.kind == Kind::Message
}

/// Messages of a session, in the order in which a round has them.
const SESSION_TOPICS: [&str; 5] = [
    "RegisterExtComponentRequest",
    "RegisterExtComponentReply",
    "ArmingCheckRequest",
    "ArmingCheckReply",
    "UnregisterExtComponent",
];

/// The messages that a round has of a topic, made of a typical one.
fn messages_of_round(message: &str, round: u64, typical: &Value) -> Vec<Value> {
    let typical = with(typical, &[("timestamp", (START + round * PERIOD).into())]);
    let there = || COMPONENTS.iter().filter(|(_, last)| round <= *last);
    match message {
        "RegisterExtComponentRequest" | "RegisterExtComponentReply" if round > 0 => Vec::new(),
        "RegisterExtComponentRequest" => {
            there().map(|(id, _)| with(&typical, &[("request_id", (*id).into())])).collect()
        }
        "RegisterExtComponentReply" => {
            let fields = |id: u64| {
                [("request_id", id.into()), ("success", true.into()), ("arming_check_id", id.into())]
            };
            there().map(|(id, _)| with(&typical, &fields(*id))).collect()
        }
        "ArmingCheckRequest" => {
            let mask: u64 = there().map(|(id, _)| 1 << id).sum();
            let fields = [("request_id", request_id(round)), ("valid_registrations_mask", mask.into())];
            vec![with(&typical, &fields)]
        }
        "ArmingCheckReply" => {
            let reply = answer(&typical, round);
            there().map(|(id, _)| with(&reply, &[("registration_id", (*id).into())])).collect()
        }
        "UnregisterExtComponent" => there()
            .filter(|(_, last)| round == *last)
            .map(|(id, _)| with(&typical, &[("arming_check_id", (*id).into())]))
            .collect(),
        _ => vec![typical],
    }
}

/// The request of a round. The numbers begin anew during the flight.
fn request_id(round: u64) -> Value {
    ((240 + round) % 256).into()
}

/// What a component says in a round: it refuses now and then.
fn answer(typical: &Value, round: u64) -> Value {
    let is_agreed = !round.is_multiple_of(REFUSED);
    let events = if is_agreed { 0 } else { 2 };
    let fields = [
        ("request_id", request_id(round)),
        ("can_arm_and_run", is_agreed.into()),
        ("num_events", events.into()),
    ];
    let mut answer = with(typical, &fields);
    // It isn't in use.
    if let Some(id) = answer.pointer_mut("/events/2/id") {
        *id = 0.into();
    }
    answer
}

/// A message with other values in those of these fields that it has: not every release has every field.
fn with(message: &Value, fields: &[(&str, Value)]) -> Value {
    let mut message = message.clone();
    for (field, new) in fields {
        if let Some(location) = message.get_mut(field) {
            *location = new.clone();
        }
    }
    message
}
