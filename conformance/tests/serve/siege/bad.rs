//! Bad clients.

use std::io::{ErrorKind, Read as _, Write as _};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, Scope};
use std::time::Duration;

use serde_json::json;
use uavspec_test_support::Random;

use super::request;

/// The number of threads that run the bad clients.
const THREADS: usize = 8;

/// The time between two actions of the bad clients of a thread.
const PAUSE: Duration = Duration::from_millis(10);

/// Starts bad clients with this many connections, and floods of datagrams.
pub(super) fn start<'s>(
    scope: &'s Scope<'s, '_>,
    addresses: [SocketAddr; 4],
    connections: usize,
    is_over: &'s AtomicBool,
) {
    for thread in 0..THREADS {
        scope.spawn(move || {
            let numbers = (0..connections).filter(|number| number % THREADS == thread);
            let mut clients: Vec<BadClient> =
                numbers.map(|number| BadClient::new(number, addresses)).collect();
            let mut random = Random(thread as u64);
            while !is_over.load(Ordering::Relaxed) {
                for client in &mut clients {
                    client.act(&mut random);
                    if is_over.load(Ordering::Relaxed) {
                        break;
                    }
                }
                thread::sleep(PAUSE);
            }
        });
    }
    scope.spawn(move || flood_with_datagrams(addresses[1], is_over));
}

/// The behaviour of a bad client after it has connected.
#[derive(Clone, Copy, Debug)]
enum Behaviour {
    /// Sends these bytes once.
    Once(fn(&mut Random) -> Vec<u8>),
    /// Sends these bytes repeatedly, and never reads.
    Flood(fn(&mut Random) -> Vec<u8>),
    /// Sends these bytes repeatedly, and reads the answers.
    Exchange(fn(&mut Random) -> Vec<u8>),
    /// Sends these bytes, and then one byte at a time.
    Slowly(fn(&mut Random) -> Vec<u8>),
    /// Sends these bytes, and disconnects without reading.
    Reset(fn(&mut Random) -> Vec<u8>),
}

use Behaviour::{Exchange, Flood, Once, Reset, Slowly};

