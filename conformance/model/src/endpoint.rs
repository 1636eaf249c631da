//! Publishers and subscribers on a bus, and the quality of service that they offer or request.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;
use std::time::Duration;

/// A publisher or a subscriber of a topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Endpoint {
    /// An identifier that no other endpoint of the bus has at the same time.
    pub id: String,
    /// The kind.
    pub kind: EndpointKind,
    /// The node or participant, if it announces its name.
    pub node: Option<String>,
    /// The topic, with its ROS name.
    pub topic: String,
    /// The type, with its ROS name: `px4_msgs/msg/VehicleStatus`.
    pub type_name: String,
    /// The ROS type hash, if it is announced.
    pub type_hash: Option<String>,
    /// The quality of service, if it is announced.
    pub qos: Option<Qos>,
    /// True if a publisher and a subscriber exchange messages only if their quality of service is compatible. This is
    /// the case in DDS. `rmw_zenoh` ignores differences.
    pub is_matched_by_qos: bool,
}

/// The prefix of the ids of this program's endpoints.
const OWN: &str = "uavspec ";

impl Endpoint {
    /// The id of an endpoint of this program.
    pub fn own_id(kind: EndpointKind, topic: &str) -> String {
        format!("{OWN}{kind} {topic}")
    }

    /// True if the endpoint belongs to this program.
    pub fn is_own(&self) -> bool {
        self.id.starts_with(OWN)
    }
}

impl Endpoint {
    /// A publisher of a topic, for tests.
    #[doc(hidden)]
    pub fn publisher(topic: &str) -> Self {
        Self {
            id: topic.to_owned(),
            kind: EndpointKind::Publisher,
            node: None,
            topic: topic.to_owned(),
            type_name: "sky_msgs/msg/Wind".to_owned(),
            type_hash: None,
            qos: None,
            is_matched_by_qos: true,
        }
    }
}

/// The kind of an endpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EndpointKind {
    /// Sends messages.
    Publisher,
    /// Receives messages.
    Subscriber,
}

/// The quality of service of an endpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Qos {
    /// The reliability.
    pub reliability: Reliability,
    /// The durability.
    pub durability: Durability,
    /// The messages that the endpoint stores; `None` if this isn't announced.
    pub history: Option<History>,
    /// The maximum time between messages; `None` if it is unlimited.
    pub deadline: Option<Duration>,
    /// The time after which a message expires; `None` if it never expires.
    pub lifespan: Option<Duration>,
    /// The way in which the endpoint shows that it is alive.
    pub liveliness: Liveliness,
    /// The time after which a silent endpoint counts as lost; `None` if it is unlimited.
    pub lease: Option<Duration>,
    /// The partitions. Endpoints in different partitions don't exchange messages.
    pub partitions: Vec<String>,
}

/// The reliability, from weakest to strongest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reliability {
    /// Lost messages stay lost.
    BestEffort,
    /// Lost messages are sent again.
    Reliable,
}

/// The durability, from weakest to strongest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Durability {
    /// New subscribers receive only new messages.
    Volatile,
    /// New subscribers also receive the messages that the publisher stores.
    TransientLocal,
    /// Like `TransientLocal`, even after the publisher has ended.
    Transient,
    /// Like `Transient`, even after a restart of the system.
    Persistent,
}

/// The messages that an endpoint stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum History {
    /// The latest messages, up to this number.
    KeepLast(u32),
    /// All messages.
    KeepAll,
}

/// The liveliness, from weakest to strongest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Liveliness {
    /// The middleware sends signs of life.
    Automatic,
    /// The program sends signs of life, one for all its endpoints.
    ManualByParticipant,
    /// The program sends signs of life for each endpoint.
    ManualByTopic,
}

impl Qos {
    /// The quality of service of PX4's publishers: best effort, transient local, and one stored message.
    pub const PX4: Self = Self {
        reliability: Reliability::BestEffort,
        durability: Durability::TransientLocal,
        history: Some(History::KeepLast(1)),
        deadline: None,
        lifespan: None,
        liveliness: Liveliness::Automatic,
        lease: None,
        partitions: Vec::new(),
    };

