//! Tests of the server's limits. One or a few bad clients can reach each limit.

use std::collections::BTreeSet;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpStream, UdpSocket};
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::json;
use uavspec_flockwave::transport::{Received, connect};
use uavspec_model::clock::Clock;
use uavspec_serve::{Options, Server, Transport};
use uavspec_test_support::{LIMIT, deadline, wait_for};

use super::{ENDPOINTS, READING_TIME, address, client, request, request_body, serve, settle, until};

/// The reason that the server states when it disconnects idle clients.
const REPLACED: &str = "the server is full, and this client was idle";

/// Starts a server whose time stands still, so that no time limit depends on the speed of the computer.
fn frozen(options: Options) -> Server {
    serve(Options { rate: 0.0, clock: Clock::simulated(), ..options })
}

#[test]
fn disconnects_clients_that_never_read() {
    // Each notification is about half a megabyte.
    let server = serve(Options { uavs: 1000, rate: 50.0, ..Options::default() });
    let mut idle = TcpStream::connect(address(&server, Transport::Tcp)).expect("a connection");
    wait_for("the client is disconnected", || idle.write(b"\n").err());
    request_body(&mut *client(&server, ENDPOINTS[0]), "a", &json!({ "type": "SYS-PING" }));
}

#[test]
fn stops_reading_requests_of_clients_that_read_no_answers() {
    let server = frozen(Options { uavs: 100, ..Options::default() });
    let mut idle = TcpStream::connect(address(&server, Transport::Tcp)).expect("a connection");
    idle.set_nonblocking(true).expect("a socket");
    let ids: Vec<String> = (1..=100).map(|number| format!("glider-{number}")).collect();
    let text = (request("a", &json!({ "type": "UAV-INF", "ids": ids })) + "\n").repeat(100);
    // Before there were limits, the server accepted this much data, and stored 64 MB of answers.
    let mut accepted = 0;
    while let Ok(count) = idle.write(&text.as_bytes()[accepted % text.len()..]) {
        accepted += count;
        settle(&server);
    }
    assert!(accepted < 200 * text.len(), "{accepted}");
    assert!(server.end().is_empty(), "the client may still read");
}

#[test]
fn serves_newcomers_over_udp_after_datagrams_from_many_ports() {
    let server = frozen(Options::default());
    let text = request("a", &json!({ "type": "SYS-PING" }));
    // The operating system may assign the same port again.
    let mut ports = BTreeSet::new();
    while ports.len() < 260 {
        let socket = UdpSocket::bind("127.0.0.1:0").expect("a port");
        ports.insert(socket.local_addr().expect("an address").port());
        socket.set_read_timeout(Some(LIMIT)).expect("a limit");
        socket.send_to(text.as_bytes(), address(&server, Transport::Udp)).expect("sent");
        socket.recv(&mut [0; 1000]).expect("an answer");
    }
    settle(&server);
    assert_eq!(server.end().into_keys().collect::<Vec<_>>(), [REPLACED]);
}

#[test]
fn datagrams_that_are_no_requests_register_no_client() {
    let server = serve(Options { rate: 20.0, ..Options::default() });
    let mut client = client(&server, ENDPOINTS[1]);
    client.send(b"{}").expect("sent");
    let mut registered = self::client(&server, ENDPOINTS[0]);
    for _ in 0..2 {
        until(&mut *registered, |message| message["body"]["type"] == "UAV-INF");
    }
    let received = client.receive(Clock::real().now() + READING_TIME).expect("an open socket");
    assert_eq!(received, Received::Silence);
}

#[test]
fn idle_connections_lock_nobody_out() {
    let server = frozen(Options::default());
    for transport in [Transport::Tcp, Transport::Http, Transport::SocketIo] {
        let location = address(&server, transport);
        let mut active = client(&server, ENDPOINTS[0]);
        request_body(&mut *active, "a", &json!({ "type": "SYS-PING" }));
        let _idle: Vec<TcpStream> =
            (0..300).map(|_| TcpStream::connect(location).expect("a connection")).collect();
        for endpoint in ENDPOINTS {
            request_body(&mut *client(&server, endpoint), "a", &json!({ "type": "SYS-PING" }));
        }
        request_body(&mut *active, "b", &json!({ "type": "SYS-PING" }));
    }
}

/// An HTTP connection for sessions that use polling.
struct HttpConnection {
    stream: TcpStream,
    reader: BufReader<TcpStream>,
}

impl HttpConnection {
    fn new(server: &Server) -> Self {
        let stream = TcpStream::connect(address(server, Transport::SocketIo)).expect("a connection");
        stream.set_read_timeout(Some(LIMIT)).expect("a limit");
        let reader = BufReader::new(stream.try_clone().expect("a second handle"));
        Self { stream, reader }
    }

