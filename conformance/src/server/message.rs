//! Messages as the server builds them.
//!
//! They are made by hand out of JSON values, after the pages of `definitions/flockwave`. Once types are generated
//! from these pages, this module is what they replace.

use serde_json::{Map, Value, json};

/// The version of the protocol that messages say they follow: that of all examples of the specification.
const PROTOCOL: &str = "1.0";

/// Puts a body into an envelope.
pub(super) fn envelope(id: &str, refs: Option<&str>, body: Value) -> Value {
    let mut message = json!({ "$fw.version": PROTOCOL, "id": id });
    if let Some(refs) = refs {
        message["refs"] = json!(refs);
    }
    message["body"] = body;
    message
}

/// The same of the body of a notification that is written already.
pub(super) fn enveloped(id: &str, body: &str) -> String {
    format!(r#"{{"$fw.version":"{PROTOCOL}","id":"{id}","body":{body}}}"#)
}

/// The answer that says yes.
pub(super) fn acknowledgment() -> Value {
    json!({ "type": "ACK-ACK" })
}

/// The answer that says no.
pub(super) fn refusal(reason: &str) -> Value {
    json!({ "type": "ACK-NAK", "reason": reason })
}

/// What became of a request, for one of the things that it asked for.
pub(super) enum Outcome {
    /// It is done: what came of it.
    Value(Value),
    /// It takes longer: the receipt.
    Receipt(String),
}

/// The body of a response that has a map for what succeeded and others for what didn't: each thing that was asked for
/// goes into exactly one.
pub(super) struct Parts {
    kind: String,
    name: &'static str,
    values: Map<String, Value>,
    errors: Map<String, Value>,
    receipts: Map<String, Value>,
}

impl Parts {
    /// A body of a type, with the name of the map for what succeeded.
    pub(super) fn new(kind: &str, name: &'static str) -> Self {
        let [values, errors, receipts] = [Map::new(), Map::new(), Map::new()];
        Self { kind: kind.to_owned(), name, values, errors, receipts }
    }

    /// Adds what became of one thing.
    pub(super) fn put(&mut self, id: &str, outcome: Result<Outcome, String>) {
        let (map, value) = match outcome {
            Ok(Outcome::Value(value)) => (&mut self.values, value),
            Ok(Outcome::Receipt(receipt)) => (&mut self.receipts, json!(receipt)),
            Err(error) => (&mut self.errors, json!(error)),
        };
        map.insert(id.to_owned(), value);
    }

    /// The body.
    pub(super) fn into_body(self) -> Value {
        let mut body = json!({ "type": self.kind, self.name: self.values });
        for (name, map) in [("error", self.errors), ("receipt", self.receipts)] {
            if !map.is_empty() {
                body[name] = Value::Object(map);
            }
        }
        body
    }

    /// The body with lists of names in place of values: `success` and `error`.
    pub(super) fn into_names(self) -> Value {
        let names: Vec<&String> = self.values.keys().collect();
        let mut body = json!({ "type": self.kind, self.name: names });
        if !self.errors.is_empty() {
            body["error"] = Value::Object(self.errors);
        }
        body
    }
}
