//! The channels of a Foxglove server.

use std::sync::Arc;

use uavspec_check::limits::MAX_SCHEMA;
use uavspec_model::json::Tree;

use crate::bus::websocket::{check_name, member, publisher, string};
use crate::bus::{Encoding, Event, Schema, Topic};

/// A channel of a server: a topic with its encoding and its schema.
pub(super) struct Channel {
    /// The topic.
    pub(super) topic: Topic,
    /// The encoding. The error is the reason why the messages can't be read.
    pub(super) encoding: Result<Encoding, String>,
    /// The schema.
    pub(super) schema: Option<Arc<Schema>>,
    /// The number of the subscription.
    pub(super) subscription: Option<u32>,
}

impl Channel {
    /// Reads the description of a channel. Returns the id and the channel. The error describes the problem.
    pub(super) fn read(described: &Tree<'_>) -> Result<(u64, Self), String> {
        let id = member(described, "id", "an id", id)?;
        let (name, type_name) = (string(described, "topic")?, string(described, "schemaName")?);
        check_name("topic", name)?;
        check_name("type", type_name)?;
        let encoding = string(described, "encoding")?;
        check_name("encoding", encoding)?;
        let topic = Topic { name: name.into(), type_name: type_name.into(), type_hash: None };
        let schema = schema(described, encoding);
        let encoding = match encoding {
            "cdr" => Ok(Encoding::Cdr),
            "json" => Ok(Encoding::Json),
            other => Err(format!("expected cdr or json, found {other:?}")),
        };
        let mut channel = Self { topic, encoding, schema: None, subscription: None };
        match schema {
            Ok(schema) => channel.schema = schema.map(Arc::new),
            Err(problem) => channel.refuse(problem),
        }
        Ok((id, channel))
    }

    /// Drops the schema. From then on, `problem` is the reason why the messages can't be read.
    pub(super) fn refuse(&mut self, problem: String) {
        self.encoding = Err(problem);
        self.schema = None;
    }

    /// The size of the schema, in bytes.
    pub(super) fn schema_size(&self) -> usize {
        self.schema.as_ref().map_or(0, |schema| schema.encoding.len() + schema.text.len())
    }

    /// The channel as a publisher.
    pub(super) fn endpoint(&self, id: u64) -> Event {
        publisher(endpoint_id(id), &self.topic.name, &self.topic.type_name)
    }
}

/// The schema of a channel. `None` if there is none, or if it is binary.
fn schema(described: &Tree<'_>, encoding: &str) -> Result<Option<Schema>, String> {
    let text = described.get("schema").and_then(Tree::as_str).unwrap_or_default();
    let encoding = match (described.get("schemaEncoding").and_then(Tree::as_str), encoding) {
        // The schema is in base64, for message encodings that aren't supported.
        (Some("protobuf" | "flatbuffer"), _) => return Ok(None),
        (Some(encoding), _) => encoding,
        // Old servers don't announce the encoding.
        (None, "cdr") => "ros2msg",
        (None, "json") => "jsonschema",
        (None, _) => return Ok(None),
    };
    if text.len() + encoding.len() > MAX_SCHEMA {
        return Err(format!("expected a schema of at most {MAX_SCHEMA} bytes, found {} bytes", text.len()));
    }
    let schema = Schema { encoding: encoding.to_owned(), text: text.as_bytes().to_vec() };
    Ok((!text.is_empty()).then_some(schema))
}

/// The id of a channel. `None` if the value isn't an id.
pub(super) fn id(value: &Tree<'_>) -> Option<u64> {
    if let Tree::Int(id) = value { u64::try_from(*id).ok() } else { None }
}

/// The endpoint id that represents a channel.
pub(super) fn endpoint_id(channel: u64) -> String {
    format!("channel {channel}")
}
