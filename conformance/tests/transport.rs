//! Tests of the clients with servers that require a login or TLS, or that redirect, refuse, delay or lose messages.
//!
//! No test depends on speed: expected events have long time limits.

mod http;
#[cfg(feature = "tls")]
mod tls;

use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, UdpSocket};
use std::time::Duration;

use serde_json::{Value, json};
use uavspec_flockwave::transport::{
    Access, Client, Endpoint, Received, Trust, connect, connect_with, http_status, is_temporary,
};
use uavspec_model::clock::Clock;
use uavspec_serve::{Options, Server, Transport};
use uavspec_test_server::proxy::Proxy;
use uavspec_test_server::server::{custom_server, location, serve};
use uavspec_test_support::{deadline, free_address, wait_for};

/// The time for reading messages that have already arrived.
const SHORT_TIME: Duration = Duration::from_millis(20);

/// The URLs of all clients: the scheme, and the part after the host and the port.
const URLS: [(&str, &str); 6] = [
    ("tcp", ""),
    ("udp", ""),
    ("http", "/api/v1"),
    ("socketio", "?protocol=5&transport=websocket"),
    ("socketio", "?protocol=5&transport=polling"),
    ("socketio", "?protocol=4&transport=polling"),
];

/// The URLs of the clients that use HTTP.
fn http_urls() -> impl Iterator<Item = (&'static str, &'static str)> {
    URLS.into_iter().filter(|(scheme, _)| *scheme == "http" || *scheme == "socketio")
}

fn url((scheme, rest): (&str, &str), address: impl std::fmt::Display) -> Endpoint {
    format!("{scheme}://{address}{rest}").parse().expect("a URL")
}

fn start(scheme: &str) -> (Server, SocketAddr) {
    let transport = match scheme.trim_end_matches('s') {
        "tcp" => Transport::Tcp,
        "udp" => Transport::Udp,
        "http" => Transport::Http,
        _ => Transport::SocketIo,
    };
    serve(Options::default(), transport)
}

fn ping(id: &str) -> Vec<u8> {
    json!({ "$fw.version": "1.0", "id": id, "body": { "type": "SYS-PING" } }).to_string().into_bytes()
}

/// Sends a ping, and returns the type of the response.
fn ping_server(client: &mut dyn Client) -> io::Result<String> {
    client.send(&ping("calm"))?;
    loop {
        match client.receive(deadline())? {
            Received::Message(text) => {
                let message: Value = serde_json::from_slice(&text).expect("JSON");
                if message["refs"] == "calm" {
                    return Ok(message["body"]["type"].as_str().expect("a type").to_owned());
                }
            }
            other => return Err(io::Error::other(format!("{other:?}"))),
        }
    }
}

/// Opens a connection, sends a ping, and returns the type of the response.
fn ping_at(endpoint: &Endpoint, access: &Access) -> io::Result<String> {
    ping_server(&mut *connect_with(endpoint, access, deadline())?)
}

/// Opens a connection and sends a ping, which must fail. Returns the error.
fn refusal(endpoint: &Endpoint, access: &Access) -> io::Error {
    ping_at(endpoint, access).expect_err("a refusal")
}

#[test]
fn reports_a_refused_connection_as_refused() {
    let address = free_address();
    for parts in URLS {
        let endpoint = url(parts, address);
        let error = refusal(&endpoint, &Access::default());
        assert_eq!(error.kind(), ErrorKind::ConnectionRefused, "{endpoint}: {error}");
        assert_eq!(error.to_string(), format!("connection refused: no server listens on {address}"));
        assert!(is_temporary(&error));
    }
}

#[test]
fn reports_an_unknown_host_as_not_found() {
    for parts in URLS {
        let endpoint = url(parts, "no-such-host.invalid:5001");
        let error = refusal(&endpoint, &Access::default());
        assert_eq!(error.kind(), ErrorKind::NotFound, "{endpoint}: {error}");
        assert!(error.to_string().starts_with("host not found: no-such-host.invalid"), "{error}");
        assert!(!is_temporary(&error));
    }
}

#[cfg(not(feature = "tls"))]
#[test]
fn reports_a_build_without_tls() {
    let listener = TcpListener::bind(location()).expect("a port");
    let address = listener.local_addr().expect("an address");
    for scheme in ["tcps", "https", "wss", "socketios"] {
        let error = refusal(&url((scheme, ""), address), &Access::default()).to_string();
        assert_eq!(error, "this build has no TLS: enable the feature `tls`");
    }
    let file = std::path::Path::new("ca.pem");
    for (authorities, is_insecure) in [(Some(file), false), (None, true)] {
        let error = Trust::new(authorities, is_insecure).expect_err("no TLS");
        assert_eq!(error, "this build has no TLS: enable the feature `tls`");
    }
    Trust::new(None, false).expect("no options");
}