/// The behaviours. Each has the index of its address: TCP, UDP, HTTP or Socket.IO.
const BEHAVIOURS: [(usize, Behaviour); 26] = [
    (0, Once(|_| Vec::new())),
    (0, Flood(|_| requests(20, &json!({ "type": "UAV-INF", "ids": fleet() })))),
    (0, Once(|_| b"{\"$fw.version\":\"1.0\",\"id\":\"half".repeat(200))),
    (0, Exchange(|_| requests(50, &json!({ "type": "SYS-PING" })))),
    (0, Exchange(|_| presets(5))),
    (0, Exchange(|_| requests(5, &json!({ "type": "UAV-TEST", "ids": fleet() })))),
    (
        0,
        Exchange(|_| {
            requests(5, &json!({ "type": "DEV-SUB", "paths": ["/", "/glider-1", "/glider-1/gps"] }))
        }),
    ),
    (0, Flood(|random| random.bytes(4000))),
    (0, Flood(|_| vec![b'x'; 16 << 10])),
    (0, Flood(|_| b"\n".repeat(4000))),
    (0, Flood(|_| b"[[],[],".repeat(4000))),
    (0, Slowly(|_| b"{\"$fw.version\":\"1.0\"".to_vec())),
    (0, Reset(|_| requests(3, &json!({ "type": "SYS-PING" })))),
    (0, Once(|_| b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03".repeat(20))),
    (
        0,
        Flood(|_| {
            requests(
                1,
                &json!({ "type": "UAV-INF", "ids": (0..5000).map(|n| n.to_string()).collect::<Vec<_>>() }),
            )
        }),
    ),
    (2, Slowly(|_| b"GET / HTTP/1.1\r\nHost: glider\r\nX-Slow: ".to_vec())),
    (
        2,
        Once(|_| {
            b"POST /api/v1 HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: 1000000\r\n\r\n["
                .to_vec()
        }),
    ),
    (2, Flood(|_| posts(20, &json!({ "type": "UAV-INF", "ids": fleet() })))),
    (2, Flood(|_| posts(1, &json!({ "type": "UAV-TEST", "ids": fleet() })))),
    (
        2,
        Exchange(|random| {
            [b"GET /socket.io/?EIO=4&transport=polling HTTP/1.1\r\n\r\n".to_vec(), random.bytes(9)].concat()
        }),
    ),
    (3, Exchange(|_| b"GET /socket.io/?EIO=4&transport=polling HTTP/1.1\r\n\r\n".to_vec())),
    (3, Once(|_| b"GET /socket.io/?EIO=3&transport=polling HTTP/1.1\r\n\r\n".to_vec())),
    (3, Once(|_| [WEB_SOCKET, &frame(0x81, b"40")].concat())),
    (
        3,
        Flood(|_| {
            [&WEB_SOCKET[..WEB_SOCKET.len()], &frame(0x81, b"40"), &frame(0x89, &[b'p'; 100]).repeat(20)]
                .concat()
        }),
    ),
    (
        3,
        Once(|_| {
            [WEB_SOCKET, &frame(0x01, b"4"), &frame(0x00, b"").repeat(500), &frame(0x00, &[b'x'; 8000])]
                .concat()
        }),
    ),
    (3, Once(|_| [WEB_SOCKET, &[0x81, 0xff, 0, 0, 0, 0, 0, 0x0f, 0, 0, 1, 2, 3, 4, b'4']].concat())),
];

const WEB_SOCKET: &[u8] = b"GET /socket.io/?EIO=4&transport=websocket HTTP/1.1\r\nUpgrade: websocket\r\n\
    Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";

fn fleet() -> Vec<String> {
    (1..=5).map(|number| format!("glider-{number}")).collect()
}

/// Requests in lines.
fn requests(count: usize, body: &serde_json::Value) -> Vec<u8> {
    (request("a", body) + "\n").repeat(count).into_bytes()
}

/// Requests, each of which causes a notification to all clients.
fn presets(count: usize) -> Vec<u8> {
    let [select, deselect] = [json!("base"), json!(null)].map(|id| json!({ "type": "RTK-SOURCE", "id": id }));
    [requests(1, &select), requests(1, &deselect)].concat().repeat(count)
}

/// Requests over HTTP.
fn posts(count: usize, body: &serde_json::Value) -> Vec<u8> {
    let text = request("a", body);
    let length = text.len();
    format!(
        "POST /api/v1 HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: {length}\r\n\r\n{text}"
    )
    .repeat(count)
    .into_bytes()
}

/// A WebSocket frame whose mask is zero.
fn frame(kind: u8, payload: &[u8]) -> Vec<u8> {
    let length = payload.len();
    let head = match u8::try_from(length) {
        Ok(length) if length < 126 => vec![kind, 0x80 | length],
        _ => vec![kind, 0xfe, (length >> 8).to_be_bytes()[7], length.to_be_bytes()[7]],
    };
    [&head[..], &[0; 4], payload].concat()
}

/// A bad client.
struct BadClient {
    address: SocketAddr,
    behaviour: Behaviour,
    stream: Option<TcpStream>,
}

impl BadClient {
    fn new(number: usize, addresses: [SocketAddr; 4]) -> Self {
        let (transport, behaviour) = BEHAVIOURS[number % BEHAVIOURS.len()];
        Self { address: addresses[transport], behaviour, stream: None }
    }

    /// Connects if necessary. Then performs the next action.
    fn act(&mut self, random: &mut Random) {
        let is_new = self.stream.is_none();
        if is_new {
            self.stream = connect(self.address);
        }
        let Some(stream) = &self.stream else { return };
        let is_open = match self.behaviour {
            Once(text) if is_new => send(stream, &text(random)),
            Once(_) => is_connected(stream),
            Slowly(text) if is_new => send(stream, &text(random)),
            // A byte now and then.
            Slowly(_) => random.below(50) > 0 && is_connected(stream) || send(stream, b"x"),
            Flood(text) => send(stream, &text(random)),
            Exchange(text) => send(stream, &text(random)) && is_connected(stream),
            Reset(text) => {
                send(stream, &text(random));
                random.below(20) > 0
            }
        };
        if !is_open {
            self.stream = None;
        }
    }
}

fn connect(address: SocketAddr) -> Option<TcpStream> {
    let stream = TcpStream::connect_timeout(&address, Duration::from_millis(500)).ok()?;
    stream.set_nonblocking(true).ok()?;
    Some(stream)
}

/// Sends as many bytes as possible. Returns false if the connection has ended.
fn send(mut stream: &TcpStream, bytes: &[u8]) -> bool {
    match stream.write(bytes) {
        Ok(sent) => sent > 0 || bytes.is_empty(),
        Err(error) => error.kind() == ErrorKind::WouldBlock,
    }
}

/// Reads the data that has arrived. Returns false if the connection has ended.
fn is_connected(mut stream: &TcpStream) -> bool {
    let mut buffer = [0; 16 << 10];
    match stream.read(&mut buffer) {
        Ok(length) => length > 0,
        Err(error) => error.kind() == ErrorKind::WouldBlock,
    }
}

/// Sends datagrams from many ports.
fn flood_with_datagrams(address: SocketAddr, is_over: &AtomicBool) {
    let mut random = Random(7);
    let ping = request("a", &json!({ "type": "UAV-INF", "ids": fleet() }));
    while !is_over.load(Ordering::Relaxed) {
        for number in 0..100 {
            let Ok(socket) = UdpSocket::bind("127.0.0.1:0") else { continue };
            let garbage = random.bytes(1000);
            let datagram = if number % 4 == 0 { &garbage } else { ping.as_bytes() };
            // The server's queue may be full.
            let _ = socket.send_to(datagram, address);
        }
        thread::sleep(PAUSE);
    }
}
