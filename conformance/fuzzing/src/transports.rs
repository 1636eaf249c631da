//! Targets for the transports of Flockwave.

use std::io::{self, Read, Write};

use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Message, WebSocket};
use uavspec_flockwave::transport::engine::{Kind, Packet, Revision, decode, encode};
use uavspec_flockwave::transport::http::{Incoming, Requests};
use uavspec_flockwave::transport::{Endpoint, MESSAGE_LIMIT, socketio};
use uavspec_model::json::Tree;

use super::Pieces;

/// The maximum length of a body, in bytes.
const MAX_BODY: usize = 1 << 20;

/// Splits a stream into requests, as a whole and in pieces.
pub(super) fn http(data: &[u8]) {
    let whole = requests(&mut &data[..]);
    let body =
        |incoming: &Incoming| if let Incoming::Request(request) = incoming { request.body.len() } else { 0 };
    let length: usize = whole.iter().map(body).sum();
    assert!(length <= data.len(), "{length} bytes from {}", data.len());
    assert_eq!(requests(&mut Pieces::new(data)), whole);
}

/// The requests in a stream, up to the first invalid one.
fn requests(stream: &mut dyn Read) -> Vec<Incoming> {
    let (mut requests, mut all, mut piece) = (Requests::new(MAX_BODY), Vec::new(), vec![0; 32 << 10]);
    while let Ok(length @ 1..) = stream.read(&mut piece) {
        requests.feed(&piece[..length]);
        while let Some(incoming) = requests.take() {
            let is_refused = matches!(incoming, Incoming::Refused(_));
            // A client that waits for a confirmation is noticed only if the body hasn't arrived yet.
            if incoming != Incoming::Expectation {
                all.push(incoming);
            }
            if is_refused {
                return all;
            }
        }
    }
    all
}

/// Reads WebSocket frames, as a whole and in pieces. The first byte selects the role: client or server.
pub(super) fn web_socket(data: &[u8]) {
    let Some((first, data)) = data.split_first() else { return };
    let role = if first % 2 == 0 { Role::Server } else { Role::Client };
    let whole = messages(data, role);
    // The library replaces the reason in an invalid close frame.
    let is_data = |message: &&Message| message.is_text() || message.is_binary();
    let length: usize = whole.iter().filter(is_data).map(Message::len).sum();
    assert!(length <= data.len(), "{length} bytes from {}", data.len());
    assert_eq!(messages(Pieces::new(data), role), whole);
    for text in whole.iter().filter_map(|message| message.to_text().ok()) {
        packet(text);
    }
}

/// Reads WebSocket messages until the first error.
fn messages(input: impl Read, role: Role) -> Vec<Message> {
    let limit = MESSAGE_LIMIT + 1024;
    let config = WebSocketConfig::default().max_message_size(Some(limit)).max_frame_size(Some(limit));
    let mut socket = WebSocket::from_raw_socket(Duplex(input), role, Some(config));
    let mut messages = Vec::new();
    while let Ok(message) = socket.read() {
        messages.push(message);
    }
    messages
}

/// A stream whose output is discarded.
struct Duplex<R>(R);

impl<R: Read> Read for Duplex<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.0.read(out)
    }
}

impl<R> Write for Duplex<R> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Decodes the payload of a poll. Encoding the packets again must not change them. The first byte selects the revision.
pub(super) fn socket_io(data: &[u8]) {
    let Some((first, data)) = data.split_first() else { return };
    let revision = if first % 2 == 0 { Revision::Three } else { Revision::Four };
    let Ok(packets) = decode(revision, data) else { return };
    let length: usize = packets.iter().map(|packet| packet.data.len()).sum();
    assert!(length <= data.len(), "{length} bytes from {}", data.len());
    for packet in &packets {
        self::packet(&packet.to_text());
    }
    // Revision 3 escapes other characters, because clients count them differently.
    if !packets.is_empty() && packets.iter().all(|packet| packet.data.is_ascii()) {
        assert_eq!(decode(revision, encode(revision, &packets).as_bytes()), Ok(packets));
    }
}

