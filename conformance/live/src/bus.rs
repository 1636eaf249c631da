//! Connections to the buses on which vehicles and applications exchange messages.
//!
//! A [`Bus`] reports publishers, subscribers and messages as they appear. All buses report ROS names: the topic
//! `/fmu/out/vehicle_status`, and the type `px4_msgs/msg/VehicleStatus`.

mod address;
#[cfg(feature = "dds")]
mod dds;
mod foxglove;
pub mod memory;
mod problems;
#[cfg(any(feature = "dds", feature = "zenoh", test))]
mod queue;
mod rosbridge;
mod websocket;
#[cfg(feature = "zenoh")]
mod zenoh;

use std::hash::{Hash, Hasher};
use std::net::IpAddr;
use std::sync::Arc;
use std::time::Instant;

use uavspec_model::clock::Clock;
use uavspec_model::{Endpoint, Qos};

pub use self::address::{Address, Scheme};
use crate::limits::MAX_ENDPOINTS;

/// Connects to a bus. `peers` are IP addresses of computers that multicast doesn't reach. `names` are the topics to
/// receive from a bus that can't list its topics.
///
/// # Errors
/// Fails if no connection is established within a few seconds. The error names the problem and a remedy.
pub fn connect(address: &Address, peers: &[IpAddr], names: &[String]) -> Result<Box<dyn Bus>, String> {
    // Only DDS has peers.
    let _ = peers;
    match address {
        #[cfg(feature = "dds")]
        Address::Dds { domain } => dds::connect(*domain, peers),
        #[cfg(feature = "zenoh")]
        Address::Server { scheme: Scheme::Zenoh, address, domain } => {
            Ok(Box::new(zenoh::Zenoh::connect(address, *domain)?))
        }
        Address::Server { scheme: Scheme::Foxglove, address, .. } => {
            Ok(Box::new(foxglove::Foxglove::connect(address)?))
        }
        Address::Server { scheme: Scheme::Rosbridge, address, .. } => {
            Ok(Box::new(rosbridge::Rosbridge::connect(address, names)?))
        }
        #[allow(unreachable_patterns, reason = "all transports may be part of the program")]
        _ => {
            let feature = address.scheme();
            Err(format!("this program was built without {feature}: build it with `--features {feature}`"))
        }
    }
}

/// A connection to a bus.
pub trait Bus {
    /// The next event, if there is one before the deadline. Waits for it if necessary.
    fn receive(&mut self, deadline: Instant) -> Option<Event>;

    /// Receives the messages of a topic from now on. `qos` is the requested quality of service. Does nothing if the
    /// topic is already subscribed. The error describes the problem.
    fn subscribe(&mut self, topic: &Topic, qos: &Qos) -> Result<(), String>;

    /// Prepares to publish on a topic. The error describes the problem.
    fn advertise(&mut self, topic: &Topic, qos: &Qos) -> Result<Publisher, String>;

    /// Publishes a message in CDR, including the encapsulation header. The error describes the problem.
    fn publish(&mut self, publisher: Publisher, payload: &[u8]) -> Result<(), String>;

    /// The clock for deadlines and message times.
    fn clock(&self) -> Clock {
        Clock::real()
    }

    /// The losses that [`receive`](Self::receive) hadn't returned when the caller stopped receiving.
    fn remaining_losses(&mut self) -> Vec<Event> {
        Vec::new()
    }

    /// True if a publisher and a subscriber exchange messages only if their quality-of-service settings are compatible.
    fn is_matched_by_qos(&self) -> bool {
        false
    }
}

/// The number of a publisher that [`Bus::advertise`] created.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Publisher(pub usize);

/// A topic with its type.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Topic {
    /// The name, such as `/fmu/out/vehicle_status`.
    pub name: Arc<str>,
    /// The type, such as `px4_msgs/msg/VehicleStatus`.
    pub type_name: Arc<str>,
    /// The ROS type hash, if it is known.
    pub type_hash: Option<Arc<str>>,
}

impl Topic {
    /// The ROS name of a type: `px4_msgs/msg/VehicleStatus` for `px4_msgs::msg::dds_::VehicleStatus_`. Other types keep
    /// their name.
    pub fn ros_type(name: &str) -> String {
        match name.strip_suffix('_').and_then(|name| name.rsplit_once("::dds_::")) {
            Some((scope, last)) => format!("{}/{last}", scope.replace("::", "/")),
            None => name.to_owned(),
        }
    }

    /// The DDS name of the type: `px4_msgs::msg::dds_::VehicleStatus_` for `px4_msgs/msg/VehicleStatus`.
    pub fn dds_type(&self) -> String {
        match self.type_name.rsplit_once('/') {
            Some((scope, last)) => format!("{}::dds_::{last}_", scope.replace('/', "::")),
            None => self.type_name.to_string(),
        }
    }
}

/// The encoding of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// CDR, including the encapsulation header.
    Cdr,
    /// A JSON object.
    Json,
}

/// A schema that a bus states for a type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schema {
    /// The encoding, such as `ros2msg`.
    pub encoding: String,
    /// The text.
    pub text: Vec<u8>,
}

impl Hash for Schema {
    /// Hashes the encoding and the length of the text. The text isn't hashed, because the recorder looks up the schema
    /// of each message.
    fn hash<H: Hasher>(&self, state: &mut H) {
        (&self.encoding, self.text.len()).hash(state);
    }
}

/// A change on a bus.
#[derive(Clone, Debug)]
pub enum Event {
    /// A publisher or subscriber appeared, or its quality of service changed.
    Endpoint(Endpoint),
    /// The publisher or subscriber with this id ended.
    Ended(String),
    /// A message.
    Message(Received),
    /// Messages of a topic were lost on the way, or were dropped because they arrived faster than they were read.
    Lost {
        /// The topic.
        topic: Arc<str>,
        /// The number of messages.
        count: u64,
    },
    /// Data that isn't received or can't be read. The text states the data, the problem and the origin.
    Unreadable(String),
    /// A remark about the bus, such as an invalid announcement. No message is missing. The text states the problem and
    /// its origin.
    Problem(String),
    /// The connection ended for this reason. No event follows.
    Closed(String),
}

/// A message that was received.
#[derive(Clone, Debug)]
pub struct Received {
    /// The topic.
    pub topic: Topic,
    /// The schema of the type, if the bus announces it.
    pub schema: Option<Arc<Schema>>,
    /// The encoding of the payload.
    pub encoding: Encoding,
    /// The time of reception, in ns since 1970.
    pub time: u64,
    /// The message.
    pub payload: Vec<u8>,
    /// True if this program sent the message, in a role.
    pub is_own: bool,
}

impl Received {
    /// A message of another program, on a bus that announces no schema.
    pub(crate) fn new(topic: Topic, encoding: Encoding, time: u64, payload: Vec<u8>) -> Self {
        Self { topic, schema: None, encoding, time, payload, is_own: false }
    }
}

/// The time in ns since 1970.
pub(crate) fn nanoseconds(clock: &Clock) -> u64 {
    u64::try_from(clock.since_1970().as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_types_are_converted_in_both_directions() {
        for (dds, ros) in [
            ("px4_msgs::msg::dds_::VehicleStatus_", "px4_msgs/msg/VehicleStatus"),
            ("ShapeType", "ShapeType"),
            ("a::b_", "a::b_"),
        ] {
            assert_eq!(Topic::ros_type(dds), ros);
            let topic = Topic { name: "/a".into(), type_name: ros.into(), type_hash: None };
            assert_eq!(topic.dds_type(), dds);
        }
    }
}
