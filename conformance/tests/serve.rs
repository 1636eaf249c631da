//! The reference server over its transports, with the clients that `uavspec` has for live servers.
//!
//! Nothing here depends on something being fast: whoever waits for a message has plenty of time.

use std::collections::BTreeSet;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use serde_json::{Value, json};
use uavspec_conformance::rules::flockwave;
use uavspec_conformance::serve::{Options, Server, Transport};
use uavspec_conformance::transport::{Client, MESSAGE_LIMIT, Received, connect};

/// How long something may take that has to happen.
const PATIENCE: Duration = Duration::from_secs(60);

/// How long it is listened for something that must not happen.
const SILENCE: Duration = Duration::from_millis(500);

const ALL: [Transport; 4] = [Transport::Tcp, Transport::Udp, Transport::Http, Transport::SocketIo];

/// The ways to connect, but for host and port.
const WAYS: [(Transport, &str); 7] = [
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
    Server::start(options, &ALL.map(|transport| (transport, location))).expect("it starts")
}

/// A server that breaks a rule, and that tells often of the fleet.
fn broken(rule: &str) -> Server {
    serve(Options { bug: Some(flockwave::rule(rule).expect("a rule")), rate: 20.0, ..Options::default() })
}

fn address(server: &Server, transport: Transport) -> SocketAddr {
    let location = server.listening().iter().find(|location| location.transport == transport);
    location.expect("it listens there").address
}

fn client(server: &Server, (transport, rest): (Transport, &str)) -> Box<dyn Client> {
    let url = format!("{}://{}{rest}", transport.name(), address(server, transport));
    connect(&url.parse().expect("an endpoint"), Instant::now() + PATIENCE).expect("a connection")
}

fn request(id: &str, body: &Value) -> String {
    json!({ "$fw.version": "1.0", "id": id, "body": body }).to_string()
}

/// The next message.
fn receive(client: &mut dyn Client) -> Value {
    match client.receive(Instant::now() + PATIENCE).expect("the connection holds") {
        Received::Message(text) => serde_json::from_slice(&text).expect("JSON"),
        other => panic!("{other:?}"),
    }
}

/// The answer to a request, after notifications.
fn answer(client: &mut dyn Client, id: &str) -> Value {
    let until = Instant::now() + PATIENCE;
    while Instant::now() < until {
        let message = receive(client);
        if message.get("refs").is_some() {
            assert_eq!(message["refs"], id);
            return message;
        }
    }
    panic!("no answer to {id}");
}

fn ask(client: &mut dyn Client, id: &str, body: &Value) -> Value {
    client.send(request(id, body).as_bytes()).expect("it is sent");
    answer(client, id)["body"].take()
}

/// The next message that fits, whatever comes between.
fn until(client: &mut dyn Client, fits: impl Fn(&Value) -> bool) -> Value {
    let end = Instant::now() + PATIENCE;
    while Instant::now() < end {
        let message = receive(client);
        if fits(&message) {
            return message;
        }
    }
    panic!("what was waited for didn't come");
}

/// Whether an answer comes.
fn is_answered(client: &mut dyn Client, patience: Duration) -> bool {
    let end = Instant::now() + patience;
    loop {
        match client.receive(end) {
            Ok(Received::Message(text)) => {
                let message = serde_json::from_slice::<Value>(&text).unwrap_or_default();
                if message.get("refs").is_some() {
                    return true;
                }
            }
            Ok(Received::Silence | Received::End) | Err(_) => return false,
            Ok(Received::TooLong) => {}
        }
    }
}

#[test]
fn every_family_is_answered_over_every_transport() {
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
    for way in WAYS {
        let mut client = client(&server, way);
        let mut ids = BTreeSet::new();
        for (number, (kind, fields, expected)) in requests.iter().enumerate() {
            let mut body = fields.clone();
            body["type"] = json!(kind);
            let id = format!("Höhe \u{1fa82} {number}");
            client.send(request(&id, &body).as_bytes()).expect("it is sent");
            let message = answer(&mut *client, &id);
            assert_eq!(message["body"]["type"], *expected, "{way:?}: {message}");
            let is_new = ids.insert(message["id"].as_str().expect("an id").to_owned());
            assert!(is_new || way.0 == Transport::Http, "{way:?}: {message}");
        }
    }
}

#[test]
fn reports_the_ports_it_listens_on() {
    let server = serve(Options::default());
    let ports = ask(&mut *client(&server, WAYS[0]), "a", &json!({ "type": "SYS-PORTS" }));
    for transport in ALL {
        assert_eq!(ports["ports"][transport.name()], address(&server, transport).port());
    }
}