/// Parses a packet. A Flockwave message must be JSON, and must be the same after it is written to a new packet.
fn packet(text: &str) {
    let Some(packet) = Packet::parse(text) else { return };
    assert_eq!(packet.to_text(), text);
    if packet.kind != Kind::Message {
        return;
    }
    if let Some(socketio::Packet::Message { text, .. }) = socketio::Packet::parse(&packet.data) {
        let again = socketio::Packet::parse(&socketio::message(&text));
        assert_eq!(again, Some(socketio::Packet::Message { text: text.clone(), receipt: None }));
        // A value that is nested more deeply isn't a message, but is still passed on.
        assert!(Tree::read(&text).is_ok() || text.len() > 100, "{text}");
    }
}

/// Parses a URL. Parsing its printed form must result in the same endpoint, except for the query.
pub(super) fn endpoint(data: &[u8]) {
    let Some(endpoint) = std::str::from_utf8(data).ok().and_then(|text| text.parse::<Endpoint>().ok()) else {
        return;
    };
    let printed = endpoint.to_string();
    assert_eq!(printed.parse::<Endpoint>().map(|again| again.to_string()), Ok(printed));
}

pub(super) fn http_seeds() -> Vec<Vec<u8>> {
    let texts: [&[u8]; 4] = [
        b"GET /socket.io/?EIO=4&transport=polling HTTP/1.1\r\nHost: hill\r\nOrigin: http://hill\r\n\r\n",
        b"POST /api/v1 HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: 2\r\n\r\n{}",
        b"POST /api/v1 HTTP/1.0\r\nTransfer-Encoding: chunked\r\nConnection: keep-alive\r\n\r\n0\r\n\r\n",
        b"GET / HTTP/1.1\r\nConnection: Upgrade, close\r\nExpect: 100-continue\r\n\r\n",
    ];
    texts.map(<[u8]>::to_vec).to_vec()
}

pub(super) fn web_socket_seeds() -> Vec<Vec<u8>> {
    let message = b"42[\"fw\",{}]";
    // A client masks its frames. The mask is zero here.
    let mut masked = vec![0, 0x81, 0x80 | 0xb, 0, 0, 0, 0];
    masked.extend(message);
    let mut plain = vec![1, 0x81, 11];
    plain.extend(message);
    let mut split = vec![1, 0x01, 2, b'4', b'2', 0x80, 9];
    split.extend(&message[2..]);
    let closed = vec![1, 0x89, 0, 0x88, 2, 0x03, 0xe8];
    vec![masked, plain, split, closed]
}

pub(super) fn socket_io_seeds() -> Vec<Vec<u8>> {
    let packets = [
        Packet::new(Kind::Open, "{\"sid\":\"hill\"}"),
        Packet::new(Kind::Message, socketio::message("{\"id\":\"1\"}")),
        Packet::new(Kind::Message, "0/fw,"),
        Packet::new(Kind::Ping, ""),
    ];
    let mut seeds = Vec::new();
    for (first, revision) in [(0, Revision::Three), (1, Revision::Four)] {
        seeds.push([&[first], encode(revision, &packets).as_bytes()].concat());
        seeds.push([&[first], encode(revision, &packets[..1]).as_bytes()].concat());
    }
    seeds.push(b"\x00\x00\x03\xff42x".to_vec());
    seeds
}

pub(super) fn endpoint_seeds() -> Vec<Vec<u8>> {
    let texts = [
        "tcp://localhost:5001",
        "udp://[::1]:5001/",
        "https://hill/fleet",
        "ws://hill/socket.io/?EIO=3&transport=websocket",
        "socketios://hill:5000?protocol=4&transport=polling",
    ];
    texts.map(|text| text.as_bytes().to_vec()).to_vec()
}
