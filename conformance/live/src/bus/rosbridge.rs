//! A client of the rosbridge protocol, version 2.
//!
//! The protocol has no discovery. The node rosapi lists the topics; without it, the user must name them. Messages are
//! JSON. Depending on the version of the server, NaN is `null` or a bare token. Bytes are base64.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::json;
use uavspec_model::Qos;
use uavspec_model::clock::Clock;
use uavspec_model::json::Tree;
use uavspec_model::net::Address;

use super::websocket::{
    CONNECT_LIMIT, Link, Protocol, Service, check_name, excerpt, list, publisher, receive, string,
};
use super::{Bus, Encoding, Event, MAX_ENDPOINTS, Publisher, Received, Topic, nanoseconds};

const SERVICE: Service = Service { example: "rosbridge_websocket (port 9090)", subprotocols: "" };

/// The interval between requests for the topic list.
const LIST_INTERVAL: Duration = Duration::from_secs(5);

/// The maximum time to wait for an answer from rosapi.
const LIST_LIMIT: Duration = Duration::from_secs(10);

/// The service that returns the topic list.
const LIST_SERVICE: &str = "/rosapi/topics";

/// The id of requests for the topic list.
const LIST_ID: &str = "topics";

/// The error that publishing returns.
const ONLY_JSON: &str =
    "rosbridge accepts JSON instead of CDR: to publish, connect with dds://, zenoh:// or foxglove://";

/// A connection to a rosbridge server.
pub(super) struct Rosbridge {
    link: Link,
    /// The time of the next request for the topic list. If a request is pending, the deadline for its answer.
    due: Instant,
    /// True if the topic list has been requested, and the answer is pending.
    is_requested: bool,
    /// The number of unanswered requests for the topic list. A slow answer may arrive after the next request.
    unanswered: usize,
    /// True if the latest request for the topic list failed.
    has_failed: bool,
    /// True if a failure has been reported.
    is_reported: bool,
    /// The listed topics with their types.
    topics: BTreeMap<String, Arc<str>>,
    /// The topics to receive.
    subscribed: HashMap<Arc<str>, Topic>,
    /// The topics to receive if rosapi isn't available, except those from which a message has been received.
    names: Vec<String>,
}

impl Rosbridge {
    /// Connects. `names` are the topics to receive if rosapi isn't available. The error describes the problem.
    pub(super) fn connect(address: &Address, names: &[String]) -> Result<Self, String> {
        Ok(Self {
            link: Link::open(&SERVICE, address, Clock::real().now() + CONNECT_LIMIT)?,
            due: Clock::real().now(),
            is_requested: false,
            unanswered: 0,
            has_failed: false,
            is_reported: false,
            topics: BTreeMap::new(),
            subscribed: HashMap::new(),
            names: names.to_vec(),
        })
    }

    fn message(&mut self, name: &str, payload: &str) -> Result<(), String> {
        let unknown = || format!("received a message on {:?}, which has no subscription", excerpt(name));
        let topic = self.subscribed.get_mut(name).ok_or_else(unknown)?;
        self.names.retain(|waiting| waiting != name);
        if topic.type_name.is_empty()
            && let Some(listed) = self.topics.get(name)
        {
            topic.type_name = Arc::clone(listed);
        }
        let (time, payload) = (nanoseconds(&Clock::real()), payload.as_bytes().to_vec());
        let message = Received::new(topic.clone(), Encoding::Json, time, payload);
        self.link.push(Event::Message(message));
        Ok(())
    }

    /// Handles an answer to a request for the list of topics.
    fn answered(&mut self, response: &Tree<'_>) {
        let Some(unanswered) = self.unanswered.checked_sub(1) else {
            return self.link.problem(format!("received an answer from {LIST_SERVICE} without a request"));
        };
        self.unanswered = unanswered;
        self.pause();
        match self.listed(response) {
            Ok(()) => self.has_failed = false,
            Err(reason) => self.fail(&reason),
        }
    }