#[test]
fn it_listens_at_addresses_of_the_newer_kind_as_well() {
    let location = SocketAddr::from(([0, 0, 0, 0, 0, 0, 0, 1], 0));
    if UdpSocket::bind(location).is_err() {
        // This machine has no IPv6.
        return;
    }
    let server =
        Server::start(Options::default(), &ALL.map(|transport| (transport, location))).expect("it starts");
    for way in WAYS {
        assert_eq!(
            ask(&mut *client(&server, way), "a", &json!({ "type": "SYS-PING" })),
            json!({ "type": "ACK-ACK" })
        );
    }
}

#[test]
fn sends_status_reports_without_a_request() {
    let server = serve(Options { rate: 20.0, ..Options::default() });
    for way in WAYS.into_iter().filter(|(transport, _)| *transport != Transport::Http) {
        let mut client = client(&server, way);
        // Over UDP the server knows of a client when it has said something.
        ask(&mut *client, "a", &json!({ "type": "SYS-PING" }));
        let message = until(&mut *client, |message| message["body"]["type"] == "UAV-INF");
        assert!(message.get("refs").is_none());
        assert_eq!(message["body"]["status"].as_object().map(serde_json::Map::len), Some(5));
    }
}

#[test]
fn requests_may_come_in_pieces_and_several_at_once() {
    let server = serve(Options::default());
    let mut client = client(&server, WAYS[0]);
    let text = request("whole", &json!({ "type": "SYS-PING" })) + "\r\n";
    for piece in text.as_bytes().chunks(7) {
        client.send_raw(piece).expect("it is sent");
        thread::sleep(Duration::from_millis(2));
    }
    answer(&mut *client, "whole");
    let many: String =
        (0..100).map(|id| request(&id.to_string(), &json!({ "type": "SYS-PING" })) + "\n").collect();
    client.send_raw(many.as_bytes()).expect("it is sent");
    for id in 0..100 {
        answer(&mut *client, &id.to_string());
    }
}

#[test]
fn answers_after_the_client_closed_its_output() {
    let server = serve(Options::default());
    let mut client = client(&server, WAYS[0]);
    client.send(request("a", &json!({ "type": "UAV-LIST" })).as_bytes()).expect("it is sent");
    client.finish().expect("it is said");
    answer(&mut *client, "a");
    let end = Instant::now() + PATIENCE;
    while client.receive(end).expect("the connection holds") != Received::End {
        assert!(Instant::now() < end);
    }
}

#[test]
fn what_is_no_message_is_passed_over() {
    let server = serve(Options::default());
    for way in WAYS.into_iter().filter(|(transport, _)| *transport != Transport::Http) {
        let mut client = client(&server, way);
        for text in
            ["7", "\"glider\"", "[]", "{}", "null", r#"{"id":"a","refs":"b","body":{"type":"ACK-ACK"}}"#]
        {
            client.send(text.as_bytes()).expect("it is sent");
        }
        if way.0 != Transport::SocketIo {
            client.send(b"\xff\xfe glider {").expect("it is sent");
        }
        ask(&mut *client, "after", &json!({ "type": "SYS-PING" }));
    }
    let mut client = client(&server, WAYS[2]);
    assert!(client.send(b"glider").is_err(), "a one-shot has nothing but the status to say so");
}

#[test]
fn a_line_without_end_is_dropped() {
    let server = serve(Options::default());
    let mut client = client(&server, WAYS[0]);
    let mut line = vec![b'x'; MESSAGE_LIMIT + 100];
    line.push(b'\n');
    client.send_raw(&line).expect("it is sent");
    ask(&mut *client, "after", &json!({ "type": "SYS-PING" }));
}

#[test]
fn malformed_requests_are_refused_by_their_ids() {
    let server = serve(Options::default());
    let mut client = client(&server, WAYS[0]);
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
            "ids: invalid type: integer",
        ),
        (
            json!({ "$fw.version": "1.0", "id": "a", "body": { "type": "UAV-FLY", "ids": [], "target": [9e99, 0] } }),
            "target",
        ),
        (
            json!({ "$fw.version": "1.0", "id": "a", "body": { "type": "SYS-TIME", "adjustment": -1 } }),
            "forward",
        ),
        (
            json!({ "$fw.version": "1.0", "id": "a", "body": { "type": "SYS-TIME", "adjustment": 1e300 } }),
            "too far",
        ),
    ] {
        client.send(text.to_string().as_bytes()).expect("it is sent");
        let body = answer(&mut *client, "a")["body"].take();
        assert_eq!(body["type"], "ACK-NAK");
        assert!(body["reason"].as_str().is_some_and(|reason| reason.contains(wrong)), "{body}");
    }
}

