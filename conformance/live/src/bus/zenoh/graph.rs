//! The endpoints of other participants.

use std::collections::HashMap;

use uavspec_model::Endpoint;

use super::token::Token;
use crate::bus::problems::Problems;
use crate::bus::{Event, MAX_ENDPOINTS, Topic};

/// The event for a token that appeared. `None` for own tokens, and for nodes and services.
pub(super) fn appeared(key: &str, own_session: &str) -> Option<Event> {
    let token = match Token::parse(key) {
        Ok(token) => token.filter(|token| token.session != own_session)?,
        Err(problem) => {
            let shown: String = key.chars().take(200).collect();
            return Some(Event::Problem(format!("liveliness token `{}`: {problem}", shown.escape_debug())));
        }
    };
    Some(Event::Endpoint(Endpoint {
        // A session and a number would be shorter, but an invalid peer may use the same pair twice.
        id: key.to_owned(),
        kind: token.kind,
        node: Some(token.node),
        topic: token.topic.name.to_string(),
        type_name: token.topic.type_name.to_string(),
        type_hash: token.topic.type_hash.map(|hash| hash.to_string()),
        qos: Some(token.qos),
        is_matched_by_qos: false,
    }))
}

/// The endpoints that exist.
#[derive(Default)]
pub(super) struct Graph {
    endpoints: HashMap<String, Endpoint>,
    problems: Problems,
}

impl Graph {
    /// Follows an event. Returns the event to report, if any: a token may arrive twice, and the numbers of endpoints
    /// and problems are limited.
    pub(super) fn follow(&mut self, event: Event) -> Option<Event> {
        match event {
            Event::Endpoint(endpoint) if self.endpoints.contains_key(&endpoint.id) => None,
            Event::Endpoint(_) if self.endpoints.len() >= MAX_ENDPOINTS => {
                let text = format!("found more than {MAX_ENDPOINTS} endpoints: ignored the rest");
                self.problems.unreadable(text)
            }
            Event::Endpoint(endpoint) => {
                self.endpoints.insert(endpoint.id.clone(), endpoint.clone());
                Some(Event::Endpoint(endpoint))
            }
            Event::Ended(id) => self.endpoints.remove(&id).map(|_| Event::Ended(id)),
            Event::Problem(text) => self.problems.remark(text),
            _ => Some(event),
        }
    }

    /// The hash of a topic's type, as stated by one of the topic's endpoints.
    pub(super) fn hash(&self, topic: &Topic) -> Option<&str> {
        let is_same =
            |endpoint: &&Endpoint| *endpoint.topic == *topic.name && *endpoint.type_name == *topic.type_name;
        self.endpoints.values().filter(is_same).find_map(|endpoint| endpoint.type_hash.as_deref())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(id: usize) -> String {
        format!("@ros2_lv/0/a/0/{id}/MP/%/%/n/%t/p::msg::dds_::A_/RIHS01_0/2:1:,1:,:,:,,")
    }

    fn appear(graph: &mut Graph, key: &str) -> Option<Event> {
        graph.follow(appeared(key, "me")?)
    }

    #[test]
    fn reports_each_endpoint_of_others_once() {
        let mut graph = Graph::default();
        let Some(Event::Endpoint(endpoint)) = appear(&mut graph, &key(1)) else { panic!("an endpoint") };
        assert!(!endpoint.is_matched_by_qos);
        assert!(appear(&mut graph, &key(1)).is_none());
        assert!(appear(&mut graph, &key(2).replace("/a/", "/me/")).is_none());
        assert!(matches!(graph.follow(Event::Ended(key(1))), Some(Event::Ended(id)) if id == endpoint.id));
        assert!(graph.follow(Event::Ended(key(1))).is_none());
    }

    #[test]
    fn reports_the_limit_of_the_endpoints_once() {
        let mut graph = Graph::default();
        let events = (0..MAX_ENDPOINTS + 5).filter_map(|id| appear(&mut graph, &key(id)));
        let (endpoints, problems): (Vec<_>, Vec<_>) =
            events.partition(|event| matches!(event, Event::Endpoint(_)));
        assert_eq!(endpoints.len(), MAX_ENDPOINTS);
        assert!(matches!(&problems[..], [Event::Unreadable(text)] if text.contains("10000 endpoints")));
    }

    #[test]
    fn limits_the_problems() {
        let mut graph = Graph::default();
        let events = (0..1_000).filter_map(|id| appear(&mut graph, &format!("@ros2_lv/{id}")));
        assert!(events.count() < 500);
    }

    #[test]
    fn finds_the_hash_that_others_state() {
        let mut graph = Graph::default();
        let topic = |name: &str| Topic { name: "/t".into(), type_name: name.into(), type_hash: None };
        assert_eq!(graph.hash(&topic("p/msg/A")), None);
        assert!(appear(&mut graph, &key(1).replace("RIHS01_0", "TypeHashNotSupported")).is_some());
        assert!(appear(&mut graph, &key(2)).is_some());
        assert_eq!(graph.hash(&topic("p/msg/A")), Some("RIHS01_0"));
        assert_eq!(graph.hash(&topic("p/msg/B")), None);
    }
}
