//! Asks a flight controller for its definitions of the topics that an application uses.

use std::collections::{HashSet, VecDeque};

use globset::GlobSet;
use uavspec_model::text::plural;
use uavspec_model::{ApplicationType, Endpoint};
use uavspec_rules::definitions::unversioned;
use uavspec_rules::px4::Sent;
use uavspec_runtime::Message as _;
use uavspec_types::px4::{MessageFormatRequest, MessageFormatResponse};

use super::namespace::Namespace;
use super::role::Role;

/// The time from the discovery of the first topic to the first question, in µs. During this time, the flight controller
/// discovers the publisher of the questions.
const START_TIME: u64 = 300_000;

/// The time after which an unanswered question is repeated, in µs.
const RETRY_TIME: u64 = 300_000;

/// The maximum number of times that a question is sent.
const ATTEMPTS: u32 = 5;

/// The number of unanswered questions after which the flight controller counts as silent.
const MAX_SILENT: usize = 2;

/// The maximum number of topics in a note.
const MAX_LISTED: usize = 8;

/// The questions of an application to a flight controller. PX4 stores only one question, so the next one is sent after
/// the response.
pub(super) struct Inquiry {
    /// The topics that the application defines, without their folder and version.
    defined: HashSet<String>,
    namespace: Namespace,
    selected: Option<GlobSet>,
    known: HashSet<String>,
    waiting: VecDeque<String>,
    current: Option<Question>,
    answered: usize,
    unanswered: Vec<String>,
    refused: Vec<String>,
}

/// A question that hasn't been answered yet.
struct Question {
    topic: String,
    attempts: u32,
    due: u64,
}

impl Inquiry {
    /// Creates the questions of an application. `selected` are the topics that the user selected, if any.
    pub(super) fn new(
        application: &[ApplicationType],
        namespace: Namespace,
        selected: Option<GlobSet>,
    ) -> Self {
        Self {
            defined: application.iter().flat_map(|ty| ty.topics.iter().cloned()).collect(),
            namespace,
            selected,
            known: HashSet::new(),
            waiting: VecDeque::new(),
            current: None,
            answered: 0,
            unanswered: Vec::new(),
            refused: Vec::new(),
        }
    }

    /// The name that a question uses for the topic of an endpoint, without a namespace. `None` if the application
    /// doesn't use the topic.
    fn asked_name(&self, topic: &str) -> Option<String> {
        let (folder, name) = self.namespace.strip(topic)?.rsplit_once('/')?;
        let name = unversioned(name).filter(|_| !self.defined.contains(name)).unwrap_or(name);
        let is_selected = self.selected.as_ref().is_none_or(|selected| selected.is_match(topic));
        (is_selected && self.defined.contains(name)).then(|| format!("{folder}/{name}"))
    }

    /// Asks the next question.
    fn proceed(&mut self, due: u64) {
        let next = self.waiting.pop_front();
        self.current = next.map(|topic| Question { topic, attempts: 0, due });
    }

    fn is_silent(&self) -> bool {
        self.answered == 0 && self.unanswered.len() >= MAX_SILENT
    }
}

impl Role for Inquiry {
    fn folder(&self) -> &'static str {
        "in"
    }

    fn published(&self) -> &'static [&'static str] {
        &[MessageFormatRequest::NAME]
    }

    fn received(&self) -> &'static [&'static str] {
        &[MessageFormatResponse::NAME]
    }

    fn discovered(&mut self, endpoint: &Endpoint, now: u64) {
        let Some(topic) = self.asked_name(&endpoint.topic) else { return };
        let is_first = self.known.is_empty();
        if !self.known.insert(topic.clone()) {
            return;
        }
        self.waiting.push_back(topic);
        if self.current.is_none() {
            self.proceed(if is_first { now + START_TIME } else { now });
        }
    }

    fn receive(&mut self, message: &Sent, now: u64) -> Vec<Sent> {
        let Some(response) = message.read::<MessageFormatResponse>() else { return Vec::new() };
        // Other applications ask as well.
        let Some(question) = self.current.take_if(|question| {
            question.attempts > 0 && response.topic_name.bytes() == question.topic.as_bytes()
        }) else {
            return Vec::new();
        };
        self.answered += 1;
        if !response.success {
            self.refused.push(question.topic);
        }
        self.proceed(now);
        self.tick(now)
    }

    fn tick(&mut self, now: u64) -> Vec<Sent> {
        if let Some(question) = self.current.take_if(|question| question.attempts >= ATTEMPTS) {
            self.unanswered.push(question.topic);
            self.proceed(now);
        }
        if self.is_silent() {
            self.unanswered.extend(self.current.take().map(|question| question.topic));
            self.unanswered.extend(self.waiting.drain(..));
        }
        let Some(question) = &mut self.current else { return Vec::new() };
        question.attempts += 1;
        question.due = now + RETRY_TIME;
        // Longer names don't exist.
        let Ok(topic_name) = question.topic.parse() else { return Vec::new() };
        let protocol_version = MessageFormatRequest::LATEST_PROTOCOL_VERSION;
        vec![Sent::new(&MessageFormatRequest { timestamp: 0, protocol_version, topic_name })]
    }

    fn next_tick(&self) -> Option<u64> {
        self.current.as_ref().map(|question| question.due)
    }

    fn notes(&self) -> Vec<String> {
        let waiting = self.current.iter().map(|question| &question.topic).chain(&self.waiting);
        let unanswered: Vec<&String> = self.unanswered.iter().chain(waiting).collect();
        let refused: Vec<&String> = self.refused.iter().collect();
        let unasked = "no topic of the application exists in /fmu/in or /fmu/out: nothing was compared";
        let silent = "the vehicle answered no question about its definitions: only PX4 1.15 and later \
                      answer, and only over uXRCE-DDS";
        match (self.known.len(), self.answered) {
            (0, _) => vec![unasked.to_owned()],
            (_, 0) => vec![silent.to_owned()],
            _ => [("didn't answer for", unanswered), ("doesn't know", refused)]
                .into_iter()
                .filter(|(_, topics)| !topics.is_empty())
                .map(|(verb, topics)| format!("the vehicle {verb} {}", listed(&topics)))
                .collect(),
        }
    }
}

