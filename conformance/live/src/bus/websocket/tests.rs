//! A WebSocket server for tests, and tests with servers that violate the WebSocket protocol.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::thread;
use std::time::Duration;

use tungstenite::handshake::server::{Request, Response};
use tungstenite::{Message, WebSocket};
use uavspec_model::clock::Clock;
use uavspec_model::net::Address;
use uavspec_test_support::{deadline, wait_for};

use super::*;
use crate::bus::{Bus, Event, Topic};

/// The server side of a connection.
pub(in crate::bus) type Peer = WebSocket<TcpStream>;

/// Starts a server that runs a function with its first connection.
pub(in crate::bus) fn raw_server(run: impl FnOnce(TcpStream) + Send + 'static) -> Address {
    let listener = TcpListener::bind("127.0.0.1:0").expect("bind");
    let port = listener.local_addr().expect("address").port();
    thread::spawn(move || run(listener.accept().expect("accept").0));
    Address { host: "127.0.0.1".to_owned(), port }
}

/// Starts a server that runs a function with its first WebSocket.
pub(in crate::bus) fn server(run: impl FnOnce(&mut Peer) + Send + 'static) -> Address {
    raw_server(|stream| {
        #[allow(clippy::result_large_err, clippy::unnecessary_wraps, reason = "the library's type")]
        fn accept(
            request: &Request,
            mut response: Response,
        ) -> Result<Response, tungstenite::handshake::server::ErrorResponse> {
            if let Some(names) = request.headers().get("Sec-WebSocket-Protocol") {
                let first = names.to_str().ok().and_then(|names| names.split(',').next()).expect("a name");
                response.headers_mut().insert("Sec-WebSocket-Protocol", first.parse().expect("a value"));
            }
            Ok(response)
        }
        let mut peer = tungstenite::accept_hdr(stream, accept).expect("handshake");
        run(&mut peer);
        let _ = peer.close(None);
        // A reset would discard data that the client hasn't read yet.
        while peer.read().is_ok() {}
    })
}

/// Sends texts.
pub(in crate::bus) fn send(peer: &mut Peer, texts: &[&str]) {
    for text in texts {
        peer.send(Message::text(*text)).expect("send");
    }
}

/// The next text from the client.
pub(in crate::bus) fn text(peer: &mut Peer) -> String {
    match peer.read().expect("read") {
        Message::Text(text) => text.to_string(),
        other => panic!("{other:?}"),
    }
}

/// A topic of any type.
pub(in crate::bus) fn topic(name: &str) -> Topic {
    Topic { name: name.into(), type_name: "a/msg/B".into(), type_hash: None }
}

/// All events until the connection ends.
pub(in crate::bus) fn events(bus: &mut dyn Bus) -> Vec<Event> {
    let until = deadline();
    let events: Vec<Event> = std::iter::from_fn(|| bus.receive(until)).collect();
    assert!(matches!(events.last(), Some(Event::Closed(_))), "{:?}", events.last());
    events
}

/// The reported problems, and the reason for the end of the connection.
pub(in crate::bus) fn problems(events: &[Event]) -> Vec<&str> {
    events
        .iter()
        .filter_map(|event| match event {
            Event::Unreadable(text) | Event::Problem(text) | Event::Closed(text) => Some(text.as_str()),
            _ => None,
        })
        .collect()
}

/// A client that reports each text as unreadable.
struct Echo(Link);

impl Protocol for Echo {
    fn link(&mut self) -> &mut Link {
        &mut self.0
    }

    fn text(&mut self, text: &str) -> Result<(), String> {
        if text.is_empty() { Ok(()) } else { Err(text.to_owned()) }
    }

    fn binary(&mut self, _: &[u8]) -> Result<(), String> {
        Ok(())
    }
}

const SERVICE: Service = Service { example: "echo (port 1)", subprotocols: "" };

fn connect(address: &Address) -> Result<Echo, String> {
    Link::open(&SERVICE, address, deadline()).map(Echo)
}

fn connected(run: impl FnOnce(&mut Peer) + Send + 'static) -> Echo {
    connect(&server(run)).expect("connect")
}

fn texts(client: &mut Echo) -> Vec<String> {
    let until = deadline();
    std::iter::from_fn(|| receive(client, until))
        .map(|event| match event {
            Event::Unreadable(text) | Event::Closed(text) => text,
            other => panic!("{other:?}"),
        })
        .collect()
}

