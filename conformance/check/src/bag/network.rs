//! The publishers and subscribers in the recording of a live vehicle.

use std::collections::BTreeMap;

use serde::Serialize;
use uavspec_model::text::{plural, shown};
use uavspec_model::{Endpoint, EndpointKind};

use super::open::BagChannel;
use crate::Line;
use crate::limits::{MAX_ENDPOINTS, MAX_TOPICS};

/// The publishers and subscribers of a topic on a bus.
#[derive(Clone, Debug, Default, Serialize, schemars::JsonSchema)]
pub struct BusTopic {
    /// The topic.
    pub topic: String,
    /// The type, such as `px4_msgs/msg/VehicleStatus`.
    #[serde(rename = "type")]
    pub type_name: String,
    /// The ROS type hash, if an endpoint announces it.
    pub type_hash: Option<String>,
    /// The release whose definition the messages were checked against, such as `px4@1.16`.
    pub release: Option<String>,
    /// The mean number of messages per second, with three decimals.
    #[serde(rename = "rate_hz")]
    pub rate: Option<f64>,
    /// The publishers, including those that ended.
    pub publishers: Vec<BusEndpoint>,
    /// The subscribers, including those that ended.
    pub subscribers: Vec<BusEndpoint>,
}

/// A publisher or subscriber on a bus.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct BusEndpoint {
    /// The node or participant, if it states its name.
    pub node: Option<String>,
    /// The quality of service in words, if it is announced.
    pub qos: Option<String>,
}

/// A topic with its endpoints, by id.
#[derive(Default)]
struct Known {
    type_name: String,
    type_hash: Option<String>,
    publishers: BTreeMap<String, BusEndpoint>,
    subscribers: BTreeMap<String, BusEndpoint>,
}

/// The endpoints that were discovered, by topic.
#[derive(Default)]
pub(super) struct Network(BTreeMap<String, Known>);

impl Network {
    pub(super) fn add(&mut self, endpoint: &Endpoint) {
        let escaped = |text: &String| text.escape_debug().to_string();
        let topic = escaped(&endpoint.topic);
        if self.0.len() >= MAX_TOPICS && !self.0.contains_key(&topic) {
            return;
        }
        let known = self.0.entry(topic).or_default();
        if known.type_name.is_empty() {
            known.type_name = escaped(&endpoint.type_name);
        }
        if known.type_hash.is_none() {
            known.type_hash = endpoint.type_hash.as_ref().map(escaped);
        }
        let endpoints = match endpoint.kind {
            EndpointKind::Publisher => &mut known.publishers,
            EndpointKind::Subscriber => &mut known.subscribers,
        };
        if endpoints.len() < MAX_ENDPOINTS || endpoints.contains_key(&endpoint.id) {
            let (node, qos) = (endpoint.node.as_ref().map(escaped), endpoint.qos.as_ref());
            let qos = qos.map(ToString::to_string);
            endpoints.insert(endpoint.id.clone(), BusEndpoint { node, qos });
        }
    }

    /// The topics with the results of their channels.
    pub(super) fn topics(self, channels: &[BagChannel]) -> Vec<BusTopic> {
        let topics = self.0.into_iter().map(|(topic, known)| {
            let channel = channels.iter().find(|channel| channel.topic == topic);
            BusTopic {
                release: channel.and_then(|channel| channel.release.clone()),
                rate: channel.and_then(|channel| channel.rate),
                topic,
                type_name: known.type_name,
                type_hash: known.type_hash,
                publishers: known.publishers.into_values().collect(),
                subscribers: known.subscribers.into_values().collect(),
            }
        });
        topics.collect()
    }
}

/// The line about the topics in reports for people.
pub(super) fn network_line(topics: &[BusTopic]) -> Option<Line> {
    let count = |endpoints: fn(&BusTopic) -> &[BusEndpoint], noun| {
        plural(topics.iter().map(|topic| endpoints(topic).len() as u64).sum::<u64>(), noun)
    };
    let (publishers, subscribers) =
        (count(|topic| &topic.publishers, "publisher"), count(|topic| &topic.subscribers, "subscriber"));
    let text = format!("{}, {publishers}, {subscribers}", plural(topics.len(), "topic"));
    let items = topics.iter().map(|topic| (topic.topic.as_str(), shown(&topic.description())));
    (!topics.is_empty()).then(|| Line::new("bus", text).list("topic", items))
}

impl BusTopic {
    /// The type, the release, the rate and the endpoints.
    fn description(&self) -> String {
        let mut parts = vec![self.type_name.clone()];
        parts.extend(self.release.clone());
        parts.extend(self.rate.map(|rate| format!("{rate:.1} Hz")));
        for (endpoints, noun) in [(&self.publishers, "publisher"), (&self.subscribers, "subscriber")] {
            if !endpoints.is_empty() {
                parts.push(format!("{}{}", plural(endpoints.len(), noun), qualities(endpoints)));
            }
        }
        parts.join(", ")
    }
}

/// The distinct quality-of-service settings, in parentheses.
fn qualities(endpoints: &[BusEndpoint]) -> String {
    let mut different: Vec<&str> = endpoints.iter().filter_map(|endpoint| endpoint.qos.as_deref()).collect();
    different.sort_unstable();
    different.dedup();
    if different.is_empty() { String::new() } else { format!(" ({})", different.join("; ")) }
}