    /// The weakest quality of service: best effort and volatile. A subscriber that requests it matches all publishers.
    pub const WEAKEST: Self = Self {
        reliability: Reliability::BestEffort,
        durability: Durability::Volatile,
        history: Some(History::KeepLast(1)),
        deadline: None,
        lifespan: None,
        liveliness: Liveliness::Automatic,
        lease: None,
        partitions: Vec::new(),
    };
}

/// A policy whose values have fixed names.
trait Named: Copy + PartialEq + 'static {
    /// All values with their names.
    const NAMES: &'static [(Self, &'static str)];
}

impl Named for EndpointKind {
    const NAMES: &'static [(Self, &'static str)] =
        &[(Self::Publisher, "publisher"), (Self::Subscriber, "subscriber")];
}

impl Named for Reliability {
    const NAMES: &'static [(Self, &'static str)] =
        &[(Self::BestEffort, "best effort"), (Self::Reliable, "reliable")];
}

impl Named for Durability {
    const NAMES: &'static [(Self, &'static str)] = &[
        (Self::Volatile, "volatile"),
        (Self::TransientLocal, "transient local"),
        (Self::Transient, "transient"),
        (Self::Persistent, "persistent"),
    ];
}

impl Named for Liveliness {
    const NAMES: &'static [(Self, &'static str)] = &[
        (Self::Automatic, "automatic"),
        (Self::ManualByParticipant, "manual by participant"),
        (Self::ManualByTopic, "manual by topic"),
    ];
}

fn name<T: Named>(value: T) -> &'static str {
    T::NAMES.iter().find(|(known, _)| *known == value).map_or("", |(_, name)| name)
}

fn named<T: Named>(name: &str) -> Option<T> {
    T::NAMES.iter().find(|(_, known)| *known == name).map(|(value, _)| *value)
}

macro_rules! display {
    ($($ty:ty),*) => { $(
        impl fmt::Display for $ty {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.pad(name(*self))
            }
        }
    )* };
}

display!(EndpointKind, Reliability, Durability, Liveliness);

impl fmt::Display for History {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::KeepLast(depth) => write!(formatter, "keep last {depth}"),
            Self::KeepAll => formatter.write_str("keep all"),
        }
    }
}

impl FromStr for History {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        match text.strip_prefix("keep last ") {
            Some(depth) => depth.parse().map(Self::KeepLast).map_err(drop),
            None if text == "keep all" => Ok(Self::KeepAll),
            None => Err(()),
        }
    }
}

impl fmt::Display for Qos {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}, {}", self.reliability, self.durability)?;
        if let Some(history) = self.history {
            write!(formatter, ", {history}")?;
        }
        for (name, time) in [("deadline", self.deadline), ("lifespan", self.lifespan), ("lease", self.lease)]
        {
            if let Some(time) = time {
                write!(formatter, ", {name} {time:?}")?;
            }
        }
        if self.liveliness != Liveliness::Automatic {
            write!(formatter, ", liveliness {}", self.liveliness)?;
        }
        match &self.partitions[..] {
            [] => Ok(()),
            partitions => write!(formatter, ", partition {}", partitions.join(" ").escape_debug()),
        }
    }
}

/// The separator of partitions in a recording.
const SEPARATOR: char = '\n';

impl Endpoint {
    /// Converts the endpoint to key-value pairs, to be stored in a recording.
    pub fn to_values(&self) -> BTreeMap<String, String> {
        let Self { id, kind, node, topic, type_name, type_hash, qos, is_matched_by_qos } = self;
        let mut values = BTreeMap::new();
        let mut add = |key: &str, value: Option<String>| {
            values.extend(value.map(|value| (key.to_owned(), value)));
        };
        add("id", Some(id.clone()));
        add("kind", Some(kind.to_string()));
        add("node", node.clone());
        add("topic", Some(topic.clone()));
        add("type", Some(type_name.clone()));
        add("type_hash", type_hash.clone());
        add("matched_by_qos", Some(is_matched_by_qos.to_string()));
        let Some(qos) = qos else { return values };
        let nanoseconds = |time: Option<Duration>| time.map(|time| time.as_nanos().to_string());
        add("reliability", Some(qos.reliability.to_string()));
        add("durability", Some(qos.durability.to_string()));
        add("history", qos.history.map(|history| history.to_string()));
        add("deadline_ns", nanoseconds(qos.deadline));
        add("lifespan_ns", nanoseconds(qos.lifespan));
        add("liveliness", Some(qos.liveliness.to_string()));
        add("lease_ns", nanoseconds(qos.lease));
        let partitions = qos.partitions.join(&SEPARATOR.to_string());
        add("partitions", (!qos.partitions.is_empty()).then_some(partitions));
        values
    }

