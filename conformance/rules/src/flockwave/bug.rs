//! Bugs in the reference server. Each bug makes the server violate a rule.
//!
//! A bug either changes messages before they are sent, or changes the behaviour of the server. In the second case, the
//! server code checks whether the bug is enabled.

use serde_json::{Map, Value, json};
use uavspec_model::Rule;

/// The protocol version in server messages.
const PROTOCOL: &str = "1.0";

/// A bug in the reference server.
#[derive(Debug)]
pub struct Bug {
    /// The faulty behaviour of the server.
    pub description: &'static str,
    /// Other rules that the bug violates.
    pub also: &'static [&'static Rule],
    /// The setup needed to observe the bug.
    pub needs: Needs,
    change: Change,
}

/// The setup needed to observe a bug, in addition to a probe over TCP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// No additional setup.
    Nothing,
    /// A client that connects over TCP, and not in memory.
    Tcp,
    /// A client that connects over UDP.
    Udp,
    /// A client that connects over Socket.IO.
    SocketIo,
    /// A server that requires a login.
    Login,
    /// A server that closes connections after some time.
    Farewell,
    /// A client that waits for operations to end for as long as it does by default.
    Patience,
}

/// The kind of a bug.
#[derive(Clone, Copy, Debug)]
enum Change {
    /// Messages are changed before they are sent.
    Message(fn(&mut Outgoing<'_>)),
    /// The server behaves differently.
    Behaviour,
}

impl Bug {
    /// Creates a bug that changes messages.
    pub(super) const fn message(description: &'static str, change: fn(&mut Outgoing<'_>)) -> Self {
        Self { description, also: &[], needs: Needs::Nothing, change: Change::Message(change) }
    }

    /// Creates a bug in the behaviour of the server.
    pub(super) const fn behaviour(description: &'static str) -> Self {
        Self { description, also: &[], needs: Needs::Nothing, change: Change::Behaviour }
    }

    /// Sets the rules that the bug violates in addition to its own rule.
    pub(super) const fn also(self, also: &'static [&'static Rule]) -> Self {
        Self { also, ..self }
    }

    /// Sets the setup needed to observe the bug.
    pub(super) const fn needs(self, needs: Needs) -> Self {
        Self { needs, ..self }
    }

    /// Changes a message before it is sent.
    pub fn apply(&self, outgoing: &mut Outgoing<'_>) {
        if let Change::Message(change) = self.change {
            change(outgoing);
        }
    }
}

/// A server message that is about to be sent, with any messages that a bug adds before or after it.
pub struct Outgoing<'r> {
    /// Messages to send before this message.
    before: Vec<Value>,
    /// The message; `None` if a bug drops it.
    pub(super) message: Option<Value>,
    /// Messages to send after this message.
    after: Vec<Value>,
    /// The body of the request that this message answers, if any.
    pub(super) request: Option<&'r Value>,
    /// The number of messages sent on the connection, including this one.
    pub(super) number: u64,
    /// Serializes a message.
    pub(super) write: fn(&Value) -> String,
}

impl<'r> Outgoing<'r> {
    /// Creates an outgoing message.
    pub fn new(message: Value, request: Option<&'r Value>, number: u64) -> Self {
        let (before, after) = (Vec::new(), Vec::new());
        Self { before, message: Some(message), after, request, number, write: Value::to_string }
    }

    /// All messages to send, in order.
    pub fn into_texts(self) -> Vec<String> {
        let messages = self.before.iter().chain(&self.message).chain(&self.after);
        messages.map(|message| (self.write)(message)).collect()
    }

    /// The message.
    pub(super) fn message(&mut self) -> &mut Value {
        self.message.get_or_insert(Value::Null)
    }

    /// The type of the message body.
    pub(super) fn kind(&self) -> &str {
        self.message.as_ref().and_then(|message| message["body"]["type"].as_str()).unwrap_or_default()
    }

    /// The type of the request that this message answers.
    pub(super) fn request_type(&self) -> Option<&str> {
        self.request.map(|body| body.get("type").and_then(Value::as_str).unwrap_or_default())
    }