#[test]
fn ends_handshakes_with_silent_servers_in_time() {
    // The operating system accepts connections on behalf of the server.
    let listener = TcpListener::bind(location()).expect("a port");
    let address = listener.local_addr().expect("an address");
    let tls: &[_] = if cfg!(feature = "tls") { &[("tcps", ""), ("https", "")] } else { &[] };
    let plain = URLS.iter().filter(|(scheme, _)| *scheme == "socketio");
    for parts in plain.chain(tls).copied() {
        let endpoint = url(parts, address);
        let until = Clock::real().now() + Duration::from_millis(20);
        let Err(error) = connect(&endpoint, until) else { panic!("{endpoint}: connected") };
        assert_eq!(error.kind(), ErrorKind::TimedOut, "{endpoint}: {error}");
        assert!(error.to_string().starts_with("timed out: "), "{endpoint}: {error}");
    }
}

#[test]
fn waits_for_slow_servers() {
    let (_server, address) = start("http");
    let slow = Proxy { delays: [Duration::from_millis(5); 2], ..Proxy::default() }.start(address);
    for parts in http_urls() {
        let endpoint = url(parts, slow);
        let mut client = connect(&endpoint, deadline()).expect("a connection");
        assert_eq!(ping_server(&mut *client).expect("a response"), "ACK-ACK", "{endpoint}");
    }
    let (_server, address) = start("tcp");
    let clock = Clock::simulated();
    let delays = [Duration::from_secs(60); 2];
    let slow = Proxy { delays, clock: clock.clone(), ..Proxy::default() }.start(address);
    let mut client = connect(&url(("tcp", ""), slow), deadline()).expect("a connection");
    client.send(&ping("late")).expect("sent");
    let mut receive = || client.receive(Clock::real().now() + SHORT_TIME).expect("an open connection");
    assert_eq!(receive(), Received::Silence);
    let received = wait_for("the answer arrives", || {
        clock.sleep(delays[0]);
        Some(receive()).filter(|received| *received != Received::Silence)
    });
    assert!(matches!(received, Received::Message(_)), "{received:?}");
}

#[test]
fn survives_the_loss_of_datagrams() {
    let (_server, address) = start("udp");
    let lossy = Proxy { loss: 30, ..Proxy::default() }.start_udp(address);
    let mut client = connect(&url(("udp", ""), lossy), deadline()).expect("a socket");
    for number in 0..40 {
        client.send(&ping(&format!("lull-{number}"))).expect("a loss is not an error");
    }
    let mut answered = 0;
    wait_for("a datagram arrives", || {
        client.send(&ping("last")).expect("a loss is not an error");
        loop {
            match client.receive(Clock::real().now() + SHORT_TIME).expect("a loss is not an error") {
                Received::Message(text) if String::from_utf8_lossy(&text).contains("last") => return Some(()),
                Received::Message(_) => answered += 1,
                Received::Silence => return None,
                other => panic!("{other:?}"),
            }
        }
    });
    let lost = 40 - answered;
    assert!(answered > 0 && lost > 0, "{answered} answered, {lost} lost");
}

#[test]
fn uses_a_socket_again_after_a_refusal() {
    let address = free_address();
    let mut client = connect(&url(("udp", ""), address), deadline()).expect("a socket");
    let error = ping_server(&mut *client).expect_err("no server");
    assert_eq!(error.kind(), ErrorKind::ConnectionRefused);
    // The server starts.
    let socket = UdpSocket::bind(address).expect("the same port");
    client.send(b"{}").expect("sent");
    let (length, from) = socket.recv_from(&mut [0; 10]).expect("a datagram");
    assert_eq!(length, 2);
    socket.send_to(b"{\"id\":1}", from).expect("sent");
    assert_eq!(client.receive(deadline()).expect("a datagram"), Received::Message(b"{\"id\":1}".to_vec()));
}

#[test]
fn reports_a_closed_connection_as_the_end() {
    let address = custom_server(|mut stream| {
        let _ = stream.read(&mut [0; 10]);
        let _ = stream.write_all(b"{\"id\":1}\n");
    });
    let mut client = connect(&url(("tcp", ""), address), deadline()).expect("a connection");
    client.send(b"{}").expect("sent");
    assert_eq!(client.receive(deadline()).expect("a line"), Received::Message(b"{\"id\":1}".to_vec()));
    assert_eq!(client.receive(deadline()).expect("the end"), Received::End);
}
