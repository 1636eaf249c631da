//! Tests of the reference server over its transports, using the clients of `uavspec`.
//!
//! No test depends on speed: expected messages have long time limits, and unexpected messages would arrive before the
//! answers to later requests.

mod limits;
#[cfg(target_os = "linux")]
mod siege;

use std::collections::BTreeSet;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use serde_json::{Value, json};
use uavspec_flockwave::transport::{Client, MESSAGE_LIMIT, Received, connect};
use uavspec_model::clock::Clock;
use uavspec_rules::flockwave;
use uavspec_serve::{Options, Server, Transport};
use uavspec_test_support::deadline;

/// The time for reading messages that have already arrived.
const READING_TIME: Duration = Duration::from_millis(20);

const ALL: [Transport; 4] = [Transport::Tcp, Transport::Udp, Transport::Http, Transport::SocketIo];

/// The transports, with the part of their URLs after the host and the port.
const ENDPOINTS: [(Transport, &str); 7] = [
    (Transport::Tcp, ""),
    (Transport::Udp, ""),
    (Transport::Http, "/api/v1"),
    (Transport::SocketIo, "?protocol=4&transport=websocket"),
    (Transport::SocketIo, "?protocol=4&transport=polling"),
    (Transport::SocketIo, "?protocol=5&transport=websocket"),
    (Transport::SocketIo, "?protocol=5&transport=polling"),
];

fn serve(options: Options) -> Server {
    let location = SocketAddr::from(([127, 0, 0, 1], 0));
    Server::start(options, &ALL.map(|transport| (transport, location))).expect("a server")
}

/// Starts a server that violates this rule, and sends frequent notifications.
fn serve_with_bug(rule: &str) -> Server {
    serve(Options { bug: Some(flockwave::rule(rule).expect("a rule")), rate: 20.0, ..Options::default() })
}

fn address(server: &Server, transport: Transport) -> SocketAddr {
    let location = server.listening().iter().find(|location| location.transport == transport);
    location.expect("the server listens on this transport").address
}

fn client(server: &Server, (transport, rest): (Transport, &str)) -> Box<dyn Client> {
    let url = format!("{}://{}{rest}", transport.name(), address(server, transport));
    connect(&url.parse().expect("an endpoint"), deadline()).expect("a connection")
}

fn request(id: &str, body: &Value) -> String {
    json!({ "$fw.version": "1.0", "id": id, "body": body }).to_string()
}

/// The next message.
fn receive(client: &mut dyn Client) -> Value {
    match client.receive(deadline()).expect("an open connection") {
        Received::Message(text) => serde_json::from_slice(&text).expect("JSON"),
        other => panic!("{other:?}"),
    }
}

/// Waits for the answer to a request. Skips the notifications before it.
fn answer(client: &mut dyn Client, id: &str) -> Value {
    let message = until(client, |message| message.get("refs").is_some());
    assert_eq!(message["refs"], id);
    message
}

fn request_body(client: &mut dyn Client, id: &str, body: &Value) -> Value {
    client.send(request(id, body).as_bytes()).expect("sent");
    answer(client, id)["body"].take()
}

/// Waits for the next message that matches a predicate.
fn until(client: &mut dyn Client, fits: impl Fn(&Value) -> bool) -> Value {
    loop {
        let message = receive(client);
        if fits(&message) {
            return message;
        }
    }
}

/// Receives messages until the server closes the connection.
fn until_end(client: &mut dyn Client) {
    loop {
        match client.receive(deadline()).expect("an orderly end") {
            Received::End => return,
            Received::Silence => panic!("the connection doesn't end"),
            _ => {}
        }
    }
}

/// True if an answer arrives in time.
fn is_answered(client: &mut dyn Client, end: Instant) -> bool {
    loop {
        match client.receive(end) {
            Ok(Received::Message(text)) => {
                let message = serde_json::from_slice::<Value>(&text).unwrap_or_default();
                if message.get("refs").is_some() {
                    return true;
                }
            }
            Ok(Received::Silence | Received::End) | Err(_) => return false,
            Ok(Received::TooLong | Received::OtherEvent(_)) => {}
        }
    }
}

