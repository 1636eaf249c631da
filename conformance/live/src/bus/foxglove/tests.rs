use std::time::Duration;

use uavspec_test_support::deadline;

use super::*;
use crate::bus::Encoding;
use crate::bus::websocket::tests::{Peer, events, problems, raw_server, send, server, text, topic};

const INFO: &str =
    r#"{"op":"serverInfo","name":"x","capabilities":["clientPublish"],"supportedEncodings":["cdr"]}"#;

/// Connects to a server that describes itself. `run` is the server's behaviour after that.
fn client(run: impl FnOnce(&mut Peer) + Send + 'static) -> Foxglove {
    let address = server(|peer| {
        send(peer, &[INFO]);
        run(peer);
    });
    Foxglove::connect(&address).expect("connect")
}

fn channel(id: u64, name: &str, encoding: &str) -> String {
    format!(
        r#"{{"op":"advertise","channels":[{{"id":{id},"topic":"{name}","encoding":"{encoding}","schemaName":"a/msg/B","schemaEncoding":"ros2msg","schema":"uint8 a"}}]}}"#
    )
}

fn error(address: &Address) -> String {
    Foxglove::connect(address).err().expect("an error")
}

#[test]
fn receives_messages_of_channels_that_appear_later() {
    let mut bus = client(|peer| {
        send(peer, &[&channel(7, "/a", "cdr")]);
        assert_eq!(text(peer), r#"{"op":"subscribe","subscriptions":[{"id":1,"channelId":7}]}"#);
        peer.send(Message::binary(b"\x01\x01\0\0\0\0\0\0\0\0\0\0\0CDR".to_vec())).expect("send");
        send(peer, &[r#"{"op":"unadvertise","channelIds":[7,8]}"#]);
    });
    bus.subscribe(&topic("/a"), &Qos::WEAKEST).expect("subscribe");
    bus.subscribe(&topic("/a"), &Qos::WEAKEST).expect("subscribe");
    let events = events(&mut bus);
    let [Event::Endpoint(endpoint), Event::Message(message), Event::Ended(id), _] = &events[..] else {
        panic!("{events:?}");
    };
    assert_eq!((endpoint.topic.as_str(), endpoint.type_name.as_str()), ("/a", "a/msg/B"));
    assert_eq!(
        (&message.topic, message.encoding, &*message.payload),
        (&topic("/a"), Encoding::Cdr, &b"CDR"[..])
    );
    let schema = message.schema.as_ref().expect("a schema");
    assert_eq!((schema.encoding.as_str(), &*schema.text), ("ros2msg", &b"uint8 a"[..]));
    assert_eq!(*id, endpoint.id);
    assert_eq!((bus.schemas, bus.subscriptions.len()), (0, 0));
}

#[test]
fn ignores_messages_of_channels_that_ended() {
    let mut bus = client(|peer| {
        send(peer, &[&channel(7, "/a", "json")]);
        text(peer);
        send(peer, &[r#"{"op":"unadvertise","channelIds":[7]}"#]);
        peer.send(Message::binary(b"\x01\x01\0\0\0\0\0\0\0\0\0\0\0{}".to_vec())).expect("send");
    });
    bus.subscribe(&topic("/a"), &Qos::WEAKEST).expect("subscribe");
    assert_eq!(problems(&events(&mut bus)), ["the server closed the connection"]);
}

#[test]
fn subscribes_once_to_a_channel_that_a_message_repeats() {
    let mut bus = client(|peer| {
        let item = r#"{"id":7,"topic":"/a","encoding":"json","schemaName":""}"#;
        send(peer, &[&format!(r#"{{"op":"advertise","channels":[{item},{item}]}}"#)]);
        assert_eq!(text(peer), r#"{"op":"subscribe","subscriptions":[{"id":1,"channelId":7}]}"#);
    });
    bus.subscribe(&topic("/a"), &Qos::WEAKEST).expect("subscribe");
    assert_eq!(problems(&events(&mut bus)).len(), 1);
    assert_eq!((bus.channels.len(), bus.subscriptions.len()), (1, 1));
}

#[test]
fn reports_unsupported_encodings_once() {
    let mut bus = client(|peer| send(peer, &[&channel(1, "/p", "protobuf")]));
    bus.subscribe(&topic("/p"), &Qos::WEAKEST).expect("subscribe");
    bus.subscribe(&topic("/p"), &Qos::WEAKEST).expect("subscribe");
    let events = events(&mut bus);
    let problems = problems(&events);
    assert_eq!(
        (problems.len(), problems[0]),
        (2, "can't read \"/p\" (channel 1): expected cdr or json, found \"protobuf\"")
    );
    assert!(events.iter().any(|event| matches!(event, Event::Unreadable(_))), "{events:?}");
}

#[test]
fn a_full_send_buffer_means_lost_messages() {
    let mut bus = client(|peer| {
        for text in ["Send buffer limit reached", "slow"] {
            send(peer, &[&format!(r#"{{"op":"status","level":1,"message":"{text}"}}"#)]);
        }
    });
    let events = events(&mut bus);
    let [Event::Unreadable(lost), Event::Problem(remark), _] = &events[..] else { panic!("{events:?}") };
    assert_eq!(lost, "the server dropped messages: \"Send buffer limit reached\"");
    assert_eq!(remark, "the server reports a warning: \"slow\"");
}

#[test]
fn publishes_if_the_server_permits_it() {
    let mut bus = client(|peer| {
        let expected = r#"{"op":"advertise","channels":[{"id":1,"topic":"/c","encoding":"cdr","schemaName":"a/msg/B"}]}"#;
        assert_eq!(text(peer), expected);
        assert_eq!(peer.read().expect("read"), Message::binary(b"\x01\x01\0\0\0CDR".to_vec()));
        send(peer, &[r#"{"op":"status","level":1,"message":"received"}"#]);
    });
    let publisher = bus.advertise(&topic("/c"), &Qos::PX4).expect("advertise");
    bus.publish(publisher, b"CDR").expect("publish");
    bus.publish(Publisher(2), b"CDR").expect_err("an unknown publisher");
    assert_eq!(problems(&events(&mut bus))[0], "the server reports a warning: \"received\"");
}

#[test]
fn explains_servers_that_permit_no_publishing() {
    for (info, expected) in [
        (r#"{"op":"serverInfo","capabilities":[]}"#, "add `clientPublish`"),
        (r#"{"op":"serverInfo","capabilities":["clientPublish"],"supportedEncodings":["json"]}"#, "CDR"),
    ] {
        let mut bus = Foxglove::connect(&server(move |peer| send(peer, &[info]))).expect("connect");
        let error = bus.advertise(&topic("/c"), &Qos::PX4).expect_err("not permitted");
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn explains_servers_of_other_protocols() {
    let closed = error(&server(|_| ()));
    assert!(closed.contains("closed the connection"), "{closed}");
    let other = error(&raw_server(|stream| drop(tungstenite::accept(stream))));
    assert!(other.contains("none of the subprotocols foxglove.sdk.v1"), "{other}");
    let silent = server(|peer| while peer.read().is_ok() {});
    let link = Link::open(&SERVICE, &silent, deadline()).expect("connect");
    let silent = Foxglove::greet(link, Clock::real().now()).err().expect("an error");
    assert!(silent.contains("expected `serverInfo`"), "{silent}");
}

#[test]
fn reports_each_hostile_message() {
    let texts = [
        String::new(),
        "NaN".to_owned(),
        r#"{"op":null}"#.to_owned(),
        r#"{"op":7}"#.to_owned(),
        r#"{"op":"advertise"}"#.to_owned(),
        r#"{"op":"advertise","channels":[{"id":-1}]}"#.to_owned(),
        r#"{"op":"unadvertise","channelIds":["a"]}"#.to_owned(),
        format!(r#"{{"op":"advertise","channels":{}"#, "[".repeat(1 << 20)),
        format!(r#"{{"op":"status","level":{}{}}}"#, "[".repeat(10_000), "]".repeat(10_000)),
        channel(1, &"n".repeat(2_000), "cdr"),
    ];
    let binaries: [&[u8]; 5] =
        [b"", b"\x01", b"\x01\0\0\0\0\0\0\0\0\0\0\0", b"\xff", b"\x01\x09\0\0\0\0\0\0\0\0\0\0\0x"];
    let count = texts.len() + binaries.len();
    let mut bus = client(move |peer| {
        for text in &texts {
            send(peer, &[text]);
        }
        for bytes in binaries {
            peer.send(Message::binary(bytes.to_vec())).expect("send");
        }
    });
    let events = events(&mut bus);
    assert_eq!(problems(&events).len(), count + 1, "{events:#?}");
    assert!(problems(&events).iter().all(|text| text.len() < 1_000));
}

#[test]
fn limits_channels_and_schemas() {
    let mut bus = client(|peer| {
        for ids in [0..5_000, 5_000..20_000] {
            let item = |id| format!(r#"{{"id":{id},"topic":"/t{id}","encoding":"cdr","schemaName":""}}"#);
            let list = ids.map(item).collect::<Vec<_>>().join(",");
            send(peer, &[&format!(r#"{{"op":"advertise","channels":[{list}]}}"#)]);
        }
        let many = format!(r#"{{"op":"unadvertise","channelIds":[{}7]}}"#, "77777,".repeat(500_000));
        let schema = "s".repeat(1 << 20);
        let large = channel(1, "/x", "cdr").replace("uint8 a", &schema);
        send(peer, &[&many, &large]);
    });
    bus.subscribe(&topic("/x"), &Qos::WEAKEST).expect("subscribe");
    let events = events(&mut bus);
    assert_eq!((bus.channels.len(), bus.schemas), (MAX_ENDPOINTS - 1, 0));
    let problems = problems(&events);
    assert!(problems[0].contains("after the first 10000:"), "{}", problems[0]);
    assert!(problems[1].contains("a schema of at most 1048576 bytes"), "{}", problems[1]);
}

#[test]
fn fails_to_publish_to_a_server_that_does_not_read() {
    let (done, wait) = std::sync::mpsc::channel::<()>();
    let mut bus = client(move |_| _ = wait.recv());
    bus.publishers = 1;
    let payload = vec![0; 16 << 20];
    let error = (0..4).find_map(|_| bus.publish(Publisher(1), &payload).err()).expect("an error");
    assert!(error.contains("doesn't read"), "{error}");
    drop(done);
}

#[test]
fn returns_no_event_if_nothing_happens() {
    let (done, wait) = std::sync::mpsc::channel::<()>();
    let mut bus = client(move |_| _ = wait.recv());
    assert!(bus.receive(Clock::real().now() + Duration::from_millis(50)).is_none());
    drop(done);
    assert!(matches!(bus.receive(deadline()), Some(Event::Closed(_))));
    assert!(bus.receive(deadline()).is_none());
}
