//! Conforming captures, generated from any definitions. The rules report no findings in these captures, and mutants are
//! derived from them.
//!
//! The bytes depend only on the definitions. All values are the typical values from the test vectors, so adjacent
//! values differ and no value is zero by chance. The times are realistic, and so are the messages of external
//! components.

mod bag;
mod encoding;
mod events;
mod lines;
mod log;
pub mod story;

use std::collections::BTreeMap;

use serde_json::Value;
use uavspec_dynamic::{DynamicMessage, MessageType};
use uavspec_emit::vectors;
use uavspec_runtime::{Constraint, ConstraintKind, Number};
use uavspec_schema::{Element, Field, Message, MessageId, Restriction, Shape};

pub use self::bag::{Bag, BagChannel};
pub use self::encoding::Encoding;
pub(crate) use self::lines::Lines;
pub use self::log::{Entry, Log};
use crate::definitions::Definitions;

/// The number of messages on a regular topic, enough for rules that learn the topic's period.
pub const ROUNDS: u64 = 48;

/// The time between two rounds, in µs.
pub const PERIOD: u64 = 20_000;

/// The time of the first round, in µs since boot.
pub const START: u64 = 1_000_000;

/// The external components, each with its arming check id and its last round.
const COMPONENTS: [(u64, u64); 2] = [(3, ROUNDS - 1), (5, 31)];

/// The number of rounds between consecutive refusals to arm.
const REFUSED: u64 = 4;

/// A short flight with all PX4 messages in the definitions.
#[derive(Clone, Debug)]
pub struct Flight<'d> {
    /// The definitions.
    pub definitions: &'d Definitions,
    /// The topics.
    pub topics: Vec<Topic>,
    /// The messages, in chronological order.
    pub messages: Vec<Sent>,
}

/// A topic.
#[derive(Clone, Debug)]
pub struct Topic {
    /// The name.
    pub name: String,
    /// The type of the messages.
    pub message: MessageId,
}

/// A published message.
#[derive(Clone, Debug, PartialEq)]
pub struct Sent {
    /// The index of the topic.
    pub topic: usize,
    /// The message in JSON.
    pub value: Value,
}

impl<'d> Flight<'d> {
    /// Creates the flight for these definitions. Omits messages without a fixed size or without a timestamp.
    pub fn new(definitions: &'d Definitions) -> Self {
        let mut topics = Vec::new();
        let mut first = Vec::new();
        let schema = &definitions.schema;
        for ((index, message), text) in (0..).zip(&schema.messages).zip(vectors::typical(schema)) {
            let id = MessageId(index);
            let value = text.and_then(|text| serde_json::from_str::<Value>(&text).ok());
            // Only PX4 messages have topics.
            let Some((topic, value)) = message.topics.first().zip(value) else { continue };
            let is_sized = definitions.types().get(id).size().is_some();
            if is_sized && value["timestamp"].is_u64() {
                topics.push(Topic { name: topic.clone(), message: id });
                first.push(value);
            }
        }
        let mut flight = Self { definitions, topics, messages: Vec::new() };
        flight.answer_format(&mut first);
        for round in 0..ROUNDS {
            for topic in flight.in_order() {
                let name = &definitions.schema.message(flight.topics[topic].message).name;
                let values = messages_of_round(name, round, &first[topic]);
                flight.messages.extend(values.into_iter().map(|value| Sent { topic, value }));
            }
        }
        flight
    }

    /// Makes the response about message formats state the hash of the first topic.
    fn answer_format(&self, typical: &mut [Value]) {
        let response = self.topic("MessageFormatResponse").and_then(|topic| typical.get_mut(topic));
        if let (Some(topic), Some(response)) = (self.topics.first(), response) {
            let hash = self.definitions.schema.message(topic.message).hash;
            let name = format!("/fmu/out/{}", topic.name);
            let fields =
                [("topic_name", name.into()), ("success", true.into()), ("message_hash", hash.into())];
            *response = with(response, &fields);
        }
    }

    /// The topics in the order in which a round publishes them: requests before replies.
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

