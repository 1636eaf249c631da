//! Builds messages from the body types generated from `definitions/flockwave`.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;
use uavspec_types::flockwave::json::{Envelope, MessageId, ReceiptId, Response, ack_ack, ack_nak};

use super::request::each_once;

/// The protocol version in messages, as in all examples of the specification.
const PROTOCOL: &str = "1.0";

/// The reason why serializing these types can't fail.
const WRITABLE: &str =
    "all map keys are strings, all numbers are finite, and no tuple has an unset element before a set one";

/// Serializes a body as text.
pub(super) fn text(body: &impl Serialize) -> String {
    serde_json::to_string(body).expect(WRITABLE)
}

/// Converts a body to a JSON value.
pub(super) fn value(body: &impl Serialize) -> Value {
    serde_json::to_value(body).expect(WRITABLE)
}

/// Puts a body into an envelope.
pub(super) fn envelope(id: &str, refs: Option<&str>, body: Value) -> Value {
    let mut message = value(&cover(id, refs));
    message["body"] = body;
    message
}

/// Puts a serialized body into an envelope.
pub(super) fn enveloped(id: &str, refs: Option<&str>, body: &str) -> String {
    let mut message = text(&cover(id, refs));
    // The body is the last member, so it goes before the closing brace.
    message.truncate(message.len() - 1);
    message + ",\"body\":" + body + "}"
}

/// An envelope without a body.
fn cover(id: &str, refs: Option<&str>) -> Envelope {
    Envelope {
        fw_version: PROTOCOL.into(),
        id: id.into(),
        refs: refs.map(MessageId::from),
        ..Envelope::default()
    }
}

/// A positive acknowledgment (ACK-ACK).
pub(super) fn acknowledgment() -> Response {
    ack_ack::Response {}.into()
}

/// A negative acknowledgment (ACK-NAK).
pub(super) fn refusal(reason: String) -> Response {
    ack_nak::Response { reason: Some(reason) }.into()
}

/// A map in a response, keyed by requested id. The map may be absent.
type Part<T> = Option<BTreeMap<String, T>>;

/// The outcome for one of the requested ids: a result, or a receipt if the operation takes longer.
pub(super) enum Outcome<T> {
    /// The result.
    Value(T),
    /// The receipt of an operation that continues.
    Receipt(String),
}

/// The results for the requested ids. Each id is in exactly one map of the response. The map of successes is always
/// present; the other maps are omitted if they are empty.
pub(super) struct Outcomes<T> {
    values: BTreeMap<String, T>,
    errors: BTreeMap<String, String>,
}

impl<T> Outcomes<T> {
    /// An empty collection.
    pub(super) fn new() -> Self {
        Self { values: BTreeMap::new(), errors: BTreeMap::new() }
    }

    /// Calls a function for each requested id, and collects the results.
    pub(super) fn collect<I: Into<String>>(
        requested: Vec<I>,
        mut apply: impl FnMut(&str) -> Result<T, String>,
    ) -> Result<Self, String> {
        let mut outcomes = Self::new();
        for id in each_once(requested)? {
            let outcome = apply(&id);
            outcomes.put(id, outcome);
        }
        Ok(outcomes)
    }

    /// Adds the result for an id.
    pub(super) fn put(&mut self, id: String, outcome: Result<T, String>) {
        match outcome {
            Ok(value) => drop(self.values.insert(id, value)),
            Err(error) => drop(self.errors.insert(id, error)),
        }
    }

    /// The maps of successes and errors.
    pub(super) fn into_maps(self) -> (Part<T>, Part<String>) {
        (Some(self.values), unless_empty(self.errors))
    }

    /// The list of successes and the map of errors.
    pub(super) fn into_list<I: From<String>>(self) -> (Option<Vec<I>>, Part<String>) {
        (Some(self.values.into_keys().map(I::from).collect()), unless_empty(self.errors))
    }
}

impl<T> Outcomes<Outcome<T>> {
    /// The maps of successes, errors and receipts.
    pub(super) fn into_maps_with_receipts(self) -> (Part<T>, Part<String>, Part<ReceiptId>) {
        let (mut values, mut receipts) = (BTreeMap::new(), BTreeMap::new());
        for (id, outcome) in self.values {
            match outcome {
                Outcome::Value(value) => drop(values.insert(id, value)),
                Outcome::Receipt(receipt) => drop(receipts.insert(id, ReceiptId(receipt))),
            }
        }
        (Some(values), unless_empty(self.errors), unless_empty(receipts))
    }
}

fn unless_empty<T>(map: BTreeMap<String, T>) -> Part<T> {
    Some(map).filter(|map| !map.is_empty())
}
