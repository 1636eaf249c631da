//! Tests of sessions with servers over all transports, including servers that disconnect or flood the client.
//!
//! No test depends on speed: all timeouts are long.

use std::io::{self, BufWriter, Write as _};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

use serde_json::{Value, json};
use uavspec_flockwave::transport::{Access, Trust};
use uavspec_model::clock::Clock;
use uavspec_serve::{Options, Server, Transport, error};
use uavspec_test_server::proxy::Proxy;
use uavspec_test_server::server::{answer_requests, custom_server, serve};
use uavspec_test_support::{deadline, extent, free_address, wait_for};

use crate::limits::MAX_UAVS;
use crate::watch::fleet::{Fleet, Link};
use crate::watch::message::Content;
use crate::watch::session::{self, Event};

/// The transports, with the suffixes of their URLs.
const TRANSPORTS: [(Transport, &str); 5] = [
    (Transport::Tcp, ""),
    (Transport::Udp, ""),
    (Transport::Http, ""),
    (Transport::SocketIo, ""),
    (Transport::SocketIo, "?protocol=4&transport=polling"),
];

/// A fleet that is watched.
struct Watched {
    fleet: Fleet,
    events: Receiver<Event>,
    /// The number of notifications with states, and the number of responses with states.
    reported: [usize; 2],
}

impl Watched {
    fn new(url: &str) -> Self {
        Self::with(url, Access::default())
    }

    fn with(url: &str, access: Access) -> Self {
        let (sender, events) = sync_channel(4);
        session::start(url.parse().expect("an endpoint"), access, move |event| sender.send(event).is_ok());
        Self { fleet: Fleet::default(), events, reported: [0; 2] }
    }

    /// Processes events until a condition is met.
    fn until(&mut self, condition: &str, is_met: impl Fn(&Self) -> bool) {
        let (clock, end) = (Clock::real(), deadline());
        while !is_met(self) {
            let event =
                clock.receive(&self.events, end).unwrap_or_else(|error| panic!("{condition}: {error}"));
            if let Event::Received(message) = &event
                && matches!(message.content, Content::States(_))
            {
                self.reported[usize::from(message.refs.is_some())] += 1;
            }
            self.fleet.take(event, clock.now());
        }
    }

    fn ids(&self) -> Vec<&str> {
        self.fleet.uavs().map(|(id, _)| id).collect()
    }
}

#[test]
fn watches_a_fleet_over_every_transport() {
    for (transport, rest) in TRANSPORTS {
        let errors = vec![error("glider-2=193").expect("a code")];
        let (_server, address) = serve(Options { uavs: 60, errors, ..Options::default() }, transport);
        let mut watched = Watched::new(&format!("{}://{address}{rest}", transport.name()));
        watched.until("all states are known", |watched| watched.fleet.is_complete());
        watched.until("the server version is known", |watched| watched.fleet.server.is_some());
        assert_eq!(watched.fleet.len(), 60, "{transport:?}");
        assert_eq!(watched.fleet.link, Link::Connected);
        assert_eq!(watched.fleet.server.as_deref(), Some(concat!("uavspec ", env!("CARGO_PKG_VERSION"))));
        let uav = watched.fleet.get("glider-2").expect("it is there");
        assert_eq!(uav.codes(), [193, 1]);
        let state = uav.state.as_ref().expect("its state");
        assert_eq!(state.mode.known().map(String::as_str), Some("stab"));
        assert!(watched.fleet.age(uav, Clock::real().now()).is_some());
    }
}

#[test]
fn logs_in_to_a_server_behind_a_proxy() {
    let (_server, address) = serve(Options::default(), Transport::SocketIo);
    // `pilot:secret` in base64.
    let proxy = Proxy { login: Some("cGlsb3Q6c2VjcmV0"), ..Proxy::default() }.start(address);
    for carrier in ["websocket", "polling"] {
        let url = format!("socketio://{proxy}?transport={carrier}");
        let login = Some(("pilot".to_owned(), "secret".to_owned()));
        let mut watched = Watched::with(&url, Access::new(login, Trust::default()));
        watched.until("all states are known", |watched| watched.fleet.is_complete());
        let mut refused = Watched::new(&url);
        refused.until("the login is missing", |watched| {
            matches!(&watched.fleet.link, Link::Lost { reason, .. } if reason.contains("use --login"))
        });
    }
}

