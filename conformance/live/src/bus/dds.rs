//! DDS domains, with rustdds. Messages of all types are received and sent in CDR.
//!
//! ```text
//!  rustdds ──samples, discovery──▶ worker ──event──▶ queue ──▶ bus
//!                                     └──announcement──▶ peers
//! ```
//!
//! # Differences to a ROS node
//!
//! - The subscribers of a probe request best effort and volatile, so they match all publishers without partitions. If
//!   a publisher stores messages, a second subscriber requests them, with reliable delivery. A reliable publisher waits
//!   for its subscribers: if it keeps all messages, this program can slow it down.
//! - DDS doesn't announce the history. rustdds can't announce the partitions or the type hash of our endpoints.
//! - All subscribers of a topic have the type of the first one. Publishers with another type are reported.
//! - The name of a node is the name of its participant.
//!
//! # Limits
//!
//! If there are more than [`MAX_ENDPOINTS`](super::MAX_ENDPOINTS) endpoints, topics or participants, the connection
//! ends, which frees the memory of rustdds. The number of subscribers is limited by the number of files that the
//! process may open. The probe raises this limit if the system permits it.
//!
//! rustdds reserves and clears the memory for a fragmented message when its first fragment arrives. It trusts the total
//! size in the fragment, up to 4 GiB, and doesn't check that the sender is known. It stores up to 128 incomplete messages
//! of each sender, and discards a message 10 s after its last fragment. No setting of rustdds 0.15 limits this: resource
//! limits and history apply to complete messages only, and its sockets accept datagrams from all networks. The connection
//! therefore ends if the process uses much memory, see [`memory`].

mod endpoints;
mod memory;
mod names;
mod partitions;
mod peers;
mod qos;
mod reader;
mod source;
mod worker;

use std::net::{IpAddr, Ipv4Addr};
use std::time::Instant;

use rustdds::bytes::Bytes;
use rustdds::no_key::DataWriter;
use rustdds::{DomainParticipant, DomainParticipantBuilder, QosPolicies, RTPSEntity, TopicKind};
use uavspec_model::net::raise_open_files;
use uavspec_model::{History, Qos, Reliability};

use self::memory::Memory;
use self::peers::{Announcer, Identity};
use self::reader::{DEPTH, RawAdapter};
use self::worker::Worker;
use super::queue::{Queue, queue};
use super::{Bus, Event, Publisher, Topic};

/// The identifier of little-endian CDR in the encapsulation header.
const CDR_LE: [u8; 2] = [0, 1];

/// The receive buffer size that is requested from the system: 0.4 s at 20 MB/s. The system may grant less.
const SOCKET_BUFFER: usize = 8 << 20;

/// Joins a DDS domain. If all peers are loopback addresses, only programs on this computer are found.
pub(super) fn connect(domain: u16, peers: &[IpAddr]) -> Result<Box<dyn Bus>, String> {
    let ipv4 = |peer: &IpAddr| match peer {
        IpAddr::V4(peer) => Ok(*peer),
        IpAddr::V6(peer) => Err(format!("peer {peer}: expected an IPv4 address")),
    };
    let peers = peers.iter().map(ipv4).collect::<Result<Vec<_>, _>>()?;
    let is_local = !peers.is_empty() && peers.iter().all(Ipv4Addr::is_loopback);
    raise_open_files(worker::FILES);
    Ok(Box::new(DdsBus::join(domain, is_local.then_some(Ipv4Addr::LOCALHOST), &peers)?))
}

/// A DDS domain that this program joined.
struct DdsBus {
    // Must be dropped first: the worker may be waiting for space in the queue.
    events: Queue,
    connection: Option<Connection>,
}

/// The endpoints of this program.
struct Connection {
    // Dropped in this order: the endpoints must end before their participant.
    worker: Worker,
    writers: Vec<DataWriter<Bytes, RawAdapter>>,
    publisher: rustdds::Publisher,
    participant: DomainParticipant,
}