    /// Opens a session. Returns its id.
    fn open_session(&mut self) -> String {
        self.stream.write_all(b"GET /socket.io/?EIO=4&transport=polling HTTP/1.1\r\n\r\n").expect("sent");
        let mut response = Vec::new();
        // The object that describes the session is at the end of the response.
        self.reader.read_until(b'}', &mut response).expect("a response");
        let response = String::from_utf8_lossy(&response);
        response.split("\"sid\":\"").nth(1).and_then(|rest| rest.split('"').next()).expect("an id").to_owned()
    }

    /// Sends a packet. Returns the status of the response.
    fn send(&mut self, sid: &str, packet: &str) -> String {
        let request = format!(
            "POST /socket.io/?EIO=4&transport=polling&sid={sid} HTTP/1.1\r\nContent-Length: {}\r\n\r\n{packet}",
            packet.len()
        );
        self.stream.write_all(request.as_bytes()).expect("sent");
        let mut status = String::new();
        self.reader.read_line(&mut status).expect("a response");
        let mut length = 0;
        loop {
            let mut line = String::new();
            self.reader.read_line(&mut line).expect("a header");
            match line.trim_end().split_once(": ") {
                Some((name, value)) if name.eq_ignore_ascii_case("content-length") => {
                    length = value.parse().expect("a length");
                }
                Some(_) => {}
                None => break,
            }
        }
        self.reader.read_exact(&mut vec![0; length]).expect("a body");
        status.split(' ').nth(1).expect("a status").to_owned()
    }
}

#[test]
fn abandoned_polling_sessions_give_way_to_newcomers() {
    let server = frozen(Options::default());
    for _ in 0..300 {
        HttpConnection::new(&server).open_session();
    }
    for endpoint in &ENDPOINTS[3..] {
        request_body(&mut *client(&server, *endpoint), "a", &json!({ "type": "SYS-PING" }));
    }
    assert_eq!(server.end().into_keys().collect::<Vec<_>>(), [REPLACED]);
}

#[test]
fn a_session_that_is_not_used_ends_soon() {
    let clock = Clock::simulated();
    let server = serve(Options { rate: 0.0, clock: clock.clone(), ..Options::default() });
    let mut connection = HttpConnection::new(&server);
    let (used, unused) = (connection.open_session(), connection.open_session());
    assert_eq!(connection.send(&used, "40"), "200");
    clock.sleep(Duration::from_secs(4));
    settle(&server);
    let another = connection.open_session();
    clock.sleep(Duration::from_millis(1_500));
    // The server checks its limits between requests.
    settle(&server);
    let [used, unused, another] = [used, unused, another].map(|sid| connection.send(&sid, "40"));
    assert_eq!([&*used, &*unused, &*another], ["200", "400", "200"]);
}

#[test]
fn limits_operations_of_all_clients() {
    let server = frozen(Options { uavs: 1000, ..Options::default() });
    let ids: Vec<String> = (1..=1000).map(|number| format!("glider-{number}")).collect();
    let start = json!({ "type": "UAV-TEST", "ids": ids, "component": "led" });
    let mut clients: Vec<_> = (0..6).map(|_| client(&server, ENDPOINTS[0])).collect();
    let mut started: Vec<usize> = Vec::new();
    for client in &mut clients {
        let body = request_body(&mut **client, "a", &start);
        started.push(body["receipt"].as_object().map_or(0, serde_json::Map::len));
    }
    assert_eq!(started[..5], [1000; 5]);
    assert_eq!(started[5], 4, "each client may start some operations at any time");
}

/// Runs the program with few file descriptors, all of which idle connections use up.
#[cfg(unix)]
#[test]
fn serves_newcomers_with_few_file_descriptors() {
    let script = format!(
        "ulimit -n 64; exec {} serve --tcp 127.0.0.1:0 --until-stdin-closes",
        env!("CARGO_BIN_EXE_uavspec")
    );
    let mut command = Command::new("sh");
    command.args(["-c", &script]).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("a shell");
    let mut line = String::new();
    BufReader::new(child.stdout.as_mut().expect("its output")).read_line(&mut line).expect("a line");
    let location = line.trim().strip_prefix("tcp://").expect("an address");
    let _idle: Vec<TcpStream> =
        (0..200).map(|_| TcpStream::connect(location).expect("a connection")).collect();
    let mut newcomer = connect(&line.trim().parse().expect("an endpoint"), deadline()).expect("a connection");
    request_body(&mut *newcomer, "a", &json!({ "type": "SYS-PING" }));
    drop(child.stdin.take());
    let output = child.wait_with_output().expect("the end");
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(messages.contains(&format!("× {REPLACED}")), "{messages}");
}
