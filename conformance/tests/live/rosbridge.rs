//! Tests with a rosbridge server. No other implementation runs without ROS, so the server is part of the test.

use std::net::TcpListener;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::{Error, Message};

use super::probe::Probed;

const TOPIC: &str = "/fmu/out/arming_check_request";

/// Starts a server with one topic. The server sends messages once the client has subscribed to the topic.
fn serve(has_rosapi: bool) -> (JoinHandle<()>, String) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = format!("rosbridge://{}", listener.local_addr().expect("an address"));
    let server = thread::spawn(move || {
        let (stream, _) = listener.accept().expect("a client");
        stream.set_read_timeout(Some(Duration::from_millis(50))).expect("a time limit");
        let mut socket = tungstenite::accept(stream).expect("a handshake");
        let (mut is_subscribed, mut number) = (false, 0);
        loop {
            match socket.read() {
                Ok(Message::Text(text)) => {
                    let request: Value = serde_json::from_str(&text).expect("JSON");
                    is_subscribed |= request["op"] == "subscribe" && request["topic"] == TOPIC;
                    if request["op"] == "call_service" {
                        let answer = topics(&request, has_rosapi).to_string();
                        socket.send(Message::text(answer)).expect("sent");
                    }
                }
                Ok(_) | Err(Error::Io(_)) => {}
                Err(_) => return,
            }
            if is_subscribed {
                number += 1;
                let message = json!({ "op": "publish", "topic": TOPIC, "msg": request_of(number) });
                if socket.send(Message::text(message.to_string())).is_err() {
                    return;
                }
            }
        }
    });
    (server, address)
}

/// The answer of rosapi to a request.
fn topics(request: &Value, has_rosapi: bool) -> Value {
    assert_eq!(request["service"], "/rosapi/topics");
    let values = if has_rosapi {
        json!({ "topics": [TOPIC], "types": ["px4_msgs/msg/ArmingCheckRequest"] })
    } else {
        json!("Service /rosapi/topics does not exist")
    };
    let (id, service) = (&request["id"], &request["service"]);
    json!({ "op": "service_response", "id": id, "service": service, "values": values, "result": has_rosapi })
}

/// A message that conforms, except that every tenth message has a field of the wrong type.
fn request_of(number: u64) -> Value {
    let id = if number.is_multiple_of(10) { json!("text") } else { json!(number % 256) };
    json!({ "timestamp": 1_000_000 + 50_000 * number, "request_id": id, "valid_registrations_mask": 0 })
}

#[test]
fn listed_topics_are_received_and_checked() {
    let (server, address) = serve(true);
    let probed = Probed::new(&address, 4);
    server.join().expect("the server");
    let topic = probed.topic(TOPIC);
    assert_eq!(
        (&topic["encoding"], &topic["schema"]),
        (&"json".into(), &"px4_msgs/msg/ArmingCheckRequest".into())
    );
    assert!(topic["messages"].as_u64() > Some(10), "{topic}");
    assert_eq!((probed.verdict("PX-JSON-01"), probed.verdict("PX-JSON-02")), ("pass", "fail"), "{probed:#?}");
    assert_eq!(probed.status, Some(1));
}

#[test]
fn named_topics_are_received_without_rosapi() {
    let (server, address) = serve(false);
    let probed = Probed::with(&address, 4, &["--topics", TOPIC]);
    server.join().expect("the server");
    let topic = probed.topic(TOPIC);
    assert!(topic["messages"].as_u64() > Some(10), "{topic}");
    assert_eq!((probed.verdict("PX-JSON-01"), probed.verdict("PX-JSON-02")), ("pass", "fail"), "{probed:#?}");
}

#[test]
fn a_missing_rosapi_is_explained() {
    let (server, address) = serve(false);
    let probed = Probed::new(&address, 2);
    server.join().expect("the server");
    let text = probed.vehicle().to_string();
    assert!(text.contains("does not exist") && text.contains("rosapi_node"), "{probed:#?}");
}