#[test]
fn operations_concern_the_client_that_started_them() {
    let server = serve(Options { speed: 20.0, rate: 0.0, ..Options::default() });
    let (mut first, mut second) = (client(&server, WAYS[0]), client(&server, WAYS[5]));
    let body =
        ask(&mut *first, "a", &json!({ "type": "UAV-CALIB", "ids": ["glider-1"], "component": "compass" }));
    let receipt = &body["receipt"]["glider-1"];
    let suspended = until(&mut *first, |message| message["body"]["suspended"] == json!(true));
    assert_eq!(suspended["body"]["id"], *receipt);
    let resume = json!({ "type": "ASYNC-RESUME", "ids": [receipt] });
    let foreign = ask(&mut *second, "b", &resume);
    assert_eq!(
        (&foreign["success"], foreign["error"].as_object().map(serde_json::Map::len)),
        (&json!([]), Some(1))
    );
    assert_eq!(ask(&mut *first, "c", &resume)["success"], json!([receipt]));
    let end = until(&mut *first, |message| message["body"]["type"] == "ASYNC-RESP");
    assert_eq!((&end["body"]["id"], &end["body"]["result"]), (receipt, &json!(true)));
    assert_eq!(second.receive(Instant::now() + SILENCE).expect("the connection holds"), Received::Silence);
}

#[test]
fn a_one_shot_waits_for_what_takes_longer() {
    let server = serve(Options { speed: 20.0, ..Options::default() });
    let mut client = client(&server, WAYS[2]);
    let body = ask(
        &mut *client,
        "a",
        &json!({ "type": "UAV-TEST", "ids": ["glider-1", "glider-9"], "component": "led" }),
    );
    let expected = json!({
        "type": "UAV-TEST", "result": { "glider-1": true }, "error": { "glider-9": "there is no such UAV" },
    });
    assert_eq!(body, expected);
    let body = ask(&mut *client, "b", &json!({ "type": "LOG-DATA", "uavId": "glider-1", "logId": "1" }));
    assert_eq!((&body["result"]["id"], body.get("receipt")), (&json!("1"), None));
    client.send(br#"{"type":"SYS-PING"}"#).expect("it is sent");
    assert_eq!(
        receive(&mut *client),
        json!({ "type": "ACK-ACK" }),
        "without an envelope the answer has none"
    );
}

#[test]
fn a_flight_is_seen_by_others() {
    let server = serve(Options { speed: 20.0, rate: 20.0, ..Options::default() });
    let (mut pilot, mut watcher) = (client(&server, WAYS[0]), client(&server, WAYS[6]));
    let result = ask(&mut *pilot, "a", &json!({ "type": "UAV-TAKEOFF", "ids": ["glider-2"] }));
    assert_eq!(result["result"], json!({ "glider-2": true }));
    let state = |message: &Value| message["body"]["status"]["glider-2"].clone();
    let hovering = until(&mut *watcher, |message| state(message)["mode"] == "loiter");
    assert_eq!((&state(&hovering)["errors"], &state(&hovering)["position"][3]), (&json!([]), &json!(10_000)));
    ask(
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
fn a_client_may_move_from_polling_to_a_web_socket() {
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
            ureq::post(format!("{url}&sid={sid}")).send(&text).expect("it is taken");
        };
        if revision == 4 {
            post("40");
        }
        let (mut socket, _) =
            tungstenite::connect(format!("ws://{base}&transport=websocket&sid={sid}")).expect("a WebSocket");
        socket.send("2probe".into()).expect("it is sent");
        assert_eq!(socket.read().expect("an answer").to_text().expect("text"), "3probe");
        socket.send("5".into()).expect("it is sent");
        let text = request("a", &json!({ "type": "SYS-PING" }));
        socket.send(format!("42[\"fw\",{text}]").into()).expect("it is sent");
        let end = Instant::now() + PATIENCE;
        loop {
            assert!(Instant::now() < end);
            let packet = socket.read().expect("a packet");
            let packet = packet.to_text().expect("text").to_owned();
            if let Some(event) = packet.strip_prefix("42").filter(|event| event.contains("\"refs\"")) {
                let event: Value = serde_json::from_str(event).expect("JSON");
                assert_eq!((&event[0], &event[1]["body"]["type"]), (&json!("fw"), &json!("ACK-ACK")));
                break;
            }
        }
        let status = ureq::get(format!("{url}&sid={sid}")).call().expect_err("it has moved").to_string();
        assert!(status.contains("400"), "{status}");
    }
}

#[test]
fn what_is_no_socket_io_is_refused() {
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
    socket.send("40/wind,".into()).expect("it is sent");
    let output = socket.read().expect("an answer");
    assert_eq!(output.to_text().expect("text"), "44/wind,{\"message\":\"Invalid namespace\"}");
}

#[test]
fn garbage_ends_no_service() {
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
            let mut stream = TcpStream::connect(location).expect("it is there");
            // The server may close before it has read all.
            let _ = stream.write_all(&text).and_then(|()| stream.write_all(b"\n"));
        }
        let socket = UdpSocket::bind("127.0.0.1:0").expect("a port");
        socket.send_to(&text, udp).expect("it is sent");
        Ok(())
    });
    outcome.expect("it can be sent");
    for way in WAYS {
        ask(&mut *client(&server, way), "after", &json!({ "type": "SYS-PING" }));
    }
}