    /// Parses the key-value pairs from a recording. `None` if a required value is missing or invalid.
    pub fn from_values(values: &BTreeMap<String, String>) -> Option<Self> {
        let text = |key: &str| values.get(key).cloned();
        Some(Self {
            id: text("id")?,
            kind: named(values.get("kind")?)?,
            node: text("node"),
            topic: text("topic")?,
            type_name: text("type")?,
            type_hash: text("type_hash"),
            qos: if values.contains_key("reliability") { Some(Qos::from_values(values)?) } else { None },
            is_matched_by_qos: values.get("matched_by_qos").is_some_and(|value| value == "true"),
        })
    }
}

impl Qos {
    fn from_values(values: &BTreeMap<String, String>) -> Option<Self> {
        let time = |key: &str| match values.get(key) {
            None => Some(None),
            Some(text) => text.parse().ok().map(|time| Some(Duration::from_nanos(time))),
        };
        let partitions = values.get("partitions").map(|text| text.split(SEPARATOR).map(str::to_owned));
        Some(Self {
            reliability: named(values.get("reliability")?)?,
            durability: named(values.get("durability")?)?,
            history: values.get("history").map(|text| text.parse()).transpose().ok()?,
            deadline: time("deadline_ns")?,
            lifespan: time("lifespan_ns")?,
            liveliness: named(values.get("liveliness")?)?,
            lease: time("lease_ns")?,
            partitions: partitions.map(Iterator::collect).unwrap_or_default(),
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn time() -> impl Strategy<Value = Option<Duration>> {
        prop::option::of(any::<u64>().prop_map(Duration::from_nanos))
    }

    fn value<T: Named + fmt::Debug>() -> impl Strategy<Value = T> {
        prop::sample::select(T::NAMES.iter().map(|(value, _)| *value).collect::<Vec<_>>())
    }

    fn qos() -> impl Strategy<Value = Qos> {
        let history =
            prop::option::of(prop_oneof![any::<u32>().prop_map(History::KeepLast), Just(History::KeepAll)]);
        let partitions = prop::collection::vec("[a-z*]{1,5}", 0..3);
        let policies = (value(), value(), history, value());
        (policies, time(), time(), time(), partitions).prop_map(
            |((reliability, durability, history, liveliness), deadline, lifespan, lease, partitions)| Qos {
                reliability,
                durability,
                history,
                deadline,
                lifespan,
                liveliness,
                lease,
                partitions,
            },
        )
    }

    proptest! {
        #[test]
        fn recordings_keep_endpoints(
            names in [".*", ".*", ".*"],
            kind in value(),
            optional in [prop::option::of(".*"), prop::option::of(".*")],
            qos in prop::option::of(qos()),
            is_matched_by_qos: bool,
        ) {
            let ([id, topic, type_name], [node, type_hash]) = (names, optional);
            let endpoint = Endpoint { id, kind, node, topic, type_name, type_hash, qos, is_matched_by_qos };
            prop_assert_eq!(Endpoint::from_values(&endpoint.to_values()), Some(endpoint));
        }
    }

    #[test]
    fn px4_offers_best_effort() {
        assert_eq!(Qos::PX4.to_string(), "best effort, transient local, keep last 1");
        let slow = Qos {
            reliability: Reliability::Reliable,
            history: None,
            deadline: Some(Duration::from_millis(1_500)),
            liveliness: Liveliness::ManualByTopic,
            partitions: vec!["wing".to_owned()],
            ..Qos::PX4
        };
        let text = "reliable, transient local, deadline 1.5s, liveliness manual by topic, partition wing";
        assert_eq!(slow.to_string(), text);
    }
}
