//! A siege: on all transports, bad clients take all seats of the server, while good clients send requests.

mod bad;

use std::io::{BufRead as _, BufReader, Read as _};
use std::net::SocketAddr;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use uavspec_flockwave::transport::{Client, Received, connect};

use super::request;

/// The time limit for an answer, which detects a server that hangs. The measured delay is only printed.
const HANG: Duration = Duration::from_secs(30);

/// The interval between requests of a good client.
const PAUSE: Duration = Duration::from_millis(50);

/// The time after which a good client over UDP repeats its request.
const REPEAT: Duration = Duration::from_millis(100);

/// The maximum amount of memory that the server may use, in bytes.
const MEMORY_LIMIT: u64 = 100 << 20;

/// The number of bad connections. It exceeds the number of seats.
const BAD: usize = 400;

/// The duration of the siege.
const TIME: Duration = Duration::from_secs(5);

/// A running server.
struct Target {
    child: Child,
    /// The addresses for TCP, UDP, HTTP and Socket.IO.
    addresses: [SocketAddr; 4],
}

impl Target {
    fn start() -> Self {
        let any = "127.0.0.1:0";
        let mut child = Command::new(env!("CARGO_BIN_EXE_uavspec"))
            .args(["serve", "--tcp", any, "--udp", any, "--http", any, "--socketio", any])
            .arg("--until-stdin-closes")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the server starts");
        let mut lines = BufReader::new(child.stdout.take().expect("its output")).lines();
        let addresses = [0; 4].map(|_| {
            let line = lines.next().expect("an address").expect("text");
            line.split("://").nth(1).expect("an address").parse().expect("an address")
        });
        Self { child, addresses }
    }

    /// The memory that the server uses, in bytes.
    fn memory(&self) -> u64 {
        let path = format!("/proc/{}/status", self.child.id());
        let status = std::fs::read_to_string(path).expect("the server runs");
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("its memory");
        let kilobytes: u64 = line.trim().trim_end_matches("kB").trim().parse().expect("a number");
        kilobytes << 10
    }

    /// Ends the server. Returns the messages that it printed.
    fn end(mut self) -> String {
        drop(self.child.stdin.take());
        let mut messages = String::new();
        self.child.stderr.take().expect("its messages").read_to_string(&mut messages).expect("text");
        assert!(self.child.wait().expect("the end").success(), "{messages}");
        messages
    }
}

/// The results of a good client.
#[derive(Clone, Copy, Debug, Default)]
struct Delays {
    answers: u64,
    worst: Duration,
    /// The number of answers that took more than a second.
    late: u64,
    /// The number of lost connections.
    lost: u64,
}

/// A good client.
struct GoodClient {
    url: String,
    /// True if the client opens a new connection for each request.
    is_newcomer: bool,
}

impl GoodClient {
    /// Sends requests until the end of the siege, and measures the delays of the answers.
    fn run(&self, is_over: &AtomicBool) -> Delays {
        let mut delays = Delays::default();
        let mut connection = None;
        while !is_over.load(Ordering::Relaxed) {
            let started = Instant::now();
            while !self.ping(&mut connection, started + HANG) {
                delays.lost += 1;
                assert!(started.elapsed() < HANG, "{}: no answer", self.url);
            }
            let delay = started.elapsed();
            delays.answers += 1;
            delays.worst = delays.worst.max(delay);
            delays.late += u64::from(delay > Duration::from_secs(1));
            if self.is_newcomer {
                connection = None;
            }
            thread::sleep(PAUSE);
        }
        delays
    }

    /// Sends a request and waits for the answer. Returns false if the connection fails.
    fn ping(&self, connection: &mut Option<Box<dyn Client + Send>>, end: Instant) -> bool {
        let is_udp = self.url.starts_with("udp");
        if connection.is_none() {
            *connection = connect(&self.url.parse().expect("an endpoint"), end).ok();
        }
        let Some(client) = connection else { return false };
        let text = request("ping", &json!({ "type": "SYS-PING" }));
        while Instant::now() < end {
            let until = if is_udp { Instant::now() + REPEAT } else { end };
            if client.send(text.as_bytes()).is_err() {
                break;
            }
            match await_answer(&mut **client, until) {
                Some(true) => return true,
                Some(false) => {}
                None => break,
            }
        }
        *connection = None;
        false
    }
}

/// Waits for an answer. Returns true if it arrives in time, and `None` if the connection ends.
fn await_answer(client: &mut dyn Client, until: Instant) -> Option<bool> {
    loop {
        match client.receive(until).ok()? {
            Received::Message(text) => {
                let message: Value = serde_json::from_slice(&text).expect("JSON");
                if message["refs"] == "ping" {
                    return Some(true);
                }
                if message["body"]["type"] == "SYS-CLOSE" {
                    return None;
                }
            }
            Received::Silence => return Some(false),
            Received::End => return None,
            Received::TooLong | Received::OtherEvent(_) => {}
        }
    }
}

/// Ends all clients.
struct EndOnDrop<'a>(&'a AtomicBool);

impl Drop for EndOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[test]
#[ignore = "takes some seconds of all processors; tests of `serve::listen::seats` cover the logic"]
fn answers_good_clients_during_a_siege() {
    let target = Target::start();
    let [tcp, udp, http, socketio] = target.addresses;
    let good = [
        (format!("tcp://{tcp}"), false),
        (format!("tcp://{tcp}"), true),
        (format!("udp://{udp}"), false),
        (format!("http://{http}"), false),
        (format!("http://{http}"), true),
        (format!("socketio://{socketio}?protocol=5&transport=websocket"), false),
        (format!("socketio://{socketio}?protocol=5&transport=websocket"), true),
        (format!("socketio://{socketio}?protocol=4&transport=polling"), false),
    ];
    let good = good.map(|(url, is_newcomer)| GoodClient { url, is_newcomer });
    let is_over = AtomicBool::new(false);
    let mut max = 0;
    thread::scope(|scope| {
        let is_over = &is_over;
        // The clients end even if an assertion fails.
        let _end = EndOnDrop(is_over);
        bad::start(scope, target.addresses, BAD, is_over);
        let running: Vec<_> = good.iter().map(|client| scope.spawn(|| client.run(is_over))).collect();
        let started = Instant::now();
        while started.elapsed() < TIME && !running.iter().any(thread::ScopedJoinHandle::is_finished) {
            thread::sleep(Duration::from_millis(100));
            max = max.max(target.memory());
        }
        is_over.store(true, Ordering::Relaxed);
        for (client, delays) in good.iter().zip(running) {
            let delays = delays.join().expect("a good client gets its answers");
            let kind = if client.is_newcomer { ", a connection per request" } else { "" };
            println!(
                "{}{kind}: {} answers, worst delay {:?}, {} later than 1 s, {} connections lost",
                client.url, delays.answers, delays.worst, delays.late, delays.lost
            );
            assert!(delays.answers > 0);
        }
    });
    println!("most memory: {} MB", max >> 20);
    assert!(max < MEMORY_LIMIT, "the server used {max} bytes");
    println!("{}", target.end());
}