#[test]
fn nobody_is_served_without_the_login() {
    let server =
        serve(Options { login: Some(("pilot".to_owned(), "soar".to_owned())), ..Options::default() });
    let mut client = client(&server, WAYS[3]);
    let list = json!({ "type": "UAV-LIST" });
    assert_eq!(ask(&mut *client, "a", &list)["type"], "ACK-NAK");
    let login = json!({ "type": "AUTH-REQ", "method": "basic", "data": "cGlsb3Q6c29hcg==" });
    assert_eq!(
        ask(&mut *client, "b", &login),
        json!({ "type": "AUTH-RESP", "result": true, "user": "pilot" })
    );
    assert_eq!(ask(&mut *client, "c", &list)["type"], "UAV-LIST");

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
    assert_eq!(post(Some("Basic cGlsb3Q6c29hcg==")).expect("it is served"), 200);
}

#[test]
fn bugs_of_tcp_show() {
    let ping = |id: &str| request(id, &json!({ "type": "SYS-PING" }));
    let is_json = |received: &Received| matches!(received, Received::Message(text) if serde_json::from_slice::<Value>(text).is_ok());

    let server = broken("FW-TCP-01");
    let mut spread = client(&server, WAYS[0]);
    let lines: Vec<Received> =
        (0..20).map(|_| spread.receive(Instant::now() + PATIENCE).expect("a line")).collect();
    assert!(!lines.iter().all(is_json), "a message takes several lines");

    let server = broken("FW-TCP-02");
    let mut merged = client(&server, WAYS[0]);
    merged.send(ping("a").as_bytes()).expect("it is sent");
    answer(&mut *merged, "a");
    // That both lines come in one segment is likely, but not certain.
    let is_seen = (0..20).any(|_| {
        merged.send_raw(format!("{}\n{}\n", ping("b"), ping("c")).as_bytes()).expect("it is sent");
        answer(&mut *merged, "b");
        !is_answered(&mut *merged, SILENCE)
    });
    assert!(is_seen);

    let server = broken("FW-TCP-03");
    let mut strict = client(&server, WAYS[0]);
    strict.send(b"glider").expect("it is sent");
    let end = Instant::now() + PATIENCE;
    while strict.receive(end).expect("it ends in order") != Received::End {
        assert!(Instant::now() < end);
    }

    let server = broken("FW-TCP-04");
    let mut forgetful = client(&server, WAYS[0]);
    let text = ping("a") + "\n";
    forgetful.send_raw(&text.as_bytes()[..20]).expect("it is sent");
    thread::sleep(SILENCE);
    forgetful.send_raw(&text.as_bytes()[20..]).expect("it is sent");
    assert!(!is_answered(&mut *forgetful, SILENCE));
}

#[test]
fn bugs_of_udp_show() {
    let ping = request("a", &json!({ "type": "SYS-PING" }));
    let server = broken("FW-UDP-01");
    let mut doubled = client(&server, WAYS[1]);
    doubled.send(ping.as_bytes()).expect("it is sent");
    let end = Instant::now() + PATIENCE;
    loop {
        let Received::Message(text) = doubled.receive(end).expect("a datagram") else {
            panic!("nothing came")
        };
        if serde_json::from_slice::<Value>(&text).is_err() {
            break;
        }
    }
    for (rule, first) in [("FW-UDP-02", "{}"), ("FW-UDP-03", "glider")] {
        let server = broken(rule);
        let mut client = client(&server, WAYS[1]);
        client.send(first.as_bytes()).expect("it is sent");
        thread::sleep(SILENCE);
        // Where nobody listens any more, this may fail.
        let _ = client.send(ping.as_bytes());
        assert!(!is_answered(&mut *client, SILENCE), "{rule}");
    }
}