/// Waits until the server has processed all data that has arrived.
fn settle(server: &Server) {
    let mut other = client(server, ENDPOINTS[2]);
    for id in ["first", "second", "third"] {
        request_body(&mut *other, id, &json!({ "type": "SYS-PING" }));
    }
}

/// True if there is no answer, although the server has processed all data that has arrived.
fn is_unanswered(server: &Server, client: &mut dyn Client) -> bool {
    settle(server);
    !is_answered(client, Clock::real().now() + READING_TIME)
}

#[test]
fn answers_every_family_over_every_transport() {
    let server = serve(Options { speed: 50.0, ..Options::default() });
    let requests = [
        ("ACK-ACK", json!({}), "ACK-NAK"),
        ("ASYNC-CANCEL", json!({ "ids": ["r-1"] }), "ASYNC-CANCEL"),
        ("AUTH-INF", json!({}), "AUTH-INF"),
        ("AUTH-REQ", json!({ "method": "basic", "data": "" }), "AUTH-RESP"),
        ("CLK-LIST", json!({}), "CLK-LIST"),
        ("CONN-LIST", json!({}), "CONN-LIST"),
        ("DEV-LIST", json!({ "ids": ["glider-1"] }), "DEV-LIST"),
        ("EXT-LIST", json!({}), "EXT-LIST"),
        ("GLIDE-INF", json!({}), "ACK-NAK"),
        ("OBJ-LIST", json!({}), "OBJ-LIST"),
        ("PRM-GET", json!({ "ids": ["glider-1"], "name": "CRUISE_SPEED" }), "PRM-GET"),
        ("RTK-LIST", json!({}), "RTK-LIST"),
        ("RTK-SOURCE", json!({ "id": null }), "ACK-ACK"),
        ("SYS-PING", json!({}), "ACK-ACK"),
        ("UAV-INF", json!({ "ids": ["glider-1", "glider-9"] }), "UAV-INF"),
        ("WTH-LIST", json!({}), "WTH-LIST"),
    ];
    for endpoint in ENDPOINTS {
        let mut client = client(&server, endpoint);
        let mut ids = BTreeSet::new();
        for (number, (kind, fields, expected)) in requests.iter().enumerate() {
            let mut body = fields.clone();
            body["type"] = json!(kind);
            let id = format!("Höhe \u{1fa82} {number}");
            client.send(request(&id, &body).as_bytes()).expect("sent");
            let message = answer(&mut *client, &id);
            assert_eq!(message["body"]["type"], *expected, "{endpoint:?}: {message}");
            let is_new = ids.insert(message["id"].as_str().expect("an id").to_owned());
            assert!(is_new || endpoint.0 == Transport::Http, "{endpoint:?}: {message}");
        }
    }
}

#[test]
fn reports_the_ports_it_listens_on() {
    let server = serve(Options::default());
    let ports = request_body(&mut *client(&server, ENDPOINTS[0]), "a", &json!({ "type": "SYS-PORTS" }));
    for transport in ALL {
        assert_eq!(ports["ports"][transport.name()], address(&server, transport).port());
    }
}

#[test]
fn listens_on_ipv6_addresses() {
    let location = SocketAddr::from(([0, 0, 0, 0, 0, 0, 0, 1], 0));
    if UdpSocket::bind(location).is_err() {
        // This machine has no IPv6.
        return;
    }
    let server =
        Server::start(Options::default(), &ALL.map(|transport| (transport, location))).expect("a server");
    for endpoint in ENDPOINTS {
        assert_eq!(
            request_body(&mut *client(&server, endpoint), "a", &json!({ "type": "SYS-PING" })),
            json!({ "type": "ACK-ACK" })
        );
    }
}

