//! The messages of a role in a release of PX4.
//!
//! Roles store messages as JSON. A release may lack fields of such a message. If it has additional fields, their value
//! is 0.

use std::sync::Arc;

use serde_json::Value;
use uavspec_rules::definitions::{Definitions, Family, Library, versioned};
use uavspec_rules::px4::{Sent, merge};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::fingerprint::ros_name;
use uavspec_schema::{Message, MessageId};

use super::namespace::Namespace;
use crate::bus::Topic;

/// The release that a role uses, and the namespace of its topics.
pub(super) struct Release {
    definitions: Arc<Definitions>,
    namespace: Namespace,
}

impl Release {
    /// Chooses the release of a vehicle. If the definitions don't indicate it, chooses the newest release.
    pub(super) fn new(definitions: &Arc<Definitions>, library: &Library, namespace: Namespace) -> Self {
        let is_shown = !definitions.releases().is_empty() || !library.depends_on_capture();
        let definitions = if is_shown { Arc::clone(definitions) } else { library.newest(Family::Px4) };
        Self { definitions, namespace }
    }

    /// The topic of a type. `folder` is `in` or `out`. Fails if the release lacks the type.
    pub(super) fn topic(&self, name: &str, folder: &str) -> Result<Topic, String> {
        let message = self.message(self.id(name)?);
        let topic = message.topics.first().map_or("", String::as_str);
        Ok(Topic {
            name: self.namespace.join(&versioned(&format!("/fmu/{folder}/{topic}"), message.version)).into(),
            type_name: ros_name(&self.definitions.schema, message).into(),
            type_hash: Some(message.type_hash.as_str().into()),
        })
    }

    /// PX4's hash of the definition of a topic.
    pub(super) fn hash(&self, topic: &str) -> Option<u32> {
        self.definitions.message_of_topic(topic).map(|id| self.message(id).hash)
    }

    /// The payload of a message. The error describes the problem.
    pub(super) fn encode(&self, sent: &Sent) -> Result<Vec<u8>, String> {
        let ty = self.definitions.types().get(self.id(sent.name)?);
        let mut value = ty.default().to_json().map_err(|error| error.to_string())?;
        merge(&mut value, &sent.value);
        let message = ty.from_json(&value).map_err(|error| error.to_string())?;
        let mut payload = message.to_cdr(ByteOrder::LittleEndian).map_err(|error| error.to_string())?;
        if let Some(corrupt) = sent.corrupt {
            corrupt(&mut payload);
        }
        Ok(payload)
    }

    /// Reads a payload. The error describes the problem.
    pub(super) fn decode(&self, name: &'static str, payload: &[u8]) -> Result<Sent, String> {
        let ty = self.definitions.types().get(self.id(name)?);
        let message = ty.decode_cdr_strict(payload).map_err(|error| error.to_string())?;
        let value: Value = message.to_json().map_err(|error| error.to_string())?;
        Ok(Sent::json(name, value))
    }

    fn id(&self, name: &str) -> Result<MessageId, String> {
        let id = self.definitions.message_of_type(&format!("px4/{name}"));
        id.ok_or_else(|| format!("{} has no {name}", self.definitions.name))
    }

    fn message(&self, id: MessageId) -> &Message {
        self.definitions.schema.message(id)
    }
}