    /// A message in its memory layout. `None` if a value doesn't fit its field's type.
    pub fn message(&self, sent: &Sent) -> Option<DynamicMessage<'d>> {
        self.type_of(sent.topic).from_json(&sent.value).ok()
    }

    /// The topic of a message type.
    pub fn topic(&self, message: &str) -> Option<usize> {
        let schema = &self.definitions.schema;
        self.topics.iter().position(|topic| schema.message(topic.message).name == message)
    }

    /// The index of the last message of a topic.
    pub(crate) fn last_of(&self, topic: usize) -> Option<usize> {
        self.messages.iter().rposition(|sent| sent.topic == topic)
    }

    /// Changes a value in a topic's last message so that it violates a constraint. In an array, the first element is
    /// changed.
    pub(crate) fn violating(&self, rule: ConstraintKind) -> Option<Self> {
        let schema = &self.definitions.schema;
        for topic in 0..self.topics.len() {
            let message = schema.message(self.topics[topic].message);
            for field in &message.fields {
                let restriction = schema.restriction(message, field);
                let Some(value) =
                    restriction.and_then(|restriction| violating_value(rule, field, &restriction))
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

    /// Finds the first topic with a matching field, and the offset of the field in a payload.
    pub(crate) fn find_field(
        &self,
        matches: impl Fn(&uavspec_dynamic::Field) -> bool,
    ) -> Option<(usize, usize)> {
        let find =
            |topic| Some((topic, self.type_of(topic).fields().iter().find(|field| matches(field))?.offset));
        (0..self.topics.len()).find_map(find)
    }

    /// Finds the first regular topic with a matching message type.
    pub(crate) fn regular(&self, matches: impl Fn(&Message) -> bool) -> Option<usize> {
        let counts = self.counts();
        let is_regular = |topic: &Topic| counts.get(topic.name.as_str()) == Some(&ROUNDS);
        let schema = &self.definitions.schema;
        self.topics.iter().position(|topic| is_regular(topic) && matches(schema.message(topic.message)))
    }

    /// Changes the last message of a topic.
    pub fn with_last(&self, topic: usize, change: impl FnOnce(&mut Value)) -> Option<Self> {
        let last = self.last_of(topic)?;
        let mut changed = self.clone();
        change(&mut changed.messages[last].value);
        Some(changed)
    }

    /// The index of an external component's reply, some rounds before the end.
    pub(crate) fn late_reply(&self) -> Option<usize> {
        let topic = self.topic("ArmingCheckReply")?;
        let time = START + (ROUNDS - REFUSED) * PERIOD;
        self.messages.iter().position(|sent| sent.topic == topic && sent.value["timestamp"] == time)
    }

    /// Adds a changed copy of an external component's reply.
    pub fn with_reply(&self, change: impl FnOnce(&mut Value)) -> Option<Self> {
        let at = self.late_reply()?;
        let mut changed = self.clone();
        let mut reply = self.messages[at].clone();
        change(&mut reply.value);
        changed.messages.insert(at, reply);
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

    /// The index of the last message with the event at this index of a round.
    pub(crate) fn last_event(&self, index: u64) -> Option<usize> {
        let topic = self.topic("Event")?;
        let is_wanted = |sent: &Sent| {
            let number = sent.value["event_sequence"].as_u64();
            sent.topic == topic && number.is_some_and(|number| number % events::NUM_EVENTS == index)
        };
        self.messages.iter().rposition(is_wanted)
    }

    /// Changes the last message with the event at this index of a round.
    pub(crate) fn with_event(&self, index: u64, change: impl FnOnce(&mut Value)) -> Option<Self> {
        let last = self.last_event(index)?;
        let mut changed = self.clone();
        change(&mut changed.messages[last].value);
        Some(changed)
    }

    /// The flight as a `ULog`.
    pub fn log(&self) -> Log {
        Log::from_flight(self)
    }

    /// The flight as an MCAP file.
    pub fn bag(&self) -> Bag {
        Bag::from_flight(self)
    }

    /// The flight as JSON Lines with the type of each message.
    pub fn lines(&self) -> Lines {
        Lines::typed(self)
    }

    /// The flight as JSON Lines in rosbridge format.
    pub fn rosbridge(&self) -> Lines {
        Lines::published(self)
    }

    /// The number of messages on each topic, by topic name.
    pub fn counts(&self) -> BTreeMap<&str, u64> {
        let mut counts = BTreeMap::new();
        for sent in &self.messages {
            *counts.entry(self.topics[sent.topic].name.as_str()).or_default() += 1;
        }
        counts
    }
}

/// Finds a value that violates only this constraint of a field. `None` if the field has no such constraint.
fn violating_value(rule: ConstraintKind, field: &Field, restriction: &Restriction) -> Option<Value> {
    let Element::Scalar(scalar) = field.ty.element else { return None };
    let beyond = |bound: Option<Number>, by: i32| match bound? {
        Number::Int(value) => Some(Number::Int(value + i128::from(by))),
        Number::Float(value) => Some(Number::Float(value + f64::from(by))),
    };
    let Constraint { low, high, count, .. } = restriction.constraint();
    let beyond = [beyond(high, 1), beyond(low, -1)].into_iter().flatten();
    let beyond = beyond.chain(count.map(|count| Number::Int(i128::from(count) + 1)));
    let others = [Number::Float(0.1), Number::Float(f64::NAN)];
    let candidates = beyond.chain((0..256).map(Number::Int)).chain(others);
    let fits = |number: &Number| match (*number, scalar.integer_bounds()) {
        (Number::Int(value), Some((low, high))) => (low..=high).contains(&value),
        (_, bounds) => bounds.is_none(),
    };
    let violates = |number: &Number| restriction.constraint().violated_by(*number) == Some(rule);
    Some(match candidates.filter(fits).find(violates)? {
        Number::Int(value) => i64::try_from(value).ok()?.into(),
        // NaN becomes null.
        Number::Float(value) => value.into(),
    })
}

/// The messages of external components, in the order in which a round sends them.
const SESSION_TOPICS: [&str; 5] = [
    "RegisterExtComponentRequest",
    "RegisterExtComponentReply",
    "ArmingCheckRequest",
    "ArmingCheckReply",
    "UnregisterExtComponent",
];

/// The messages of a topic in one round, derived from a typical message.
fn messages_of_round(message: &str, round: u64, typical: &Value) -> Vec<Value> {
    let typical = with(typical, &[("timestamp", (START + round * PERIOD).into())]);
    let present = || COMPONENTS.iter().filter(|(_, last)| round <= *last);
    match message {
        "RegisterExtComponentRequest" | "RegisterExtComponentReply" if round > 0 => Vec::new(),
        "RegisterExtComponentRequest" => {
            present().map(|(id, _)| with(&typical, &[("request_id", (*id).into())])).collect()
        }
        "RegisterExtComponentReply" => {
            let fields = |id: u64| {
                [("request_id", id.into()), ("success", true.into()), ("arming_check_id", id.into())]
            };
            present().map(|(id, _)| with(&typical, &fields(*id))).collect()
        }
        "ArmingCheckRequest" => {
            let mask: u64 = present().map(|(id, _)| 1 << id).sum();
            let fields = [("request_id", request_id(round)), ("valid_registrations_mask", mask.into())];
            vec![with(&typical, &fields)]
        }
        "ArmingCheckReply" => {
            let reply = answer(&typical, round);
            present().map(|(id, _)| with(&reply, &[("registration_id", (*id).into())])).collect()
        }
        "Event" => vec![with(&typical, &events::fields(round))],
        "VehicleStatus" => vec![with(&typical, &events::status())],
        "UnregisterExtComponent" => present()
            .filter(|(_, last)| round == *last)
            .map(|(id, _)| with(&typical, &[("arming_check_id", (*id).into())]))
            .collect(),
        _ => vec![typical],
    }
}

/// The request id of a round. The ids wrap around during the flight.
fn request_id(round: u64) -> Value {
    ((240 + round) % 256).into()
}

/// A component's reply in one round. In some replies, the component refuses to arm.
fn answer(typical: &Value, round: u64) -> Value {
    let can_arm = !round.is_multiple_of(REFUSED);
    let num_events = if can_arm { 0 } else { 2 };
    let fields = [
        ("request_id", request_id(round)),
        ("can_arm_and_run", can_arm.into()),
        ("num_events", num_events.into()),
    ];
    let mut answer = with(typical, &fields);
    for index in 0..num_events {
        answer.pointer_mut(&format!("/events/{index}")).into_iter().for_each(events::set_reason);
    }
    // This entry is unused.
    if let Some(id) = answer.pointer_mut("/events/2/id") {
        *id = 0.into();
    }
    answer
}

/// Sets fields of a message. Skips fields that the message lacks, because fields differ between releases.
fn with(message: &Value, fields: &[(&str, Value)]) -> Value {
    let mut message = message.clone();
    for (field, new) in fields {
        if let Some(location) = message.get_mut(field) {
            *location = new.clone();
        }
    }
    message
}

#[cfg(test)]
mod tests {
    use super::{COMPONENTS, Flight, REFUSED, ROUNDS};
    use crate::definitions::Definitions;

    #[test]
    fn each_component_registers_once_and_leaves_once_at_most() {
        let definitions = Definitions::built_in();
        let flight = Flight::new(&definitions);
        let messages = |name: &str| {
            let topic = flight.topic(name).expect("a topic");
            flight.messages.iter().filter(move |sent| sent.topic == topic).map(|sent| &sent.value)
        };
        let ids = COMPONENTS.map(|(id, _)| id);
        let requested = messages("RegisterExtComponentRequest").map(|value| value["request_id"].as_u64());
        assert_eq!(requested.collect::<Vec<_>>(), ids.map(Some));
        let left = messages("UnregisterExtComponent").map(|value| value["arming_check_id"].as_u64());
        assert_eq!(left.collect::<Vec<_>>(), [Some(5), Some(3)]);
        let refused = messages("ArmingCheckReply").filter(|value| value["can_arm_and_run"] == false).count();
        let rounds: u64 = COMPONENTS.iter().map(|(_, last)| last / REFUSED + 1).sum();
        assert_eq!((refused as u64, messages("ArmingCheckRequest").count() as u64), (rounds, ROUNDS));
    }
}