#[test]
fn sends_status_reports_without_a_request() {
    let server = serve(Options { rate: 20.0, ..Options::default() });
    for endpoint in ENDPOINTS.into_iter().filter(|(transport, _)| *transport != Transport::Http) {
        let mut client = client(&server, endpoint);
        // Over UDP, the server knows a client only after the client's first datagram.
        request_body(&mut *client, "a", &json!({ "type": "SYS-PING" }));
        let message = until(&mut *client, |message| message["body"]["type"] == "UAV-INF");
        assert!(message.get("refs").is_none());
        assert_eq!(message["body"]["status"].as_object().map(serde_json::Map::len), Some(5));
    }
}

#[test]
fn accepts_split_and_concatenated_requests() {
    let server = serve(Options::default());
    let mut client = client(&server, ENDPOINTS[0]);
    let text = request("whole", &json!({ "type": "SYS-PING" })) + "\r\n";
    for piece in text.as_bytes().chunks(7) {
        client.send_raw(piece).expect("sent");
        settle(&server);
    }
    answer(&mut *client, "whole");
    let many: String =
        (0..100).map(|id| request(&id.to_string(), &json!({ "type": "SYS-PING" })) + "\n").collect();
    client.send_raw(many.as_bytes()).expect("sent");
    for id in 0..100 {
        answer(&mut *client, &id.to_string());
    }
}

#[test]
fn answers_after_the_client_closed_its_output() {
    let server = serve(Options::default());
    let mut client = client(&server, ENDPOINTS[0]);
    client.send(request("a", &json!({ "type": "UAV-LIST" })).as_bytes()).expect("sent");
    client.finish().expect("the output is closed");
    answer(&mut *client, "a");
    until_end(&mut *client);
}

