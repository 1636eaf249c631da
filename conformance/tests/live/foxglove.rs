//! Tests of Foxglove servers: the server of the Foxglove SDK, and a server that violates the protocol.

use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::json;
use tungstenite::Message;
use tungstenite::handshake::server::{ErrorResponse, Request, Response};
use uavspec_live::bus::{Event, Topic, connect};
use uavspec_model::Qos;
use uavspec_test_support::free_address;

use super::probe::Probed;
use super::python::Peer;

/// Starts the SDK's server, and waits until it accepts connections. Returns the server and its address.
fn sdk() -> (Peer, String) {
    let port = free_address().port();
    let definition = Path::new(env!("CARGO_MANIFEST_DIR")).join("../definitions/px4/ArmingCheckRequest.msg");
    let definition = definition.to_str().expect("a path");
    let peer = Peer::start("foxglove_server.py", &[&port.to_string(), definition], &[]);
    let end = Instant::now() + Duration::from_secs(600);
    while TcpStream::connect(("127.0.0.1", port)).is_err() {
        assert!(Instant::now() < end, "the server doesn't start");
        thread::sleep(Duration::from_millis(50));
    }
    (peer, format!("foxglove://127.0.0.1:{port}"))
}

#[test]
fn messages_of_the_sdk_are_checked() {
    let (_peer, address) = sdk();
    let probed = Probed::new(&address, 4);
    let [cdr, json] =
        ["/fmu/out", "/json"].map(|prefix| probed.topic(&format!("{prefix}/arming_check_request")));
    assert_eq!((&cdr["encoding"], &cdr["result"]), (&"cdr".into(), &"equal".into()), "{cdr}");
    assert_eq!(
        (&json["encoding"], &json["schema_encoding"]),
        (&"json".into(), &"jsonschema".into()),
        "{json}"
    );
    for topic in [cdr, json] {
        assert!(topic["messages"].as_u64() > Some(10), "{topic}");
    }
    assert_eq!((probed.verdict("PX-CDR-02"), probed.verdict("PX-JSON-02")), ("pass", "fail"), "{probed:#?}");
    let note = "wind: not checked, because the names of ROS topics start with `/`";
    assert_eq!(probed.vehicle()["notes"], json!([note]));
    assert_eq!(probed.status, Some(1));
}

#[test]
fn the_sdk_receives_published_messages() {
    let (_peer, address) = sdk();
    let mut bus = connect(&address.parse().expect("an address"), &[], &[]).expect("a connection");
    let topic = |name: &str, type_name: &str| Topic {
        name: name.into(),
        type_name: type_name.into(),
        type_hash: None,
    };
    bus.subscribe(&topic("/echo", "px4_msgs/msg/ArmingCheckRequest"), &Qos::WEAKEST).expect("subscribe");
    let reply = topic("/fmu/in/arming_check_reply", "px4_msgs/msg/ArmingCheckReply");
    let publisher = bus.advertise(&reply, &Qos::PX4).expect("advertise");
    // The server doesn't store messages, and the subscription may not be active yet.
    let end = Instant::now() + Duration::from_secs(600);
    while Instant::now() < end {
        bus.publish(publisher, b"\0\x01\0\0reply").expect("publish");
        let until = Instant::now() + Duration::from_millis(100);
        while let Some(event) = bus.receive(until) {
            match event {
                Event::Message(message) => {
                    return assert_eq!(message.payload, b"/fmu/in/arming_check_reply \0\x01\0\0reply");
                }
                Event::Problem(problem) | Event::Closed(problem) => panic!("{problem}"),
                _ => {}
            }
        }
    }
    panic!("the server doesn't send the message back");
}

#[allow(clippy::result_large_err, clippy::unnecessary_wraps, reason = "the type of the library")]
fn accept(_: &Request, mut response: Response) -> Result<Response, ErrorResponse> {
    response.headers_mut().insert("Sec-WebSocket-Protocol", "foxglove.sdk.v1".parse().expect("a value"));
    Ok(response)
}

#[test]
fn hostile_servers_are_reported() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = format!("foxglove://{}", listener.local_addr().expect("an address"));
    let server = thread::spawn(move || {
        let (stream, _) = listener.accept().expect("a client");
        let mut socket = tungstenite::accept_hdr(stream, accept).expect("a handshake");
        let texts = [
            r#"{"op":"serverInfo","capabilities":[]}"#.to_owned(),
            format!(r#"{{"op":"advertise","channels":{}"#, "[".repeat(1 << 20)),
            r#"{"op":"advertise","channels":[{"id":1,"topic":"/a\u0000\u001b[2J","encoding":"json","schemaName":"x"}]}"#
                .to_owned(),
        ];
        for text in texts {
            socket.send(Message::text(text)).expect("sent");
        }
        let subscription = socket.read().expect("a subscription");
        assert!(subscription.to_string().contains("subscribe"), "{subscription}");
        let mut message = b"\x01\x01\0\0\0\0\0\0\0\0\0\0\0".to_vec();
        message.resize(1 << 20, b'[');
        for message in [message, vec![0xff], Vec::new()] {
            socket.send(Message::binary(message)).expect("sent");
        }
        let _ = socket.close(None);
        while socket.read().is_ok() {}
    });
    let probed = Probed::new(&address, 4);
    server.join().expect("the server");
    let text = probed.vehicle().to_string();
    for expected in [
        "nested too deeply",
        "unknown kind 255",
        "an empty binary message",
        "the server closed the connection",
    ] {
        assert!(text.contains(expected), "{expected}: {probed:#?}");
    }
    assert_eq!(probed.status, Some(6), "{probed:#?}");
}
