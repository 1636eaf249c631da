//! The publishers and subscribers of a live vehicle, for rules that compare them.
//!
//! Buses announce an endpoint again when they learn more about it, such as the name of its node. A pair of endpoints is
//! therefore reported once, at the end, with all known facts about it.

use std::collections::BTreeMap;

use uavspec_model::Endpoint;

use super::prelude::*;
use crate::limits::{MAX_PAIRS, MAX_PER_TOPIC, MAX_TOPICS};

/// Compares two endpoints of a topic. `None` if the rule doesn't apply to the pair; otherwise, the violations.
type Compare = fn(&Endpoint, &Endpoint) -> Option<Vec<Detail>>;

/// Compares all endpoints of each topic with each other.
pub(super) struct Pairs {
    compare: Compare,
    /// The endpoints that haven't ended, by topic.
    known: BTreeMap<String, Vec<Endpoint>>,
    /// The pairs to which the rule applies, by their ids.
    compared: BTreeMap<(String, String), Pair>,
}

/// Two endpoints of a topic.
struct Pair {
    endpoints: [Endpoint; 2],
    violations: Vec<Detail>,
    /// The location of the announcement that showed the violations.
    location: Location,
}

impl Pairs {
    pub(super) fn new(compare: Compare) -> Self {
        Self { compare, known: BTreeMap::new(), compared: BTreeMap::new() }
    }

    /// Adds an endpoint, or replaces the one with the same id. Returns the other endpoints of its topic.
    fn add(&mut self, endpoint: &Endpoint) -> Vec<Endpoint> {
        self.endpoint_ended(&endpoint.id);
        if self.known.len() >= MAX_TOPICS && !self.known.contains_key(&endpoint.topic) {
            return Vec::new();
        }
        let known = self.known.entry(endpoint.topic.clone()).or_default();
        let others = known.clone();
        if known.len() < MAX_PER_TOPIC {
            known.push(endpoint.clone());
        }
        others
    }

    fn compare(&mut self, endpoints: [Endpoint; 2], location: Location) {
        let [first, second] = &endpoints;
        let key = (first.id.clone().min(second.id.clone()), first.id.clone().max(second.id.clone()));
        let Some(violations) = (self.compare)(first, second) else { return };
        let has_space = self.compared.len() < MAX_PAIRS;
        match self.compared.get_mut(&key) {
            // An endpoint that corrects its quality of service has violated the rule before.
            Some(pair) if violations.is_empty() && !pair.violations.is_empty() => {}
            Some(pair) => {
                let location = if pair.violations.is_empty() { location } else { pair.location };
                *pair = Pair { endpoints, violations, location };
            }
            None if has_space => _ = self.compared.insert(key, Pair { endpoints, violations, location }),
            None => {}
        }
    }
}

impl Checker for Pairs {
    fn opened(&mut self, _: &Channel<'_>, _: &mut RuleContext<'_>) -> Interest {
        Interest::Nothing
    }

    fn endpoint(&mut self, endpoint: &Endpoint, location: Location, _: &mut RuleContext<'_>) {
        for other in self.add(endpoint) {
            self.compare([endpoint.clone(), other], location);
        }
    }

    fn endpoint_ended(&mut self, id: &str) {
        self.known.retain(|_, known| {
            known.retain(|endpoint| endpoint.id != id);
            !known.is_empty()
        });
    }

    fn end(&mut self, context: &mut RuleContext<'_>) {
        let mut pairs: Vec<Pair> = std::mem::take(&mut self.compared).into_values().collect();
        pairs.sort_by_key(|pair| pair.location);
        for Pair { endpoints: [endpoint, _], violations, location } in pairs {
            context.covered();
            let topic = endpoint.topic.escape_debug().to_string();
            for detail in violations {
                context.violation(&topic, location, || detail);
            }
        }
    }
}

/// The name of an endpoint in messages.
pub(super) fn name(endpoint: &Endpoint) -> String {
    let name = endpoint.node.as_ref().unwrap_or(&endpoint.id);
    format!("{} `{}`", endpoint.kind, name.escape_debug())
}