    /// The requested ids or paths.
    fn requested_ids(&self) -> Vec<&'r str> {
        let list = self.request.and_then(|body| body.get("ids").or_else(|| body.get("paths")));
        list.and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str).collect()
    }

    /// True if the message does not answer a request.
    pub(super) fn is_notification(&self) -> bool {
        self.request.is_none()
    }

    /// True if the response refuses a request of an unknown type.
    pub(super) fn refuses_unknown_type(&mut self) -> bool {
        self.message()["body"]["reason"].as_str().is_some_and(|reason| reason.starts_with("no handler"))
    }

    /// The body, if it has this type.
    pub(super) fn body_of(&mut self, kind: &str) -> Option<&mut Value> {
        if self.kind() == kind { Some(&mut self.message()["body"]) } else { None }
    }

    /// The body of a notification of this type.
    pub(super) fn notification_of(&mut self, kind: &str) -> Option<&mut Value> {
        if self.is_notification() { self.body_of(kind) } else { None }
    }

    /// Sets a field of the body, if the body has this type.
    pub(super) fn set(&mut self, kind: &str, field: &str, value: Value) {
        if let Some(body) = self.body_of(kind) {
            body[field] = value;
        }
    }

    /// The list of ids in the body, if the body has this type.
    pub(super) fn ids_of(&mut self, kind: &str) -> Option<&mut Vec<Value>> {
        self.body_of(kind)?["ids"].as_array_mut()
    }

    /// Replaces the last id in a list with a number.
    pub(super) fn make_last_id_a_number(&mut self, kind: &str) {
        if let Some(last) = self.ids_of(kind).and_then(|ids| ids.last_mut()) {
            *last = json!(7);
        }
    }

    /// Replaces a list of ids with its first id.
    pub(super) fn replace_ids_by_first(&mut self, kind: &str) {
        if let Some(body) = self.body_of(kind) {
            body["ids"] = body["ids"][0].take();
        }
    }

    /// Appends a copy of the first id in a list.
    pub(super) fn repeat_first_id(&mut self, kind: &str) {
        if let Some(ids) = self.ids_of(kind) {
            ids.extend_from_within(..1.min(ids.len()));
        }
    }

    /// Changes each value of `status` in a body of this type.
    pub(super) fn each_status(&mut self, kind: &str, change: impl FnMut(&mut Value)) {
        let status = self.body_of(kind).and_then(|body| body.get_mut("status")?.as_object_mut());
        status.into_iter().flat_map(Map::values_mut).for_each(change);
    }

    /// The first state in UAV-INF.
    pub(super) fn state(&mut self) -> Option<&mut Value> {
        self.body_of("UAV-INF")?.get_mut("status")?.as_object_mut()?.values_mut().next()
    }

    /// Sets a field of the first state in UAV-INF.
    pub(super) fn set_in_state(&mut self, field: &str, value: Value) {
        if let Some(state) = self.state() {
            state[field] = value;
        }
    }

    /// Changes the timestamps of all UAVs in UAV-INF.
    pub(super) fn shift_timestamps(&mut self, change: impl Fn(u64) -> u64) {
        self.each_status("UAV-INF", |state| {
            state["timestamp"] = json!(change(state["timestamp"].as_u64().unwrap_or_default()));
        });
    }

    /// The ports in SYS-PORTS.
    pub(super) fn ports(&mut self) -> impl Iterator<Item = &mut Value> {
        let ports = self.body_of("SYS-PORTS").and_then(|body| body["ports"].as_object_mut());
        ports.into_iter().flat_map(Map::values_mut)
    }

    /// The first item of SYS-MSG.
    pub(super) fn item(&mut self) -> Option<&mut Map<String, Value>> {
        self.body_of("SYS-MSG")?["items"][0].as_object_mut()
    }

    /// The first receipt of a response.
    pub(super) fn receipt(&mut self) -> Option<Value> {
        match self.message()["body"].get("receipt")? {
            Value::Object(receipts) => receipts.values().next().cloned(),
            Value::String(receipt) => Some(json!(receipt)),
            _ => None,
        }
    }

    /// Adds a message to send after this one.
    pub(super) fn follow(&mut self, refs: Option<&str>, body: Value) {
        let message = self.envelope(refs, body);
        self.after.push(message);
    }

    /// Adds a message to send before this one.
    pub(super) fn precede(&mut self, body: Value) {
        let message = self.envelope(None, body);
        self.before.push(message);
    }

    fn envelope(&self, refs: Option<&str>, body: Value) -> Value {
        let mut message = json!({ "$fw.version": PROTOCOL, "id": format!("x{}", self.number) });
        if let Some(refs) = refs {
            message["refs"] = refs.into();
        }
        message["body"] = body;
        message
    }

    /// Removes the last requested object from all maps of the response.
    pub(super) fn drop_last(&mut self, kinds: &[&str]) {
        if self.is_notification() || !kinds.contains(&self.kind()) {
            return;
        }
        let Some(last) = self.requested_ids().last().copied() else { return };
        let Some(body) = self.message()["body"].as_object_mut() else { return };
        for map in body.values_mut().filter_map(Value::as_object_mut) {
            map.remove(last);
        }
    }
}

/// The body of a progress notification.
pub(super) fn progress(receipt: &Value) -> Value {
    json!({ "type": "ASYNC-ST", "id": receipt, "progress": { "percentage": 1 } })
}

#[cfg(test)]
mod tests {
    use super::super::RULES;

    #[test]
    fn each_bug_has_a_description() {
        for rule in RULES {
            assert!(rule.bug.description.ends_with('.'), "{rule:?}");
            assert!(!rule.bug.also.iter().any(|other| other.id == rule.rule.id), "{rule:?}");
        }
    }
}