#[test]
fn bugs_of_socket_io_show() {
    let server = broken("FW-SIO-01");
    for way in &WAYS[3..] {
        let mut client = client(&server, *way);
        client.send(request("a", &json!({ "type": "SYS-PING" })).as_bytes()).expect("it is sent");
        assert!(!is_answered(&mut *client, SILENCE), "{way:?}");
    }
    let server = broken("FW-SIO-02");
    let url = format!("socketio://{}?transport=polling", address(&server, Transport::SocketIo));
    let refused =
        connect(&url.parse().expect("an endpoint"), Instant::now() + PATIENCE).err().expect("no polling");
    assert!(refused.to_string().contains("400"), "{refused}");
    ask(&mut *client(&server, WAYS[5]), "a", &json!({ "type": "SYS-PING" }));
}

#[test]
fn notifies_all_clients_of_the_shutdown() {
    let server = serve(Options::default());
    let ways: Vec<_> = WAYS.into_iter().filter(|(transport, _)| *transport != Transport::Http).collect();
    let mut clients: Vec<_> = ways.iter().map(|way| client(&server, *way)).collect();
    for client in &mut clients {
        ask(&mut **client, "a", &json!({ "type": "SYS-PING" }));
    }
    let ending = thread::spawn(move || server.end());
    for (client, way) in clients.iter_mut().zip(&ways) {
        until(&mut **client, |message| message["body"]["type"] == "SYS-CLOSE");
        if way.0 != Transport::Udp {
            assert_eq!(
                client.receive(Instant::now() + PATIENCE).expect("it ends in order"),
                Received::End,
                "{way:?}"
            );
        }
    }
    ending.join().expect("it ends");
}

/// The program, and the first line that it prints.
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
    let mut client =
        connect(&line.trim().parse().expect("an endpoint"), Instant::now() + PATIENCE).expect("a connection");
    ask(&mut *client, "a", &json!({ "type": "SYS-PING" }));
    drop(child.stdin.take());
    assert_eq!(child.wait().expect("it ends").code(), Some(0));

    let (mut child, line) = program(&["--udp", "127.0.0.1:0", "--for", "0.2", "--format", "json"]);
    let location: Value = serde_json::from_str(&line).expect("JSON");
    assert_eq!(
        (&location["transport"], location["port"].as_u64().is_some_and(|port| port > 0)),
        (&json!("udp"), true)
    );
    assert_eq!(child.wait().expect("it ends").code(), Some(0));
}

#[test]
fn reports_wrong_usage() {
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_uavspec"))
            .arg("serve")
            .args(arguments)
            .output()
            .expect("it runs");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    for (arguments, wrong) in [
        (&["--bug", "FW-NONE-01"][..], "--list-bugs"),
        (&["--error", "glider-9=66"], "glider-1 to glider-5"),
        (&["--error", "glider-1=50"], "no error code 50"),
        (&["--login", "pilot"], "NAME:PASSWORD"),
        (&["--speed", "0"], "0.01"),
    ] {
        let (status, _, output) = run(arguments);
        assert_eq!(status, Some(2), "{output}");
        assert!(output.contains(wrong), "{output}");
    }
    let server = serve(Options::default());
    let (status, _, output) = run(&["--tcp", &address(&server, Transport::Tcp).to_string()]);
    assert_eq!(status, Some(3));
    assert!(output.contains("can't be listened at"), "{output}");
    let (status, printed, _) = run(&["--list-bugs"]);
    assert_eq!(status, Some(0));
    assert!(
        printed.lines().count() > 100 && printed.contains("FW-UST-HEADING     The heading of a UAV is 3600."),
        "{printed}"
    );
}

#[test]
fn a_client_that_reads_nothing_holds_up_nobody() {
    let server = serve(Options { uavs: 200, rate: 0.0, ..Options::default() });
    let mut idle = TcpStream::connect(address(&server, Transport::Tcp)).expect("a connection");
    let ids: Vec<String> = (1..=200).map(|number| format!("glider-{number}")).collect();
    let text = request("a", &json!({ "type": "UAV-INF", "ids": ids })) + "\n";
    idle.set_write_timeout(Some(SILENCE)).expect("a limit");
    for _ in 0..100 {
        if idle.write_all(text.as_bytes()).is_err() {
            break;
        }
    }
    ask(&mut *client(&server, WAYS[0]), "a", &json!({ "type": "SYS-PING" }));
    // What it was sent is there nevertheless.
    let mut first = [0; 20];
    idle.read_exact(&mut first).expect("it was answered");
    assert!(first.starts_with(b"{\"$fw.version\""));
}
