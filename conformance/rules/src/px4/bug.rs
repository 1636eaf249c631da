//! Bugs in the reference autopilot and the reference component. Each bug violates a rule.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use uavspec_runtime::Message;

use super::Px4Rule;

/// A bug in a reference participant.
#[derive(Debug)]
pub struct Bug {
    /// The participant that has the bug.
    pub side: Side,
    /// The faulty behaviour.
    pub description: &'static str,
    /// The property of a bus that makes the bug visible.
    pub needs: Needs,
    /// Other rules that the bug violates.
    pub also: &'static [&'static Px4Rule],
    change: Change,
}

/// A participant of the arming checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The flight controller.
    Autopilot,
    /// An external component.
    Component,
}

/// A property of a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Any bus shows the bug.
    Nothing,
    /// The bus announces type hashes.
    TypeHashes,
    /// The bus sends encapsulation headers unchanged.
    Headers,
    /// The bus matches publishers and subscribers by their quality of service.
    Qos,
}

/// The kind of a bug.
#[derive(Clone, Copy, Debug)]
enum Change {
    /// Messages are changed before they are sent.
    Message(fn(&mut Outgoing)),
    /// A second publisher of the first topic announces another type.
    Type,
    /// The subscriber of the first topic requests reliable delivery.
    Reliable,
}

/// A Rust type of messages.
pub trait Typed: Message + Default + Serialize + DeserializeOwned {}

impl<M: Message + Default + Serialize + DeserializeOwned> Typed for M {}

/// A message of a participant.
#[derive(Clone, Debug)]
pub struct Sent {
    /// The type, such as `ArmingCheckReply`.
    pub name: &'static str,
    /// The message in JSON.
    pub value: Value,
    /// A bug in the encoded message.
    pub corrupt: Option<fn(&mut Vec<u8>)>,
}

impl Sent {
    /// Creates a message.
    pub fn new<M: Message + Serialize>(message: &M) -> Self {
        // All messages can be represented.
        Self::json(M::NAME, serde_json::to_value(message).unwrap_or_default())
    }

    /// Creates a message of a type that this program has no Rust type for.
    pub fn json(name: &'static str, value: Value) -> Self {
        Self { name, value, corrupt: None }
    }

    /// The message, if it has this type and can be read. Fields that the release lacks are 0.
    pub fn read<M: Typed>(&self) -> Option<M> {
        if self.name != M::NAME {
            return None;
        }
        let mut value = serde_json::to_value(M::default()).ok()?;
        merge(&mut value, &self.value);
        serde_json::from_value(value).ok()
    }
}

/// Copies values from `from` to `into`, but only for the members and items that `into` already has.
pub fn merge(into: &mut Value, from: &Value) {
    match (into, from) {
        (Value::Object(into), Value::Object(from)) => {
            for (name, value) in into {
                from.get(name).into_iter().for_each(|other| merge(value, other));
            }
        }
        (Value::Array(into), Value::Array(from)) => {
            into.iter_mut().zip(from).for_each(|(value, other)| merge(value, other));
        }
        (into, from) => *into = from.clone(),
    }
}

impl Bug {
    /// Creates a bug that changes the messages of a participant.
    pub(super) const fn message(side: Side, description: &'static str, change: fn(&mut Outgoing)) -> Self {
        Self { side, description, needs: Needs::Nothing, also: &[], change: Change::Message(change) }
    }

    /// Creates a bug in the announced type of a topic.
    pub(super) const fn announced_type(side: Side, description: &'static str) -> Self {
        Self { side, description, needs: Needs::TypeHashes, also: &[], change: Change::Type }
    }

    /// Creates a bug in the requested quality of service of a topic.
    pub(super) const fn reliable_subscriber(side: Side, description: &'static str) -> Self {
        Self { side, description, needs: Needs::Qos, also: &[], change: Change::Reliable }
    }

    /// Sets the property of a bus that makes the bug visible.
    pub(super) const fn needs(self, needs: Needs) -> Self {
        Self { needs, ..self }
    }

    /// True if a second publisher of the first topic announces another type.
    pub fn announces_other_type(&self) -> bool {
        matches!(self.change, Change::Type)
    }

    /// True if the subscriber of the first topic requests reliable delivery.
    pub fn requests_reliable(&self) -> bool {
        matches!(self.change, Change::Reliable)
    }

    /// The messages to send in place of a message. `number` counts the messages of this type, from 1.
    pub fn apply(&self, message: Sent, number: u64) -> Vec<Sent> {
        let mut outgoing = Outgoing { message: Some(message), after: Vec::new(), number };
        if let Change::Message(change) = self.change {
            change(&mut outgoing);
        }
        outgoing.message.into_iter().chain(outgoing.after).collect()
    }
}

/// A message that is about to be sent, with any messages that a bug adds after it.
pub(super) struct Outgoing {
    message: Option<Sent>,
    after: Vec<Sent>,
    /// The number of messages of this type, including this one.
    number: u64,
}

impl Outgoing {
    /// True for the first message of its type.
    pub(super) fn is_first(&self) -> bool {
        self.number == 1
    }

    /// True for each message of this type whose number is a multiple of `interval`.
    fn is_due<M: Message>(&self, interval: u64) -> bool {
        let is_of_type = self.message.as_ref().is_some_and(|sent| sent.name == M::NAME);
        is_of_type && self.number.is_multiple_of(interval)
    }

    /// Changes each `interval`-th message of this type.
    pub(super) fn edit<M: Typed>(&mut self, interval: u64, change: impl FnOnce(&mut M)) {
        if !self.is_due::<M>(interval) {
            return;
        }
        if let Some(mut message) = self.message.as_ref().and_then(Sent::read::<M>) {
            change(&mut message);
            self.message = Some(Sent::new(&message));
        }
    }

    /// Changes the payload of each `interval`-th message of this type.
    pub(super) fn edit_payload<M: Message>(&mut self, interval: u64, change: fn(&mut Vec<u8>)) {
        if self.is_due::<M>(interval)
            && let Some(sent) = &mut self.message
        {
            sent.corrupt = Some(change);
        }
    }

    /// Sends a changed copy after each `interval`-th message of this type.
    pub(super) fn follow<M: Typed>(&mut self, interval: u64, change: impl FnOnce(&mut M)) {
        if self.is_due::<M>(interval)
            && let Some(mut message) = self.message.as_ref().and_then(Sent::read::<M>)
        {
            change(&mut message);
            self.after.push(Sent::new(&message));
        }
    }

    /// Drops each `interval`-th message of this type.
    pub(super) fn drop<M: Message>(&mut self, interval: u64) {
        if self.is_due::<M>(interval) {
            self.message = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::RULES;

    #[test]
    fn each_bug_has_a_description() {
        for rule in RULES {
            let Some(bug) = &rule.bug else { continue };
            assert!(bug.description.ends_with('.'), "{rule:?}");
            assert!(!bug.also.iter().any(|other| other.rule.id == rule.rule.id), "{rule:?}");
        }
    }
}