#[test]
fn explains_servers_that_are_not_websockets() {
    for (answer, expected) in [
        ("HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n", "found HTTP status 404"),
        ("SSH-2.0-OpenSSH_9.2\r\n", "expected a WebSocket server such as echo"),
        ("", "expected a WebSocket server such as echo"),
    ] {
        let address = raw_server(move |mut stream| {
            let _ = stream.read(&mut [0; 4096]);
            stream.write_all(answer.as_bytes()).expect("write");
        });
        let error = connect(&address).err().expect(answer);
        assert!(error.contains(expected), "{error}");
    }
    let error = connect(&Address { host: "127.0.0.1".to_owned(), port: 1 });
    assert!(error.err().is_some_and(|error| error.ends_with("Start a server such as echo (port 1)")));
}

#[test]
fn limits_the_time_of_the_handshake() {
    let address = raw_server(|mut stream| {
        // The handshake never ends.
        let _ = stream.write_all(b"HTTP/1.1 101 X\r\nA: b\r\n");
        let _ = stream.read_to_end(&mut Vec::new());
    });
    let until = Clock::real().now() + Duration::from_millis(100);
    Link::open(&SERVICE, &address, until).err().expect("no handshake");
}

#[test]
fn rejects_huge_frames_without_allocating_them() {
    // The header of a frame of 2^62 bytes.
    let header = b"\x82\x7f\x40\0\0\0\0\0\0\0";
    let mut client = connected(|peer| peer.get_mut().write_all(header).expect("write"));
    let expected = "received a message of more than 60 MiB: select other topics with --topics";
    assert_eq!(texts(&mut client), [expected]);
}

#[test]
fn returns_at_the_deadline_during_a_flood() {
    let mut client = connected(|peer| while peer.send(Message::text("")).is_ok() {});
    // Without a deadline, this call would never return.
    assert!(receive(&mut client, Clock::real().now()).is_none());
}

#[test]
fn returns_at_the_deadline_while_single_bytes_arrive() {
    let mut client = connected(|peer| {
        // The header of a frame of 48 MiB, far more than a socket buffers.
        let _ = peer.get_mut().write_all(b"\x81\x7f\0\0\0\0\x03\0\0\0");
        while peer.get_mut().write_all(b" ").is_ok() {}
    });
    // Without a deadline, this call would return only after the whole frame has arrived.
    assert!(receive(&mut client, Clock::real().now()).is_none());
}

#[test]
fn reads_data_that_arrived_before_the_deadline() {
    let mut client = connected(|peer| send(peer, &["first"]));
    let past = Clock::real().now();
    let event = wait_for("the text arrives", || receive(&mut client, past));
    assert!(matches!(event, Event::Unreadable(text) if text == "first"));
}

#[test]
fn limits_the_number_of_problems() {
    let mut client =
        connected(|peer| (0..5_000).for_each(|at| send(peer, &[&format!("garbage {}", at / 2)])));
    let texts = texts(&mut client);
    assert_eq!(texts.iter().filter(|text| **text == "garbage 1").count(), 1);
    assert!(texts.len() < 1_000);
    assert_eq!(texts[texts.len() - 2], "further data is missing or unreadable");
}

#[test]
fn names_the_reason_for_the_end() {
    let mut client = connected(|peer| {
        let reason = "restart".into();
        let code = tungstenite::protocol::frame::coding::CloseCode::Restart;
        let frame = tungstenite::protocol::CloseFrame { code, reason };
        peer.close(Some(frame)).expect("close");
    });
    assert_eq!(texts(&mut client), ["the server closed the connection: code 1012, \"restart\""]);
    assert_eq!(client.0.send(Message::text("x")), Err("the connection is closed".to_owned()));
}

#[test]
fn silent_servers_get_one_ping_and_then_count_as_dead() {
    let start = Clock::simulated().now();
    let mut heartbeat = Heartbeat::new(start);
    assert!(!heartbeat.is_ping_due(start) && !heartbeat.is_dead(start + PONG_LIMIT));
    let pinged = start + PING_INTERVAL;
    assert!(heartbeat.is_ping_due(pinged) && !heartbeat.is_ping_due(pinged) && !heartbeat.is_dead(pinged));
    assert!(heartbeat.is_dead(pinged + PONG_LIMIT));
}
