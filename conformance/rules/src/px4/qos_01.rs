//! `PX-QOS-01`.

use std::time::Duration;

use uavspec_model::{Durability, Endpoint, EndpointKind, Liveliness, Qos, Reliability};

use super::endpoints::{Pairs, name};
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-QOS-01",
    name: "Compatible quality of service",
    level: Level::Must,
    status: Status::Normative,
    statement: "Each publisher of a topic offers at least the quality of service that each subscriber \
                requests.",
    source: "DDS 1.4, 2.2.3: reliability, durability, deadline and liveliness",
    applies_to: "publishers and subscribers in a DDS domain",
    why: "If a publisher offers less than a subscriber requests, DDS doesn't connect them: the subscriber \
          receives no messages, and usually no error either. PX4 offers best effort and transient local.",
    example: "publisher  /fmu/out/vehicle_status: best effort, transient local\n\
              subscriber /fmu/out/vehicle_status: reliable, volatile",
    fix: "Request no more than the publisher offers. For the topics of PX4, subscribe with best effort \
          (`rmw_qos_profile_sensor_data` in ROS 2).",
})
.check(Check::State(|| Box::new(Pairs::new(violations))))
.bug(Bug::reliable_subscriber(
    Side::Component,
    "The component requests reliable delivery of arming_check_request, and receives no messages.",
))
.mutants(&[
    Mutant::mcap("a subscriber that requests reliable delivery", |_, bag| {
        Some(with_subscriber(bag, Qos { reliability: Reliability::Reliable, ..Qos::PX4 }))
    }),
    Mutant::mcap("a subscriber that requests a higher durability", |_, bag| {
        Some(with_subscriber(bag, Qos { durability: Durability::Persistent, ..Qos::PX4 }))
    }),
    Mutant::mcap("a subscriber that requests a deadline", |_, bag| {
        Some(with_subscriber(bag, Qos { deadline: Some(Duration::from_secs(1)), ..Qos::PX4 }))
    }),
    Mutant::mcap("a subscriber that requests manual liveliness", |_, bag| {
        Some(with_subscriber(bag, Qos { liveliness: Liveliness::ManualByTopic, ..Qos::PX4 }))
    }),
]);

/// The policies for which one endpoint offers less than the other requests.
fn violations(endpoint: &Endpoint, other: &Endpoint) -> Option<Vec<Detail>> {
    let (publisher, subscriber) = match (endpoint.kind, other.kind) {
        (EndpointKind::Publisher, EndpointKind::Subscriber) => (endpoint, other),
        (EndpointKind::Subscriber, EndpointKind::Publisher) => (other, endpoint),
        _ => return None,
    };
    let (offered, requested) = (publisher.qos.as_ref()?, subscriber.qos.as_ref()?);
    // Endpoints in different partitions don't exchange messages anyway. A partition may be a pattern.
    let is_matched = publisher.is_matched_by_qos && offered.partitions == requested.partitions;
    let conflicts = is_matched.then(|| conflicts(offered, requested))?;
    Some(conflicts.into_iter().map(|conflict| conflict.detail(publisher, subscriber)).collect())
}

/// A policy for which a publisher offers less than a subscriber requests.
struct Conflict {
    policy: &'static str,
    offered: String,
    requested: String,
}

impl Conflict {
    fn detail(self, publisher: &Endpoint, subscriber: &Endpoint) -> Detail {
        let Self { policy, offered, requested } = self;
        let (publisher, subscriber) = (name(publisher), name(subscriber));
        let text = format!(
            "{subscriber} requests {policy} {requested}, but {publisher} offers {offered}: the subscriber receives \
             nothing"
        );
        Detail::new(text).expected(format!("{policy} {offered} at most")).actual(requested)
    }
}

/// The policies for which a publisher offers less than a subscriber requests.
fn conflicts(offered: &Qos, requested: &Qos) -> Vec<Conflict> {
    let time =
        |time: Option<Duration>| time.map_or_else(|| "unlimited".to_owned(), |time| format!("{time:?}"));
    // An unlimited time is longer than any other.
    let is_longer = |offered: Option<Duration>, requested: Option<Duration>| {
        requested.is_some_and(|requested| offered.is_none_or(|offered| offered > requested))
    };
    let policies = [
        (
            "reliability",
            offered.reliability < requested.reliability,
            (offered.reliability.to_string(), requested.reliability.to_string()),
        ),
        (
            "durability",
            offered.durability < requested.durability,
            (offered.durability.to_string(), requested.durability.to_string()),
        ),
        (
            "deadline",
            is_longer(offered.deadline, requested.deadline),
            (time(offered.deadline), time(requested.deadline)),
        ),
        (
            "liveliness",
            offered.liveliness < requested.liveliness,
            (offered.liveliness.to_string(), requested.liveliness.to_string()),
        ),
        (
            "liveliness lease",
            is_longer(offered.lease, requested.lease),
            (time(offered.lease), time(requested.lease)),
        ),
    ];
    let conflicts = policies.into_iter().filter(|(_, is_conflict, _)| *is_conflict);
    conflicts.map(|(policy, _, (offered, requested))| Conflict { policy, offered, requested }).collect()
}

/// Adds a subscriber to the topic of the first endpoint.
fn with_subscriber(mut bag: Bag, qos: Qos) -> Bag {
    if let Some(publisher) = bag.endpoints.first().cloned() {
        bag.endpoints.push(Endpoint {
            id: "application".to_owned(),
            kind: EndpointKind::Subscriber,
            node: Some("/ground_station".to_owned()),
            qos: Some(qos),
            ..publisher
        });
    }
    bag
}

#[cfg(test)]
mod tests {
    use super::*;

    fn policies(offered: &Qos, requested: &Qos) -> Vec<&'static str> {
        conflicts(offered, requested).iter().map(|conflict| conflict.policy).collect()
    }

    #[test]
    fn equal_and_lower_requests_are_compatible() {
        let strong = Qos {
            reliability: Reliability::Reliable,
            durability: Durability::Persistent,
            deadline: Some(Duration::from_millis(10)),
            liveliness: Liveliness::ManualByTopic,
            lease: Some(Duration::from_secs(1)),
            ..Qos::PX4
        };
        let weak = Qos { durability: Durability::Volatile, ..Qos::PX4 };
        for (offered, requested) in
            [(&strong, &strong), (&weak, &weak), (&strong, &weak), (&strong, &Qos::PX4)]
        {
            assert_eq!(policies(offered, requested), Vec::<&str>::new());
        }
        let all = ["reliability", "durability", "deadline", "liveliness", "liveliness lease"];
        assert_eq!(policies(&weak, &strong), all);
    }

    #[test]
    fn times_are_compared() {
        let deadline = |time| Qos { deadline: time, ..Qos::PX4 };
        let [short, long] = [10, 20].map(|time| Some(Duration::from_millis(time)));
        assert_eq!(policies(&deadline(long), &deadline(short)), ["deadline"]);
        assert_eq!(policies(&deadline(short), &deadline(long)), Vec::<&str>::new());
        assert_eq!(policies(&deadline(short), &deadline(None)), Vec::<&str>::new());
        assert_eq!(policies(&deadline(None), &deadline(long)), ["deadline"]);
    }
}
