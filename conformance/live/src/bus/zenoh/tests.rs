//! Tests with a router in the test process. The router declares tokens and publishes messages like `rmw_zenoh`.

use std::time::Duration;

use uavspec_model::clock::Clock;
use uavspec_model::net::Address;
use uavspec_model::{Durability, EndpointKind, Qos, Reliability};
use uavspec_test_support::{LIMIT, deadline, free_address, wait_for};
use zenoh::liveliness::LivelinessToken;
use zenoh::{Config, Session, Wait};

use super::attachment::Attachment;
use super::token::Token;
use super::{Bus, Zenoh};
use crate::bus::{Event, Topic};

/// A router with a node.
struct Router {
    session: Session,
    port: u16,
    tokens: Vec<LivelinessToken>,
}

impl Router {
    fn start() -> Self {
        let port = free_address().port();
        let mut config = Config::default();
        for (key, value) in [
            ("mode", "\"router\""),
            ("listen/endpoints", &*format!("[\"tcp/127.0.0.1:{port}\"]")),
            ("scouting/multicast/enabled", "false"),
        ] {
            config.insert_json5(key, value).expect("valid");
        }
        let session = zenoh::open(config).wait().expect("a router");
        Self { session, port, tokens: Vec::new() }
    }

    fn connect(&self) -> Zenoh {
        Zenoh::connect(&address("127.0.0.1", self.port), 0).expect("a connection")
    }

    fn announce(&mut self, kind: EndpointKind, topic: &Topic, qos: Qos) {
        let session = self.session.zid().to_string();
        let token = Token { session, kind, node: "/peer".to_owned(), topic: topic.clone(), qos };
        self.declare(&token.format(0, self.tokens.len() as u64));
    }

    fn declare(&mut self, token: &str) {
        self.tokens.push(self.session.liveliness().declare_token(token).wait().expect("valid"));
    }

    fn put(&self, key: &str, sequence: i64) {
        let attachment = Attachment { sequence, time: 0, publisher: [1; 16] }.format();
        self.session.put(key, [0, 1, 0, 0, 7]).attachment(attachment).wait().expect("published");
    }
}

fn address(host: &str, port: u16) -> Address {
    Address { host: host.to_owned(), port }
}

fn topic(name: &str, hash: Option<&str>) -> Topic {
    Topic { name: name.into(), type_name: "p/msg/A".into(), type_hash: hash.map(Into::into) }
}

fn next(bus: &mut Zenoh) -> Event {
    bus.receive(deadline()).expect("an event")
}

/// Waits until a condition is true.
fn wait(condition: impl Fn() -> bool) {
    wait_for("a change", || condition().then_some(()));
}

#[test]
fn receives_messages_and_counts_gaps() {
    let mut router = Router::start();
    let wind = topic("/wind", Some("RIHS01_1"));
    router.announce(EndpointKind::Publisher, &wind, Qos { durability: Durability::Volatile, ..Qos::PX4 });
    let mut bus = router.connect();
    let Event::Endpoint(endpoint) = next(&mut bus) else { panic!("an endpoint") };
    assert_eq!((&*endpoint.topic, endpoint.node.as_deref()), ("/wind", Some("/peer")));
    bus.subscribe(&wind, &Qos::WEAKEST).expect("subscribed");
    bus.subscribe(&wind, &Qos::WEAKEST).expect("subscribed");
    let key = "0/wind/p::msg::dds_::A_/RIHS01_1";
    let publisher = router.session.declare_publisher(key).wait().expect("declared");
    wait(|| publisher.matching_status().wait().is_ok_and(|status| status.matching()));
    for sequence in [1, 2, 5] {
        router.put(key, sequence);
    }
    for _ in 0..2 {
        let Event::Message(message) = next(&mut bus) else { panic!("a message") };
        assert_eq!((message.topic, &*message.payload), (wind.clone(), &[0, 1, 0, 0, 7][..]));
    }
    assert!(matches!(next(&mut bus), Event::Lost { count: 2, .. }));
    assert!(matches!(next(&mut bus), Event::Message(_)));
    router.session.put(key, [0, 1, 0, 0]).wait().expect("published");
    assert!(matches!(next(&mut bus), Event::Problem(text) if text.contains("attachment")));
    assert!(matches!(next(&mut bus), Event::Message(_)));
    router.tokens.clear();
    assert!(matches!(next(&mut bus), Event::Ended(id) if id == endpoint.id));
}

#[test]
fn receives_stored_messages_of_others() {
    let router = Router::start();
    let wind = topic("/wind", None);
    let mut publisher = router.connect();
    let number = publisher.advertise(&wind, &Qos::PX4).expect("advertised");
    publisher.publish(number, &[0, 1, 0, 0, 1]).expect("published");
    publisher.publish(number, &[0, 1, 0, 0, 2]).expect("published");
    let mut bus = router.connect();
    assert!(matches!(next(&mut bus), Event::Endpoint(_)));
    bus.subscribe(&wind, &Qos::WEAKEST).expect("subscribed");
    let Event::Message(message) = next(&mut bus) else { panic!("a message") };
    assert_eq!(message.payload, [0, 1, 0, 0, 2]);
    publisher.publish(number, &[0, 1, 0, 0, 3]).expect("published");
    let Event::Message(message) = next(&mut bus) else { panic!("a message") };
    assert_eq!(message.payload, [0, 1, 0, 0, 3]);
}

