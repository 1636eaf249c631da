//! Messages as the server builds them: bodies of the types that the pages of `definitions/flockwave` give, in envelopes.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;
use uavspec::flockwave::json::{Envelope, MessageId, ReceiptId, Response, ack_ack, ack_nak};

use super::request::each_once;

/// The version of the protocol that messages say they follow: that of all examples of the specification.
const PROTOCOL: &str = "1.0";

/// Why what the server builds can always be written.
const WRITABLE: &str = "its maps have texts as keys, and its tuples have no gaps";

/// The text of a body.
pub(super) fn text(body: &impl Serialize) -> String {
    serde_json::to_string(body).expect(WRITABLE)
}

/// The value of a body, for what may change it.
pub(super) fn value(body: &impl Serialize) -> Value {
    serde_json::to_value(body).expect(WRITABLE)
}

/// Puts a body into an envelope.
pub(super) fn envelope(id: &str, refs: Option<&str>, body: Value) -> Value {
    let mut message = value(&cover(id, refs));
    message["body"] = body;
    message
}

/// The same of a body that is written already.
pub(super) fn enveloped(id: &str, refs: Option<&str>, body: &str) -> String {
    let mut message = text(&cover(id, refs));
    // The body is the last field: the brace that closes the envelope follows it.
    message.truncate(message.len() - 1);
    message + ",\"body\":" + body + "}"
}

/// An envelope that has no body yet.
fn cover(id: &str, refs: Option<&str>) -> Envelope {
    Envelope {
        fw_version: PROTOCOL.into(),
        id: id.into(),
        refs: refs.map(MessageId::from),
        ..Envelope::default()
    }
}

/// The answer that says yes.
pub(super) fn acknowledgment() -> Response {
    ack_ack::Response {}.into()
}

/// The answer that says no.
pub(super) fn refusal(reason: String) -> Response {
    ack_nak::Response { reason: Some(reason) }.into()
}

/// A map of a response, by what was asked for. A response may leave it out.
type Part<T> = Option<BTreeMap<String, T>>;

/// What became of one of the things that a request asked for, where it may take longer.
pub(super) enum Outcome<T> {
    /// It is done: what came of it.
    Value(T),
    /// It takes longer: the receipt.
    Receipt(String),
}

/// What became of the things that a request asked for. Each goes into exactly one of the maps of the response: that of
/// what succeeded, which is always there, or others, which are there where they hold something.
pub(super) struct Outcomes<T> {
    values: BTreeMap<String, T>,
    errors: BTreeMap<String, String>,
}

impl<T> Outcomes<T> {
    /// Nothing yet.
    pub(super) fn new() -> Self {
        Self { values: BTreeMap::new(), errors: BTreeMap::new() }
    }

    /// What becomes of each thing that was asked for.
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

    /// Adds what became of one thing.
    pub(super) fn put(&mut self, id: String, outcome: Result<T, String>) {
        match outcome {
            Ok(value) => drop(self.values.insert(id, value)),
            Err(error) => drop(self.errors.insert(id, error)),
        }
    }

    /// The maps: what succeeded, and why the rest didn't.
    pub(super) fn into_maps(self) -> (Part<T>, Part<String>) {
        (Some(self.values), unless_empty(self.errors))
    }

    /// A list of what succeeded, and why the rest didn't.
    pub(super) fn into_list<I: From<String>>(self) -> (Option<Vec<I>>, Part<String>) {
        (Some(self.values.into_keys().map(I::from).collect()), unless_empty(self.errors))
    }
}

impl<T> Outcomes<Outcome<T>> {
    /// The maps: what succeeded, why the rest didn't, and the receipts of what takes longer.
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
