//! The publishers and subscribers of a live vehicle, for rules that compare them.

use std::collections::BTreeMap;

use crate::model::Endpoint;

/// The maximum number of endpoints of a topic that are compared.
const MAX_PER_TOPIC: usize = 256;

/// The maximum number of topics.
const MAX_TOPICS: usize = 10_000;

/// The known endpoints, by topic.
#[derive(Default)]
pub(super) struct Endpoints(BTreeMap<String, Vec<Endpoint>>);

impl Endpoints {
    /// Adds an endpoint, or replaces the one with the same id. Returns the other endpoints of its topic.
    pub(super) fn add(&mut self, endpoint: &Endpoint) -> impl Iterator<Item = &Endpoint> {
        self.remove(&endpoint.id);
        let has_space = self.0.len() < MAX_TOPICS || self.0.contains_key(&endpoint.topic);
        if has_space {
            let all = self.0.entry(endpoint.topic.clone()).or_default();
            if all.len() < MAX_PER_TOPIC {
                all.push(endpoint.clone());
            }
        }
        let all = self.0.get(&endpoint.topic).map(Vec::as_slice).unwrap_or_default();
        let id = endpoint.id.clone();
        all.iter().filter(move |other| other.id != id)
    }

    /// Removes an endpoint.
    pub(super) fn remove(&mut self, id: &str) {
        self.0.retain(|_, all| {
            all.retain(|endpoint| endpoint.id != id);
            !all.is_empty()
        });
    }
}

/// The name of an endpoint in messages.
pub(super) fn name(endpoint: &Endpoint) -> String {
    let name = endpoint.node.as_ref().unwrap_or(&endpoint.id);
    format!("{} `{}`", endpoint.kind, name.escape_debug())
}