#[test]
fn publishes_with_the_hash_that_subscribers_expect() {
    let mut router = Router::start();
    router.announce(EndpointKind::Subscriber, &topic("/wind", Some("RIHS01_1")), Qos::PX4);
    let samples = router.session.declare_subscriber("0/wind/p::msg::dds_::A_/RIHS01_1").wait();
    let samples = samples.expect("subscribed");
    let mut bus = router.connect();
    assert!(matches!(next(&mut bus), Event::Endpoint(_)));
    let reliable = Qos { reliability: Reliability::Reliable, ..Qos::PX4 };
    let number = bus.advertise(&topic("/wind", None), &reliable).expect("advertised");
    bus.publish(number, &[0, 1, 0, 0, 9]).expect("published");
    let sample = samples.recv_timeout(LIMIT).expect("connected").expect("a sample");
    assert_eq!(&*sample.payload().to_bytes(), [0, 1, 0, 0, 9]);
    let attachment = sample.attachment().and_then(|bytes| Attachment::parse(&bytes.to_bytes()));
    assert_eq!(attachment.map(|attachment| attachment.sequence), Some(1));
}

#[test]
fn announces_the_requested_quality_of_service() {
    let router = Router::start();
    let [mut bus, mut other] = [router.connect(), router.connect()];
    let qos = Qos { reliability: Reliability::Reliable, ..Qos::WEAKEST };
    bus.subscribe(&topic("/wind", None), &qos).expect("subscribed");
    let Event::Endpoint(endpoint) = next(&mut other) else { panic!("an endpoint") };
    assert_eq!((endpoint.kind, endpoint.qos), (EndpointKind::Subscriber, Some(qos)));
}

#[test]
fn reports_other_types_of_a_topic() {
    let mut router = Router::start();
    let mut bus = router.connect();
    let [first, second] = [topic("/wind", Some("RIHS01_1")), topic("/wind", Some("RIHS01_2"))];
    bus.subscribe(&first, &Qos::WEAKEST).expect("subscribed");
    bus.subscribe(&second, &Qos::WEAKEST).expect("not an error");
    assert!(matches!(next(&mut bus), Event::Unreadable(text) if text.contains("RIHS01_2")));
    bus.advertise(&first, &Qos::PX4).expect("advertised");
    router.announce(EndpointKind::Subscriber, &second, Qos::PX4);
    assert!(matches!(next(&mut bus), Event::Endpoint(_)));
    assert!(matches!(next(&mut bus), Event::Problem(text) if text.contains("/peer expects p/msg/A")));
    let unknown = Topic { type_name: "".into(), ..topic("/wind", None) };
    router.announce(EndpointKind::Subscriber, &unknown, Qos::PX4);
    assert!(matches!(next(&mut bus), Event::Endpoint(_)));
    assert!(bus.receive(Clock::real().now() + Duration::from_millis(200)).is_none());
}

#[test]
fn survives_hostile_tokens() {
    let mut router = Router::start();
    for end in ["x", "a/0/1/ZZ/%/%/n", "a/0/1/MP/%/%/n/%t/T/H/9:9:9", &"a".repeat(5_000)] {
        router.declare(&format!("@ros2_lv/0/{end}"));
    }
    router.declare("@ros2_lv/0/a/0/1/MP/%/%/n/*/T/H/::,");
    let mut bus = router.connect();
    let (mut problems, mut topics) = (0, Vec::new());
    for _ in 0..5 {
        match next(&mut bus) {
            Event::Problem(_) => problems += 1,
            Event::Endpoint(endpoint) => topics.push(topic(&endpoint.topic, None)),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!((problems, &topics[..]), (4, &[topic("*", None)][..]));
    assert!(bus.subscribe(&topics[0], &Qos::WEAKEST).expect_err("an error").contains("found `*`"));
}

#[test]
fn reports_the_end_of_the_router() {
    let router = Router::start();
    let mut bus = router.connect();
    router.session.close().wait().expect("closed");
    assert!(matches!(next(&mut bus), Event::Closed(_)));
    assert!(bus.receive(Clock::real().now()).is_none());
}

#[test]
fn a_missing_router_is_an_error() {
    let error = Zenoh::connect(&address("127.0.0.1", 1), 0).err().unwrap_or_default();
    assert!(error.contains("no connection to a Zenoh router at 127.0.0.1:1"), "{error}");
    assert!(Zenoh::connect(&address("a#b", 1), 0).err().unwrap_or_default().contains("expected a host name"));
}
