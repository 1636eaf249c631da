//! Bugs that the server can be given: each breaks one rule for Flockwave servers.
//!
//! A bug changes messages on their way out, or it is a behaviour that stands where the right one stands, which then
//! asks whether the rule is to be broken.

mod basics;
mod envelope;
mod operation;
mod status;
mod transport;

use serde_json::{Value, json};

use super::message;

/// A bug.
#[derive(Debug)]
pub struct Bug {
    /// The rule that it breaks.
    pub rule: &'static str,
    /// What the server does.
    pub what: &'static str,
    /// Rules that can't be kept then.
    pub also: &'static [&'static str],
    change: Change,
}

/// How a bug comes about.
#[derive(Clone, Copy, Debug)]
pub(super) enum Change {
    /// Messages are changed on their way out.
    Message(fn(&mut Outgoing<'_>)),
    /// The server behaves otherwise.
    Behaviour,
}

/// All bugs, by what they are about.
const BUGS: [&[Bug]; 5] = [envelope::BUGS, transport::BUGS, basics::BUGS, status::BUGS, operation::BUGS];

/// All bugs.
pub fn bugs() -> impl Iterator<Item = &'static Bug> {
    BUGS.into_iter().flatten()
}

/// The bug that breaks a rule.
pub fn bug(rule: &str) -> Option<&'static Bug> {
    bugs().find(|bug| bug.rule == rule)
}

impl Bug {
    /// A bug that changes messages.
    const fn message(rule: &'static str, what: &'static str, change: fn(&mut Outgoing<'_>)) -> Self {
        Self { rule, what, also: &[], change: Change::Message(change) }
    }

    /// A bug in what the server does.
    const fn behaviour(rule: &'static str, what: &'static str) -> Self {
        Self { rule, what, also: &[], change: Change::Behaviour }
    }

    /// The same, with the rules that can't be kept then.
    const fn with(self, also: &'static [&'static str]) -> Self {
        Self { also, ..self }
    }

    /// Changes what is to be sent.
    pub(super) fn apply(&self, outgoing: &mut Outgoing<'_>) {
        if let Change::Message(change) = self.change {
            change(outgoing);
        }
    }
}

/// A message on its way out, and what bugs made of it.
pub(super) struct Outgoing<'r> {
    /// Messages that go before the message.
    before: Vec<Value>,
    /// The message, unless it is dropped.
    message: Option<Value>,
    /// Messages that follow it.
    after: Vec<Value>,
    /// The body of the request that it answers.
    request: Option<&'r Value>,
    /// How many messages went over the connection, with this one.
    number: u64,
    write: fn(&Value) -> String,
}

impl<'r> Outgoing<'r> {
    pub(super) fn new(message: Value, request: Option<&'r Value>, number: u64) -> Self {
        let (before, after) = (Vec::new(), Vec::new());
        Self { before, message: Some(message), after, request, number, write: Value::to_string }
    }

    /// What is to be sent, in this order.
    pub(super) fn into_texts(self) -> Vec<String> {
        let messages = self.before.iter().chain(&self.message).chain(&self.after);
        messages.map(|message| (self.write)(message)).collect()
    }

    /// The message.
    fn message(&mut self) -> &mut Value {
        self.message.get_or_insert(Value::Null)
    }

    /// The type of its body.
    fn kind(&self) -> &str {
        self.message.as_ref().and_then(|message| message["body"]["type"].as_str()).unwrap_or_default()
    }

    /// The type of the request that it answers.
    fn asked(&self) -> Option<&str> {
        self.request.map(|body| body.get("type").and_then(Value::as_str).unwrap_or_default())
    }

    /// The ids or paths that the request asked for.
    fn asked_for(&self) -> Vec<&'r str> {
        let list = self.request.and_then(|body| body.get("ids").or_else(|| body.get("paths")));
        list.and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str).collect()
    }

    /// Whether nobody asked for it.
    fn is_notification(&self) -> bool {
        self.request.is_none()
    }

    /// The body, where it has this type.
    fn body_of(&mut self, kind: &str) -> Option<&mut Value> {
        if self.kind() == kind { Some(&mut self.message()["body"]) } else { None }
    }

    /// The body of a notification of this type.
    fn notification_of(&mut self, kind: &str) -> Option<&mut Value> {
        if self.is_notification() { self.body_of(kind) } else { None }
    }

    /// The first state in a message about UAVs.
    fn state(&mut self) -> Option<&mut Value> {
        self.body_of("UAV-INF")?.get_mut("status")?.as_object_mut()?.values_mut().next()
    }

    /// Lets another message follow.
    fn follow(&mut self, refs: Option<&str>, body: Value) {
        let message = message::envelope(&format!("x{}", self.number), refs, body);
        self.after.push(message);
    }

    /// Sends another message first.
    fn precede(&mut self, body: Value) {
        let message = message::envelope(&format!("x{}", self.number), None, body);
        self.before.push(message);
    }

    /// Takes the last thing that was asked for out of all maps of the response.
    fn lose_last(&mut self, kinds: &[&str]) {
        if self.is_notification() || !kinds.contains(&self.kind()) {
            return;
        }
        let Some(last) = self.asked_for().last().copied() else { return };
        let Some(body) = self.message()["body"].as_object_mut() else { return };
        for map in body.values_mut().filter_map(Value::as_object_mut) {
            map.remove(last);
        }
    }
}

/// The body of a notification about an operation that gets on.
fn progress(receipt: &Value) -> Value {
    json!({ "type": "ASYNC-ST", "id": receipt, "progress": { "percentage": 1 } })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_rule_has_one_bug_that_says_what_it_is() {
        let mut rules: Vec<&str> = bugs().map(|bug| bug.rule).collect();
        let count = rules.len();
        rules.sort_unstable();
        rules.dedup();
        assert_eq!(rules.len(), count);
        for bug in bugs() {
            assert!(bug.rule.starts_with("FW-") && bug.what.ends_with('.'), "{bug:?}");
            assert!(!bug.also.contains(&bug.rule), "{bug:?}");
        }
    }
}