impl DdsBus {
    /// Joins a domain. `network` is the address of the only network interface to use; `None` means all interfaces.
    fn join(domain: u16, network: Option<Ipv4Addr>, peers: &[Ipv4Addr]) -> Result<Self, String> {
        let builder = DomainParticipantBuilder::new(domain).socket_receive_buffer_size(SOCKET_BUFFER);
        let builder = match network {
            Some(address) => builder.with_only_networks([IpAddr::V4(address)]),
            None => builder,
        };
        let failed = |error: &dyn std::fmt::Display| format!("can't join DDS domain {domain}: {error}");
        // From now on, the participant receives messages.
        let memory = Memory::start();
        let participant = builder.build().map_err(|error| failed(&error))?;
        let guid = participant.guid().to_bytes();
        let announcer =
            Announcer::new(Identity { domain, index: participant.participant_id(), guid }, peers)?;
        let publisher = participant.create_publisher(&QosPolicies::qos_none());
        let publisher = publisher.map_err(|error| failed(&error))?;
        let (sender, events) = queue();
        let worker = Worker::start(&participant, announcer, memory, sender)?;
        let connection = Connection { worker, writers: Vec::new(), publisher, participant };
        Ok(Self { events, connection: Some(connection) })
    }

    fn connection(&mut self) -> Result<&mut Connection, String> {
        self.connection.as_mut().ok_or_else(|| "the connection ended".to_owned())
    }
}

impl Bus for DdsBus {
    fn receive(&mut self, deadline: Instant) -> Option<Event> {
        let event = self.events.receive(deadline)?;
        if matches!(event, Event::Closed(_)) {
            self.connection = None;
        }
        Some(event)
    }

    fn subscribe(&mut self, topic: &Topic, qos: &Qos) -> Result<(), String> {
        self.connection()?.worker.subscribe(topic.clone(), qos.clone())
    }

    fn advertise(&mut self, topic: &Topic, qos: &Qos) -> Result<Publisher, String> {
        let Connection { writers, publisher, participant, .. } = self.connection()?;
        let policies = qos::to_policies(&Qos { history: stored(qos), ..qos.clone() });
        let (name, type_name) = (names::topic_to_dds(&topic.name), topic.dds_type());
        let created = participant
            .create_topic(name, type_name, &policies, TopicKind::NoKey)
            .and_then(|topic| publisher.create_datawriter_no_key(&topic, Some(policies)));
        writers.push(created.map_err(|error| format!("can't publish {}: {error}", topic.name))?);
        Ok(Publisher(writers.len() - 1))
    }

    fn publish(&mut self, publisher: Publisher, payload: &[u8]) -> Result<(), String> {
        let writer = self.connection()?.writers.get(publisher.0).ok_or("an unknown publisher")?;
        let body = Bytes::copy_from_slice(body(payload)?);
        writer.write(body, None).map_err(|error| format!("can't publish: {error}"))
    }

    fn remaining_losses(&mut self) -> Vec<Event> {
        self.events.remaining_losses()
    }

    fn is_matched_by_qos(&self) -> bool {
        true
    }
}

/// The number of messages that a publisher stores. If a burst contains more messages, rustdds drops the rest. A
/// best-effort publisher never sends its stored messages again, so it can store more messages than it announces.
fn stored(qos: &Qos) -> Option<History> {
    if qos.reliability == Reliability::BestEffort { Some(History::KeepLast(DEPTH)) } else { qos.history }
}