    /// Reads the topic list. The error is the reason why it can't be read.
    fn listed(&mut self, response: &Tree<'_>) -> Result<(), String> {
        let values = response.get("values");
        if response.get("result") == Some(&Tree::Bool(false)) {
            return Err(described(values));
        }
        let values = values.ok_or("the member `values` is missing")?;
        let (names, types) = (list(values, "topics")?, list(values, "types")?);
        if names.len() != types.len() {
            return Err(format!("found {} topics but {} types", names.len(), types.len()));
        }
        if names.len() > MAX_ENDPOINTS {
            let limit = format!("{LIST_SERVICE}: ignored the topics after the first {MAX_ENDPOINTS}");
            self.link.unreadable(limit);
        }
        let mut topics = BTreeMap::new();
        for (name, ty) in names.iter().zip(types).take(MAX_ENDPOINTS) {
            match listed_topic(name, ty) {
                Ok((name, ty)) => _ = topics.insert(name.to_owned(), ty.into()),
                Err(problem) => self.link.problem(format!("{LIST_SERVICE}: ignored a topic: {problem}")),
            }
        }
        self.update(topics);
        Ok(())
    }

    /// Reports the differences from the previous list.
    fn update(&mut self, topics: BTreeMap<String, Arc<str>>) {
        for name in self.topics.keys().filter(|name| !topics.contains_key(*name)) {
            self.link.push(Event::Ended(name.clone()));
        }
        for (name, ty) in topics.iter().filter(|(name, ty)| self.topics.get(*name) != Some(ty)) {
            self.link.push(publisher(name.clone(), name, ty));
        }
        self.topics = topics;
    }

    /// Handles a failed request. Continues without a list until the next request.
    fn fail(&mut self, reason: &str) {
        self.has_failed = true;
        self.pause();
        let remedy = if self.names.is_empty() {
            "Start rosapi_node in addition to rosbridge, or specify the topics with --topics"
        } else {
            "Only topics whose full names are given with --topics are received"
        };
        if !std::mem::replace(&mut self.is_reported, true) {
            self.link.problem(format!("{LIST_SERVICE} doesn't list the topics: {reason}. {remedy}"));
        }
        self.subscribe_names();
    }

    /// Sets the time of the next request.
    fn pause(&mut self) {
        (self.due, self.is_requested) = (Clock::real().now() + LIST_INTERVAL, false);
    }

    /// Subscribes to the named topics from which no message has been received. The server finds out their types, and
    /// refuses topics that have no publisher yet.
    fn subscribe_names(&mut self) {
        for name in self.names.clone() {
            self.subscribed.remove(&*name);
            let topic = Topic { name: name.into(), type_name: "".into(), type_hash: None };
            if let Err(problem) = self.subscribe(&topic, &Qos::WEAKEST) {
                self.link.unreadable(format!("{}: {problem}", topic.name.escape_debug()));
            }
        }
    }

    /// Reports a status message of the server. An error means that the server refuses a topic, unless the topic list
    /// was requested.
    fn status(&mut self, status: &Tree<'_>) {
        let text = format!("the server reports a problem: {}", described(status.get("msg")));
        // Subscriptions to named topics are repeated until the topics have a publisher.
        let is_tried = self.has_failed || status.get("id").and_then(Tree::as_str) == Some(LIST_ID);
        match string(status, "level") {
            Ok("info" | "none") => {}
            Ok("error") if !is_tried => self.link.unreadable(text),
            _ => self.link.problem(text),
        }
    }

    fn request_list(&mut self) {
        (self.due, self.is_requested) = (Clock::real().now() + LIST_LIMIT, true);
        self.unanswered = self.unanswered.saturating_add(1);
        let request = json!({ "op": "call_service", "id": LIST_ID, "service": LIST_SERVICE, "args": {} });
        // An error closes the connection, which results in an event.
        let _ = self.link.request(&request);
    }
}

impl Protocol for Rosbridge {
    fn link(&mut self) -> &mut Link {
        &mut self.link
    }