#[test]
fn requests_missing_states_again() {
    let count = extent(2, 1);
    // The requests are seconds apart.
    thread::scope(|scope| {
        for transport in [Transport::Tcp, Transport::Udp, Transport::Http] {
            scope.spawn(move || {
                let (_server, address) = serve(Options { rate: 0.0, ..Options::default() }, transport);
                let mut watched = Watched::new(&format!("{}://{address}", transport.name()));
                watched.until("states are requested repeatedly", |watched| watched.reported[1] > count);
                assert_eq!((watched.fleet.is_complete(), watched.reported[0]), (true, 0));
            });
        }
    });
}

#[test]
fn reconnects_to_a_restarted_server() {
    let address = free_address();
    let server = Server::start(Options::default(), &[(Transport::Tcp, address)]).expect("it starts");
    let mut watched = Watched::new(&format!("tcp://{address}"));
    watched.until("the fleet is known", |watched| watched.fleet.is_complete());
    server.end();
    watched.until("the connection is lost", |watched| matches!(watched.fleet.link, Link::Lost { .. }));
    assert_eq!(watched.fleet.len(), 5, "known UAVs remain");
    let options = Options { uavs: 2, ..Options::default() };
    // The port may still be in use for a moment.
    let start = || Server::start(options.clone(), &[(Transport::Tcp, address)]).ok();
    let _server = wait_for("the port is free", start);
    watched.until("the new fleet is known", |watched| watched.ids() == ["glider-1", "glider-2"]);
    assert_eq!(watched.fleet.link, Link::Connected);
}

#[test]
fn reports_a_refused_connection_as_lost() {
    let address = free_address();
    for transport in ["tcp", "udp", "http", "socketio"] {
        let mut watched = Watched::new(&format!("{transport}://{address}"));
        watched.until("the connection is refused", |watched| matches!(watched.fleet.link, Link::Lost { .. }));
        assert!(watched.fleet.is_empty());
    }
}

#[test]
fn finds_uavs_that_join_and_leave_without_notification() {
    let lists = std::sync::atomic::AtomicUsize::new(0);
    let address = custom_server(move |stream| {
        answer_requests(stream, |kind, body| match kind {
            "UAV-LIST" => {
                let number = lists.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                Some(json!({ "ids": ["glider-1", format!("guest-{number}")] }))
            }
            "UAV-INF" => {
                let ids = body["ids"].as_array().expect("ids").iter().filter_map(Value::as_str);
                let states: serde_json::Map<_, _> = ids.map(|id| (id.to_owned(), json!({}))).collect();
                Some(json!({ "status": states }))
            }
            // Other requests get no response.
            _ => None,
        });
    });
    let mut watched = Watched::new(&format!("tcp://{address}"));
    watched.until("the second guest joins", |watched| watched.fleet.get("guest-1").is_some());
    watched.until("the first guest leaves", |watched| watched.fleet.get("guest-0").is_none());
    assert_eq!((watched.ids()[0], watched.fleet.server.as_deref()), ("glider-1", None));
}

#[test]
fn survives_a_flood_of_messages() {
    const FLOOD: u64 = 100_000;
    let address = custom_server(|stream| {
        let mut received = stream.try_clone().expect("a second handle");
        let mut stream = BufWriter::new(stream);
        let sent = (0..FLOOD).try_for_each(|number| match number % 4 {
            0 => writeln!(stream, r#"{{"body":{{"type":"UAV-INF","status":{{"{number}":{{}}}}}}}}"#),
            1 => writeln!(stream, r#"{{"body":{{"type":"UAV-LIST","ids":["{number}",7]}}}}"#),
            2 => writeln!(stream, r#"{{"body":{{"type":"UAV-INF","status":[[[[{number}"#),
            _ => writeln!(stream, "\u{1b}[2J{number}"),
        });
        // If the connection is closed while there are unread requests, data in transit is lost.
        let _ = sent.and_then(|()| stream.flush()).and_then(|()| io::copy(&mut received, &mut io::sink()));
    });
    let mut watched = Watched::new(&format!("tcp://{address}"));
    watched.until("all messages are read", |watched| watched.fleet.unreadable == FLOOD / 2);
    assert_eq!((watched.fleet.len(), watched.fleet.is_overfull), (MAX_UAVS, true));
}