/// The part of a message after the encapsulation header, because rustdds writes the header itself.
fn body(payload: &[u8]) -> Result<&[u8], String> {
    match payload.split_at_checked(4) {
        Some((header, body)) if header.starts_with(&CDR_LE) => Ok(body),
        _ => {
            let start = payload.get(..4).unwrap_or(payload);
            Err(format!(
                "expected a message in little-endian CDR, which starts with 00 01, found {start:02x?}"
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use uavspec_model::EndpointKind;
    use uavspec_model::clock::Clock;

    use super::*;
    use crate::bus::Encoding;

    /// A message in CDR.
    const MESSAGE: &[u8] = b"\0\x01\0\0wind";

    fn join(domain: u16) -> DdsBus {
        DdsBus::join(domain, Some(Ipv4Addr::LOCALHOST), &[]).expect("a domain")
    }

    fn topic(name: &str, type_name: &str) -> Topic {
        Topic { name: name.into(), type_name: type_name.into(), type_hash: None }
    }

    fn wind() -> Topic {
        topic("/wind", "sky_msgs/msg/Wind")
    }

    /// Waits for an event that matches, and calls `work` between events.
    fn wait(bus: &mut DdsBus, mut work: impl FnMut(), is_match: impl Fn(&Event) -> bool) -> Event {
        let end = uavspec_test_support::deadline();
        while Clock::real().now() < end {
            work();
            let event = bus.receive(Clock::real().now() + Duration::from_millis(100));
            if let Some(event) = event.filter(&is_match) {
                return event;
            }
        }
        panic!("no such event");
    }

    #[test]
    fn messages_reach_other_programs() {
        let (mut sender, mut receiver) = (join(71), join(71));
        let publisher = sender.advertise(&wind(), &Qos::PX4).expect("a publisher");
        receiver.subscribe(&wind(), &Qos::WEAKEST).expect("a subscriber");
        let found = wait(&mut receiver, || {}, |event| matches!(event, Event::Endpoint(_)));
        let Event::Endpoint(endpoint) = found else { panic!() };
        assert_eq!((endpoint.kind, &*endpoint.topic), (EndpointKind::Publisher, "/wind"));
        assert_eq!(endpoint.qos, Some(Qos { history: None, ..Qos::PX4 }));
        let publish = || sender.publish(publisher, MESSAGE).expect("published");
        let found = wait(&mut receiver, publish, |event| matches!(event, Event::Message(_)));
        let Event::Message(message) = found else { panic!() };
        assert_eq!((message.topic, message.encoding), (wind(), Encoding::Cdr));
        assert_eq!(message.payload, MESSAGE);
        drop(sender);
        wait(&mut receiver, || {}, |event| matches!(event, Event::Ended(id) if *id == endpoint.id));
    }

    #[test]
    fn reliable_subscribers_of_best_effort_publishers_receive_nothing() {
        let [mut sender, mut receiver, mut witness] = [join(76), join(76), join(76)];
        let publisher = sender.advertise(&wind(), &Qos::PX4).expect("a publisher");
        let reliable = Qos { reliability: Reliability::Reliable, ..Qos::WEAKEST };
        receiver.subscribe(&wind(), &reliable).expect("a subscriber");
        witness.subscribe(&wind(), &Qos::WEAKEST).expect("a subscriber");
        let is_reliable = |event: &Event| {
            let Event::Endpoint(endpoint) = event else { return false };
            endpoint.qos.as_ref().is_some_and(|qos| qos.reliability == Reliability::Reliable)
        };
        wait(&mut sender, || {}, is_reliable);
        let is_publisher = |event: &Event| matches!(event, Event::Endpoint(endpoint) if endpoint.kind == EndpointKind::Publisher);
        wait(&mut receiver, || {}, is_publisher);
        let publish = || sender.publish(publisher, MESSAGE).expect("published");
        wait(&mut witness, publish, |event| matches!(event, Event::Message(_)));
        for _ in 0..10 {
            sender.publish(publisher, MESSAGE).expect("published");
            let event = receiver.receive(Clock::real().now() + Duration::from_millis(100));
            assert!(!matches!(event, Some(Event::Message(_))), "{event:?}");
        }
    }

    #[test]
    fn bursts_of_best_effort_publishers_arrive() {
        let [mut sender, mut receiver] = [join(70), join(70)];
        let publisher = sender.advertise(&wind(), &Qos::PX4).expect("a publisher");
        receiver.subscribe(&wind(), &Qos::WEAKEST).expect("a subscriber");
        let publish = || sender.publish(publisher, MESSAGE).expect("published");
        wait(&mut receiver, publish, |event| matches!(event, Event::Message(_)));
        let mark = b"\0\x01\0\0last";
        for _ in 0..20 {
            sender.publish(publisher, b"\0\x01\0\0gust").expect("published");
        }
        sender.publish(publisher, mark).expect("published");
        let mut payloads = Vec::new();
        while payloads.last().is_none_or(|payload: &Vec<u8>| payload != mark) {
            let event = wait(&mut receiver, || {}, |event| matches!(event, Event::Message(_)));
            let Event::Message(message) = event else { panic!() };
            payloads.push(message.payload);
        }
        let gusts = payloads.iter().filter(|payload| payload.ends_with(b"gust"));
        assert_eq!(gusts.count(), 20);
    }

    #[test]
    fn own_endpoints_and_messages_are_not_reported() {
        let mut bus = join(72);
        let publisher = bus.advertise(&wind(), &Qos::PX4).expect("a publisher");
        bus.subscribe(&wind(), &Qos::WEAKEST).expect("a subscriber");
        let end = Clock::real().now() + Duration::from_secs(3);
        while Clock::real().now() < end {
            bus.publish(publisher, MESSAGE).expect("published");
            let event = bus.receive(Clock::real().now() + Duration::from_millis(100));
            assert!(event.is_none(), "{event:?}");
        }
    }

    #[test]
    fn reports_a_second_type() {
        let mut bus = join(73);
        for topic in [wind(), wind(), topic("/wind", "sky_msgs/msg/Storm")] {
            bus.subscribe(&topic, &Qos::WEAKEST).expect("sent");
        }
        let Event::Unreadable(problem) = wait(&mut bus, || {}, |_| true) else { panic!() };
        assert!(problem.contains("type sky_msgs/msg/Storm may be missing"), "{problem}");
    }

    #[test]
    fn publishes_only_little_endian_cdr() {
        assert_eq!(body(MESSAGE), Ok(b"wind".as_slice()));
        for payload in [b"\0\0\0\0wind".as_slice(), b"\0\x01\0", b"{}"] {
            assert!(body(payload).is_err());
        }
    }

    #[test]
    fn peers_have_ipv4_addresses() {
        let error = connect(74, &["::1".parse().expect("an address")]).err();
        assert_eq!(error.as_deref(), Some("peer ::1: expected an IPv4 address"));
    }

    /// Cyclone DDS returns the messages that it receives.
    #[test]
    #[ignore = "requires the Python packages that the tests in tests/live install"]
    fn messages_reach_cyclone_dds() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let network = "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces>\
                       <AllowMulticast>false</AllowMulticast></General><Discovery>\
                       <ParticipantIndex>auto</ParticipantIndex><Peers><Peer address=\"127.0.0.1\"/></Peers>\
                       </Discovery></Domain></CycloneDDS>";
        let mut peer = std::process::Command::new(folder.join("../../target/live-peers/bin/python"))
            .arg(folder.join("../tests/live/peers/dds.py"))
            .args(["75", "relay", "best_effort"])
            .env("CYCLONEDDS_URI", network)
            .spawn()
            .expect("a peer");
        let mut bus = join(75);
        let name = "px4_msgs/msg/ArmingCheckRequest";
        let input = topic("/fmu/in/arming_check_request_v1", name);
        let output = topic("/fmu/out/arming_check_request_v1", name);
        let publisher = bus.advertise(&input, &Qos::PX4).expect("a publisher");
        bus.subscribe(&output, &Qos::WEAKEST).expect("a subscriber");
        let payload = [b"\0\x01\0\0".as_slice(), &[7; 9], &[0; 3], &[1, 0, 0, 0]].concat();
        let end = uavspec_test_support::deadline();
        let mut received = None;
        while received.is_none() && Clock::real().now() < end {
            bus.publish(publisher, &payload).expect("published");
            if let Some(Event::Message(message)) =
                bus.receive(Clock::real().now() + Duration::from_millis(100))
            {
                received = Some(message);
            }
        }
        let _ = peer.kill();
        let _ = peer.wait();
        let received = received.expect("a message");
        assert_eq!((received.topic.name, received.payload), (output.name, payload));
    }
}