#[test]
fn ignores_invalid_messages() {
    let server = serve(Options::default());
    for endpoint in ENDPOINTS.into_iter().filter(|(transport, _)| *transport != Transport::Http) {
        let mut client = client(&server, endpoint);
        for text in
            ["7", "\"glider\"", "[]", "{}", "null", r#"{"id":"a","refs":"b","body":{"type":"ACK-ACK"}}"#]
        {
            client.send(text.as_bytes()).expect("sent");
        }
        if endpoint.0 != Transport::SocketIo {
            client.send(b"\xff\xfe glider {").expect("sent");
        }
        request_body(&mut *client, "after", &json!({ "type": "SYS-PING" }));
    }
    let mut client = client(&server, ENDPOINTS[2]);
    assert!(client.send(b"glider").is_err(), "a one-shot request fails with an HTTP status");
}

#[test]
fn drops_an_endless_line() {
    let server = serve(Options::default());
    let mut client = client(&server, ENDPOINTS[0]);
    let mut line = vec![b'x'; MESSAGE_LIMIT + 100];
    line.push(b'\n');
    client.send_raw(&line).expect("sent");
    request_body(&mut *client, "after", &json!({ "type": "SYS-PING" }));
}

#[test]
fn rejects_malformed_requests_by_id() {
    let server = serve(Options::default());
    let mut client = client(&server, ENDPOINTS[0]);
    for (text, wrong) in [
        (json!({ "id": "a", "body": { "type": "SYS-PING" } }), "$fw.version"),
        (json!({ "$fw.version": "1.0", "id": "a" }), "body"),
        (json!({ "$fw.version": "1.0", "id": "a", "body": { "type": 7 } }), "type"),
        (
            json!({ "$fw.version": "1.0", "id": "a", "body": { "type": "UAV-INF" } }),
            "UAV-INF: missing field `ids`",
        ),
        (
            json!({ "$fw.version": "1.0", "id": "a", "body": { "type": "UAV-INF", "ids": "glider-1" } }),
            "ids: invalid type: string",
        ),
        (
            json!({ "$fw.version": "1.0", "id": "a", "body": { "type": "UAV-INF", "ids": [7] } }),
            "ids: [0]: invalid type: integer",
        ),
        (
            json!({ "$fw.version": "1.0", "id": "a", "body": { "type": "UAV-FLY", "ids": [], "target": [9e99, 0] } }),
            "target",
        ),
        (
            json!({ "$fw.version": "1.0", "id": "a", "body": { "type": "SYS-TIME", "adjustment": -1 } }),
            "negative",
        ),
        (
            json!({ "$fw.version": "1.0", "id": "a", "body": { "type": "SYS-TIME", "adjustment": 1e300 } }),
            "too large",
        ),
    ] {
        client.send(text.to_string().as_bytes()).expect("sent");
        let body = answer(&mut *client, "a")["body"].take();
        assert_eq!(body["type"], "ACK-NAK");
        assert!(body["reason"].as_str().is_some_and(|reason| reason.contains(wrong)), "{body}");
    }
}

#[test]
fn reports_operations_only_to_the_client_that_started_them() {
    let server = serve(Options { speed: 20.0, rate: 0.0, ..Options::default() });
    let (mut first, mut second) = (client(&server, ENDPOINTS[0]), client(&server, ENDPOINTS[5]));
    let body = request_body(
        &mut *first,
        "a",
        &json!({ "type": "UAV-CALIB", "ids": ["glider-1"], "component": "compass" }),
    );
    let receipt = &body["receipt"]["glider-1"];
    let suspended = until(&mut *first, |message| message["body"]["suspended"] == json!(true));
    assert_eq!(suspended["body"]["id"], *receipt);
    let resume = json!({ "type": "ASYNC-RESUME", "ids": [receipt] });
    let foreign = request_body(&mut *second, "b", &resume);
    assert_eq!(
        (&foreign["success"], foreign["error"].as_object().map(serde_json::Map::len)),
        (&json!([]), Some(1))
    );
    assert_eq!(request_body(&mut *first, "c", &resume)["success"], json!([receipt]));
    let end = until(&mut *first, |message| message["body"]["type"] == "ASYNC-RESP");
    assert_eq!((&end["body"]["id"], &end["body"]["result"]), (receipt, &json!(true)));
    let end = Clock::real().now() + READING_TIME;
    assert_eq!(second.receive(end).expect("an open connection"), Received::Silence);
}

#[test]
fn one_shot_requests_wait_for_operations() {
    let server = serve(Options { speed: 20.0, ..Options::default() });
    let mut client = client(&server, ENDPOINTS[2]);
    let body = request_body(
        &mut *client,
        "a",
        &json!({ "type": "UAV-TEST", "ids": ["glider-1", "glider-9"], "component": "led" }),
    );
    let expected = json!({
        "type": "UAV-TEST", "result": { "glider-1": true }, "error": { "glider-9": "no such UAV" },
    });
    assert_eq!(body, expected);
    let body =
        request_body(&mut *client, "b", &json!({ "type": "LOG-DATA", "uavId": "glider-1", "logId": "1" }));
    assert_eq!((&body["result"]["id"], body.get("receipt")), (&json!("1"), None));
    client.send(br#"{"type":"SYS-PING"}"#).expect("sent");
    assert_eq!(
        receive(&mut *client),
        json!({ "type": "ACK-ACK" }),
        "the answer to a request without an envelope has none"
    );
}

#[test]
fn notifies_other_clients_of_a_flight() {
    let server = serve(Options { speed: 20.0, rate: 20.0, ..Options::default() });
    let (mut pilot, mut watcher) = (client(&server, ENDPOINTS[0]), client(&server, ENDPOINTS[6]));
    let result = request_body(&mut *pilot, "a", &json!({ "type": "UAV-TAKEOFF", "ids": ["glider-2"] }));
    assert_eq!(result["result"], json!({ "glider-2": true }));
    let state = |message: &Value| message["body"]["status"]["glider-2"].clone();
    let hovering = until(&mut *watcher, |message| state(message)["mode"] == "loiter");
    assert_eq!((&state(&hovering)["errors"], &state(&hovering)["position"][3]), (&json!([]), &json!(10_000)));
    request_body(
        &mut *pilot,
        "b",
        &json!({ "type": "OBJ-CMD", "ids": ["glider-2"], "command": "battery", "args": [15] }),
    );
    let reported = until(&mut *watcher, |message| message["body"]["type"] == "SYS-MSG");
    let item = &reported["body"]["items"][0];
    assert_eq!((&item["sender"], &item["severity"]), (&json!("glider-2"), &json!("error")));
    until(&mut *watcher, |message| state(message)["errors"] == json!([1, 134]));
}

#[test]
fn upgrades_polling_clients_to_a_web_socket() {
    let server = serve(Options::default());
    let location = address(&server, Transport::SocketIo);
    for (revision, length_ahead) in [(3, true), (4, false)] {
        let base = format!("{location}/socket.io/?EIO={revision}");
        let url = format!("http://{base}&transport=polling");
        let get =
            |url: &str| ureq::get(url).call().expect("a response").body_mut().read_to_string().expect("text");
        let opened = get(&url);
        let opening = &opened[opened.find('{').expect("an object")..=opened.find('}').expect("its end")];
        let sid =
            serde_json::from_str::<Value>(opening).expect("JSON")["sid"].as_str().expect("an id").to_owned();
        let post = |text: &str| {
            let text = if length_ahead { format!("{}:{text}", text.len()) } else { text.to_owned() };
            ureq::post(format!("{url}&sid={sid}")).send(&text).expect("accepted");
        };
        if revision == 4 {
            post("40");
        }
        let (mut socket, _) =
            tungstenite::connect(format!("ws://{base}&transport=websocket&sid={sid}")).expect("a WebSocket");
        socket.send("2probe".into()).expect("sent");
        assert_eq!(socket.read().expect("an answer").to_text().expect("text"), "3probe");
        socket.send("5".into()).expect("sent");
        let text = request("a", &json!({ "type": "SYS-PING" }));
        socket.send(format!("42[\"fw\",{text}]").into()).expect("sent");
        loop {
            let packet = socket.read().expect("a packet");
            let packet = packet.to_text().expect("text").to_owned();
            if let Some(event) = packet.strip_prefix("42").filter(|event| event.contains("\"refs\"")) {
                let event: Value = serde_json::from_str(event).expect("JSON");
                assert_eq!((&event[0], &event[1]["body"]["type"]), (&json!("fw"), &json!("ACK-ACK")));
                break;
            }
        }
        let status =
            ureq::get(format!("{url}&sid={sid}")).call().expect_err("the session was upgraded").to_string();
        assert!(status.contains("400"), "{status}");
    }
}

#[test]
fn rejects_invalid_socket_io_requests() {
    let server = serve(Options::default());
    let location = address(&server, Transport::SocketIo);
    for (path, status) in [
        ("/", 404),
        ("/socket.io/", 400),
        ("/socket.io/?EIO=5&transport=polling", 400),
        ("/socket.io/?EIO=4&transport=pigeon", 400),
        ("/socket.io/?EIO=4&transport=polling&sid=nobody", 400),
        ("/socket.io/?EIO=4&transport=polling&j=0", 400),
    ] {
        let output = ureq::get(format!("http://{location}{path}")).call().expect_err(path);
        assert!(matches!(output, ureq::Error::StatusCode(code) if code == status), "{path}: {output}");
    }
    let namespace =
        "ws://ADDRESS/socket.io/?EIO=4&transport=websocket".replace("ADDRESS", &location.to_string());
    let (mut socket, _) = tungstenite::connect(namespace).expect("a WebSocket");
    socket.read().expect("the session is opened");
    socket.send("40/wind,".into()).expect("sent");
    let output = socket.read().expect("an answer");
    assert_eq!(output.to_text().expect("text"), "44/wind,{\"message\":\"Invalid namespace\"}");
}

#[test]
fn keeps_serving_after_garbage() {
    let server = serve(Options::default());
    let streams =
        [Transport::Tcp, Transport::Http, Transport::SocketIo].map(|transport| address(&server, transport));
    let udp = address(&server, Transport::Udp);
    let bytes = prop::collection::vec(any::<u8>(), 0..300);
    let prefix = prop::sample::select(vec![
        "",
        "POST /api/v1 HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: 40\r\n\r\n",
        "POST /socket.io/?EIO=3&transport=polling&sid=x HTTP/1.1\r\nContent-Length: 9\r\n\r\n",
        "GET /socket.io/?EIO=4&transport=websocket HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
        "{\"$fw.version\":\"1.0\",\"id\":\"a\",\"body\":",
    ]);
    let mut runner = TestRunner::new(ProptestConfig::with_cases(60));
    let outcome = runner.run(&(prefix, bytes), |(prefix, bytes)| {
        let text = [prefix.as_bytes(), &bytes].concat();
        for location in streams {
            let mut stream = TcpStream::connect(location).expect("a connection");
            // The server may close the connection before it has read all data.
            let _ = stream.write_all(&text).and_then(|()| stream.write_all(b"\n"));
        }
        let socket = UdpSocket::bind("127.0.0.1:0").expect("a port");
        socket.send_to(&text, udp).expect("sent");
        Ok(())
    });
    outcome.expect("it can be sent");
    for endpoint in ENDPOINTS {
        request_body(&mut *client(&server, endpoint), "after", &json!({ "type": "SYS-PING" }));
    }
}

#[test]
fn requires_the_login() {
    let server =
        serve(Options { login: Some(("pilot".to_owned(), "soar".to_owned())), ..Options::default() });
    let mut client = client(&server, ENDPOINTS[3]);
    let list = json!({ "type": "UAV-LIST" });
    assert_eq!(request_body(&mut *client, "a", &list)["type"], "ACK-NAK");
    let login = json!({ "type": "AUTH-REQ", "method": "basic", "data": "cGlsb3Q6c29hcg==" });
    assert_eq!(
        request_body(&mut *client, "b", &login),
        json!({ "type": "AUTH-RESP", "result": true, "user": "pilot" })
    );
    assert_eq!(request_body(&mut *client, "c", &list)["type"], "UAV-LIST");

    let url = format!("http://{}/api/v1", address(&server, Transport::Http));
    let post = |credentials: Option<&str>| {
        let request = ureq::post(&url).header("Content-Type", "application/json");
        let request = match credentials {
            Some(credentials) => request.header("Authorization", credentials),
            None => request,
        };
        request.send(list.to_string()).map(|response| response.status().as_u16())
    };
    assert!(matches!(post(None), Err(ureq::Error::StatusCode(401))));
    assert!(matches!(post(Some("Basic eA==")), Err(ureq::Error::StatusCode(403))));
    assert_eq!(post(Some("Basic cGlsb3Q6c29hcg==")).expect("a response"), 200);
}

#[test]
fn tcp_bugs_are_observable() {
    let ping = |id: &str| request(id, &json!({ "type": "SYS-PING" }));
    let is_json = |received: &Received| matches!(received, Received::Message(text) if serde_json::from_slice::<Value>(text).is_ok());

    let server = serve_with_bug("FW-TCP-01");
    let mut spread = client(&server, ENDPOINTS[0]);
    let lines: Vec<Received> = (0..20).map(|_| spread.receive(deadline()).expect("a line")).collect();
    assert!(!lines.iter().all(is_json), "a message is split into several lines");

    let server = serve_with_bug("FW-TCP-02");
    let mut merged = client(&server, ENDPOINTS[0]);
    merged.send(ping("a").as_bytes()).expect("sent");
    answer(&mut *merged, "a");
    // Both lines usually arrive in one segment, but not always.
    let is_seen = (0..20).any(|_| {
        merged.send_raw(format!("{}\n{}\n", ping("b"), ping("c")).as_bytes()).expect("sent");
        answer(&mut *merged, "b");
        is_unanswered(&server, &mut *merged)
    });
    assert!(is_seen);

    let server = serve_with_bug("FW-TCP-03");
    let mut strict = client(&server, ENDPOINTS[0]);
    strict.send(b"glider").expect("sent");
    until_end(&mut *strict);

    let server = serve_with_bug("FW-TCP-04");
    let mut forgetful = client(&server, ENDPOINTS[0]);
    let text = ping("a") + "\n";
    forgetful.send_raw(&text.as_bytes()[..20]).expect("sent");
    settle(&server);
    forgetful.send_raw(&text.as_bytes()[20..]).expect("sent");
    assert!(is_unanswered(&server, &mut *forgetful));
}

#[test]
fn udp_bugs_are_observable() {
    let ping = request("a", &json!({ "type": "SYS-PING" }));
    let server = serve_with_bug("FW-UDP-01");
    let mut doubled = client(&server, ENDPOINTS[1]);
    doubled.send(ping.as_bytes()).expect("sent");
    loop {
        let Received::Message(text) = doubled.receive(deadline()).expect("a datagram") else {
            panic!("no datagram")
        };
        if serde_json::from_slice::<Value>(&text).is_err() {
            break;
        }
    }
    let server = serve_with_bug("FW-UDP-02");
    let [mut first, mut second] = [0; 2].map(|_| client(&server, ENDPOINTS[1]));
    first.send(ping.as_bytes()).expect("sent");
    assert!(is_answered(&mut *first, deadline()));
    second.send(ping.as_bytes()).expect("sent");
    assert!(is_unanswered(&server, &mut *second));
    assert!(is_answered(&mut *first, deadline()), "the first client receives the answer");
    let server = serve_with_bug("FW-UDP-03");
    let mut client = client(&server, ENDPOINTS[1]);
    client.send(b"glider").expect("sent");
    settle(&server);
    // Sending may fail if the port is closed.
    let _ = client.send(ping.as_bytes());
    assert!(is_unanswered(&server, &mut *client));
}

#[test]
fn socket_io_bugs_are_observable() {
    let server = serve_with_bug("FW-SIO-01");
    for endpoint in &ENDPOINTS[3..] {
        let mut client = client(&server, *endpoint);
        client.send(request("a", &json!({ "type": "SYS-PING" })).as_bytes()).expect("sent");
        assert!(is_unanswered(&server, &mut *client), "{endpoint:?}");
    }
    let server = serve_with_bug("FW-SIO-02");
    let url = format!("socketio://{}?transport=polling", address(&server, Transport::SocketIo));
    let refused = connect(&url.parse().expect("an endpoint"), deadline()).err().expect("no polling");
    assert!(refused.to_string().contains("400"), "{refused}");
    request_body(&mut *client(&server, ENDPOINTS[5]), "a", &json!({ "type": "SYS-PING" }));
}

#[test]
fn notifies_all_clients_of_the_shutdown() {
    let server = serve(Options::default());
    let endpoints: Vec<_> =
        ENDPOINTS.into_iter().filter(|(transport, _)| *transport != Transport::Http).collect();
    let mut clients: Vec<_> = endpoints.iter().map(|endpoint| client(&server, *endpoint)).collect();
    for client in &mut clients {
        request_body(&mut **client, "a", &json!({ "type": "SYS-PING" }));
    }
    let ending = thread::spawn(move || server.end());
    for (client, endpoint) in clients.iter_mut().zip(&endpoints) {
        until(&mut **client, |message| message["body"]["type"] == "SYS-CLOSE");
        if endpoint.0 != Transport::Udp {
            assert_eq!(client.receive(deadline()).expect("an orderly end"), Received::End, "{endpoint:?}");
        }
    }
    ending.join().expect("the end");
}

/// Starts the program. Returns the process, and the first line of its output.
fn program(arguments: &[&str]) -> (Child, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    command.arg("serve").args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().expect("uavspec runs");
    let mut line = String::new();
    BufReader::new(child.stdout.as_mut().expect("its output")).read_line(&mut line).expect("a line");
    (child, line)
}

#[test]
fn serve_prints_its_addresses_and_stops_on_request() {
    let (mut child, line) = program(&["--tcp", "127.0.0.1:0", "--until-stdin-closes"]);
    let mut client = connect(&line.trim().parse().expect("an endpoint"), deadline()).expect("a connection");
    request_body(&mut *client, "a", &json!({ "type": "SYS-PING" }));
    drop(child.stdin.take());
    assert_eq!(child.wait().expect("the end").code(), Some(0));

    let (mut child, line) = program(&["--udp", "127.0.0.1:0", "--for", "0.2", "--format", "json"]);
    let location: Value = serde_json::from_str(&line).expect("JSON");
    assert_eq!(
        (&location["transport"], location["port"].as_u64().is_some_and(|port| port > 0)),
        (&json!("udp"), true)
    );
    assert_eq!(child.wait().expect("the end").code(), Some(0));
}

#[test]
fn reports_wrong_usage() {
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_uavspec"))
            .arg("serve")
            .args(arguments)
            .output()
            .expect("uavspec runs");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    for (arguments, wrong) in [
        (&["--bug", "FW-NONE-01"][..], "--list-bugs"),
        (&["--error", "glider-9=66"], "glider-1 to glider-5"),
        (&["--error", "glider-1=50"], "defines no error code 50"),
        (&["--login", "pilot"], "NAME:PASSWORD"),
        (&["--speed", "0"], "0.01"),
        (&["--px4", "zenoh://a", "--component", "--bug", "PX-QOS-01"], "such as dds://DOMAIN"),
        (&["--px4", "dds://0", "--bug", "PX-CDR-01"], "headers unchanged, such as zenoh://HOST:PORT"),
        (&["--px4", "dds://0", "--bug", "PX-TYPE-01"], "type hashes, such as zenoh://HOST:PORT"),
        (&["--px4", "dds://0", "--bug", "PX-QOS-01"], "use --px4 URL --component"),
    ] {
        let (status, _, output) = run(arguments);
        assert_eq!(status, Some(2), "{output}");
        assert!(output.contains(wrong), "{output}");
    }
    let server = serve(Options::default());
    let (status, _, output) = run(&["--tcp", &address(&server, Transport::Tcp).to_string()]);
    assert_eq!(status, Some(3));
    assert!(output.contains("can't listen on"), "{output}");
    let (status, printed, _) = run(&["--list-bugs"]);
    assert_eq!(status, Some(0));
    assert!(
        printed.lines().count() > 100
            && printed.contains("FW-UST-HEADING     The heading of a UAV is 3600.")
            && printed.contains("PX-QOS-01          The component requests reliable delivery"),
        "{printed}"
    );
}

#[test]
fn serves_others_while_a_client_reads_nothing() {
    let server = serve(Options { uavs: 200, rate: 0.0, ..Options::default() });
    let mut idle = TcpStream::connect(address(&server, Transport::Tcp)).expect("a connection");
    let ids: Vec<String> = (1..=200).map(|number| format!("glider-{number}")).collect();
    let text = request("a", &json!({ "type": "UAV-INF", "ids": ids })) + "\n";
    idle.set_nonblocking(true).expect("a socket");
    // The server reads only as many requests as it can answer.
    while idle.write(text.as_bytes()).is_ok() {}
    idle.set_nonblocking(false).expect("a socket");
    request_body(&mut *client(&server, ENDPOINTS[0]), "a", &json!({ "type": "SYS-PING" }));
    // The messages for the idle client are still available.
    let mut first = [0; 20];
    idle.read_exact(&mut first).expect("an answer");
    assert!(first.starts_with(b"{\"$fw.version\""));
}
