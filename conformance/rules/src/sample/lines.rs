//! Flights as JSON Lines.

use serde_json::{Value, json};

use super::Flight;

/// JSON Lines.
#[derive(Clone, Debug)]
pub struct Lines {
    /// The lines, with one message each.
    pub lines: Vec<String>,
}

impl Lines {
    /// Creates lines with the type of each message.
    pub(super) fn typed(flight: &Flight<'_>) -> Self {
        let schema = &flight.definitions.schema;
        let line = |topic: usize, value: &Value| {
            let message = schema.message(flight.topics[topic].message);
            let package = &schema.package_of(message).name;
            json!({ "type": format!("{package}/{}", message.name), "message": value })
        };
        Self::from_flight(flight, line)
    }

    /// Creates rosbridge lines with the topic of each message.
    pub(super) fn published(flight: &Flight<'_>) -> Self {
        let line = |topic: usize, value: &Value| {
            let topic = format!("/fmu/out/{}", flight.topics[topic].name);
            json!({ "op": "publish", "topic": topic, "msg": value })
        };
        Self::from_flight(flight, line)
    }

    fn from_flight(flight: &Flight<'_>, line: impl Fn(usize, &Value) -> Value) -> Self {
        Self { lines: flight.messages.iter().map(|sent| line(sent.topic, &sent.value).to_string()).collect() }
    }

    /// Replaces text in the last line that contains it.
    #[must_use]
    pub(crate) fn with_text(mut self, from: &str, to: &str) -> Option<Self> {
        let line = self.lines.iter_mut().rfind(|line| line.contains(from))?;
        *line = line.replacen(from, to, 1);
        Some(self)
    }

    /// The bytes of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        (self.lines.join("\n") + "\n").into_bytes()
    }
}