/// A list of topics that weren't compared.
fn listed(topics: &[&String]) -> String {
    let names: Vec<&str> = topics.iter().take(MAX_LISTED).map(|topic| topic.as_str()).collect();
    let more = if topics.len() > MAX_LISTED { ", …" } else { "" };
    format!(
        "{} of the application (not compared): {}{more}",
        plural(topics.len(), "topic"),
        names.join(", ").escape_debug()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inquiry() -> Inquiry {
        let ty = |topic: &str| ApplicationType {
            name: format!("px4_msgs/msg/{topic}"),
            topics: vec![topic.to_owned()],
            version: None,
            hash: 0,
            fields: String::new(),
        };
        Inquiry::new(&["wind", "vehicle_status"].map(ty), Namespace::default(), None)
    }

    fn discover(inquiry: &mut Inquiry, topic: &str) {
        inquiry.discovered(&Endpoint::publisher(topic), 0);
    }

    fn asked(sent: &[Sent]) -> Vec<String> {
        let request = |sent: &Sent| sent.read::<MessageFormatRequest>().expect("a request");
        sent.iter().map(|sent| request(sent).topic_name.as_str().expect("text").to_owned()).collect()
    }

    fn answer(inquiry: &mut Inquiry, topic: &str, success: bool) -> Vec<String> {
        let topic_name = topic.parse().expect("a short name");
        let response = MessageFormatResponse { topic_name, success, ..MessageFormatResponse::default() };
        asked(&inquiry.receive(&Sent::new(&response), 0))
    }

    #[test]
    fn asks_once_for_each_topic_without_its_version() {
        let mut inquiry = inquiry();
        for topic in ["/fmu/out/vehicle_status_v3", "/fmu/out/vehicle_status", "/fmu/out/other", "/wind"] {
            discover(&mut inquiry, topic);
        }
        discover(&mut inquiry, "/fmu/in/wind");
        assert_eq!(inquiry.next_tick(), Some(START_TIME));
        assert_eq!(asked(&inquiry.tick(START_TIME)), ["/fmu/out/vehicle_status"]);
        assert!(answer(&mut inquiry, "/fmu/in/wind", true).is_empty());
        assert_eq!(answer(&mut inquiry, "/fmu/out/vehicle_status", true), ["/fmu/in/wind"]);
        assert!(answer(&mut inquiry, "/fmu/in/wind", false).is_empty());
        assert_eq!(inquiry.next_tick(), None);
        let notes = inquiry.notes();
        assert_eq!(
            notes,
            ["the vehicle doesn't know 1 topic of the application (not compared): /fmu/in/wind"]
        );
    }

    #[test]
    fn repeats_questions_and_gives_up() {
        let mut inquiry = inquiry();
        assert!(inquiry.notes()[0].starts_with("no topic of the application exists"));
        discover(&mut inquiry, "/fmu/out/wind");
        discover(&mut inquiry, "/fmu/in/wind");
        let mut sent = 0;
        while let Some(due) = inquiry.next_tick() {
            sent += inquiry.tick(due).len();
        }
        assert_eq!(sent, 10);
        assert!(inquiry.notes()[0].starts_with("the vehicle answered no question"));
    }
}