    fn text(&mut self, text: &str) -> Result<(), String> {
        let (operation, places) = Tree::read_with_places(text).map_err(|error| error.to_string())?;
        match string(&operation, "op")? {
            "publish" => {
                let payload = place(&operation, places, "msg").and_then(|place| text.get(place));
                self.message(string(&operation, "topic")?, payload.ok_or("the member `msg` is missing")?)
            }
            "service_response" if is_list(&operation) => {
                self.answered(&operation);
                Ok(())
            }
            "status" => {
                self.status(&operation);
                Ok(())
            }
            "fragment" => {
                Err("received a part of a message: configure rosbridge without fragment_size".to_owned())
            }
            "png" => Err("received a message in PNG, which wasn't requested".to_owned()),
            _ => Ok(()),
        }
    }

    fn binary(&mut self, _: &[u8]) -> Result<(), String> {
        Err("received a binary message, which wasn't requested".to_owned())
    }

    fn poll(&mut self) -> Option<Instant> {
        if self.due <= Clock::real().now() {
            if self.is_requested {
                self.fail(&format!("no answer within {LIST_LIMIT:?}"));
            } else {
                self.request_list();
            }
        }
        Some(self.due)
    }
}

impl Bus for Rosbridge {
    fn receive(&mut self, deadline: Instant) -> Option<Event> {
        receive(self, deadline)
    }

    /// Subscribes to a topic. The server chooses the quality of service.
    fn subscribe(&mut self, topic: &Topic, _: &Qos) -> Result<(), String> {
        check_name("topic", &topic.name)?;
        check_name("type", &topic.type_name)?;
        if self.subscribed.contains_key(&topic.name) {
            return Ok(());
        }
        if self.subscribed.len() >= MAX_ENDPOINTS {
            return Err(format!("expected at most {MAX_ENDPOINTS} subscriptions"));
        }
        let mut request = json!({ "op": "subscribe", "topic": &*topic.name, "compression": "none" });
        // Without a type, the server looks for a publisher.
        if !topic.type_name.is_empty() {
            request["type"] = (*topic.type_name).into();
        }
        self.link.request(&request)?;
        self.subscribed.insert(Arc::clone(&topic.name), topic.clone());
        Ok(())
    }

    fn advertise(&mut self, _: &Topic, _: &Qos) -> Result<Publisher, String> {
        Err(ONLY_JSON.to_owned())
    }

    fn publish(&mut self, _: Publisher, _: &[u8]) -> Result<(), String> {
        Err(ONLY_JSON.to_owned())
    }
}

/// The position of the value of the member `key`.
fn place(operation: &Tree<'_>, places: Vec<Range<usize>>, key: &str) -> Option<Range<usize>> {
    let Tree::Object(members) = operation else { return None };
    members.iter().zip(places).find(|((known, _), _)| known == key).map(|(_, place)| place)
}

/// True if a response belongs to a request for the topic list: it names the service, or no service.
fn is_list(response: &Tree<'_>) -> bool {
    response.get("service").is_none_or(|name| name.as_str() == Some(LIST_SERVICE))
}

/// The server's description of a problem.
fn described(value: Option<&Tree<'_>>) -> String {
    let text = value.and_then(Tree::as_str).map(|text| format!("{:?}", excerpt(text)));
    text.unwrap_or_else(|| value.map_or_else(|| "no text".to_owned(), Tree::excerpt))
}

/// The name and the type of a listed topic.
fn listed_topic<'t>(name: &'t Tree<'_>, ty: &'t Tree<'_>) -> Result<(&'t str, &'t str), String> {
    let text =
        |value: &'t Tree<'_>| value.as_str().ok_or_else(|| format!("expected a string, found {value}"));
    let (name, ty) = (text(name)?, text(ty)?);
    check_name("topic", name)?;
    check_name("type", ty)?;
    Ok((name, ty))
}

#[cfg(test)]
mod tests;
