//! Servers are watched over all transports, also those that go away and those that mean harm.
//!
//! Nothing here depends on something being fast: whoever waits for something has plenty of time.

use std::io::{self, BufWriter, Write as _};
use std::net::TcpListener;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use super::roster::UAV_LIMIT;
use crate::serve::{Options, Server, Transport, error};
use crate::tests::support::server::{answer_requests, custom_server, location, serve};
use crate::watch::fleet::{Fleet, Link};
use crate::watch::message::News;
use crate::watch::session::{Event, Session};
use serde_json::{Value, json};

/// How long something may take that has to happen.
const TIMEOUT: Duration = Duration::from_secs(60);

/// The ways to connect, but for host and port.
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
    _session: Session,
    /// How many messages came that tell of states without having been asked, and how many in answer.
    reported: [usize; 2],
}

impl Watched {
    fn new(url: &str) -> Self {
        let (sender, events) = sync_channel(4);
        let session =
            Session::start(url.parse().expect("an endpoint"), move |event| sender.send(event).is_ok());
        Self { fleet: Fleet::default(), events, _session: session, reported: [0; 2] }
    }

    /// Takes what happens until something is so.
    fn until(&mut self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let end = Instant::now() + TIMEOUT;
        while !is_so(self) {
            let left = end.saturating_duration_since(Instant::now());
            let event = self.events.recv_timeout(left).unwrap_or_else(|error| panic!("{what}: {error}"));
            if let Event::Received(message) = &event
                && matches!(message.news, News::States(_))
            {
                self.reported[usize::from(message.refs.is_some())] += 1;
            }
            self.fleet.take(event, Instant::now());
        }
    }

    fn ids(&self) -> Vec<&str> {
        self.fleet.uavs().map(|(id, _)| id).collect()
    }
}

#[test]
fn a_fleet_is_seen_over_every_transport() {
    for (transport, rest) in TRANSPORTS {
        let errors = vec![error("glider-2=193").expect("a code")];
        let (_server, address) = serve(Options { uavs: 60, errors, ..Options::default() }, transport);
        let mut watched = Watched::new(&format!("{}://{address}{rest}", transport.name()));
        watched.until("all tell their state", |watched| watched.fleet.is_complete());
        watched.until("the server tells what it is", |watched| watched.fleet.server.is_some());
        assert_eq!(watched.fleet.len(), 60, "{transport:?}");
        assert_eq!(watched.fleet.link, Link::Connected);
        assert_eq!(watched.fleet.server.as_deref(), Some(concat!("uavspec ", env!("CARGO_PKG_VERSION"))));
        let uav = watched.fleet.get("glider-2").expect("it is there");
        assert_eq!(uav.codes(), [193, 1]);
        let state = uav.state.as_ref().expect("its state");
        assert_eq!(state.mode.known().map(String::as_str), Some("stab"));
        assert!(watched.fleet.age(uav, Instant::now()).is_some());
    }
}

#[test]
fn requests_missing_states_again() {
    for transport in [Transport::Tcp, Transport::Udp, Transport::Http] {
        let (_server, address) = serve(Options { rate: 0.0, ..Options::default() }, transport);
        let mut watched = Watched::new(&format!("{}://{address}", transport.name()));
        watched.until("states come again and again", |watched| watched.reported[1] > 2);
        assert_eq!((watched.fleet.is_complete(), watched.reported[0]), (true, 0));
    }
}

#[test]
fn a_server_that_goes_away_and_comes_back_is_seen_again() {
    let (server, address) = serve(Options::default(), Transport::Tcp);
    let mut watched = Watched::new(&format!("tcp://{address}"));
    watched.until("the fleet is known", |watched| watched.fleet.is_complete());
    server.end();
    watched.until("it is gone", |watched| matches!(watched.fleet.link, Link::Lost { .. }));
    assert_eq!(watched.fleet.len(), 5, "what was known stays known");
    let options = Options { uavs: 2, ..Options::default() };
    // The port is free again in a moment, on any system.
    let end = Instant::now() + TIMEOUT;
    let _server = loop {
        match Server::start(options.clone(), &[(Transport::Tcp, address)]) {
            Ok(server) => break server,
            Err(error) => assert!(Instant::now() < end, "{error}"),
        }
        thread::sleep(Duration::from_millis(50));
    };
    watched.until("the new fleet is known", |watched| watched.ids() == ["glider-1", "glider-2"]);
    assert_eq!(watched.fleet.link, Link::Connected);
}

#[test]
fn never_reports_a_present_uav_as_gone() {
    let listener = TcpListener::bind(location()).expect("a port");
    let address = listener.local_addr().expect("an address");
    drop(listener);
    for transport in ["tcp", "udp", "http", "socketio"] {
        let mut watched = Watched::new(&format!("{transport}://{address}"));
        watched.until("nobody is there", |watched| matches!(watched.fleet.link, Link::Lost { .. }));
        assert!(watched.fleet.is_empty());
    }
}

#[test]
fn uavs_that_come_and_go_without_a_word_are_noticed() {
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
            // Requests that it doesn't know it leaves alone.
            _ => None,
        });
    });
    let mut watched = Watched::new(&format!("tcp://{address}"));
    watched.until("another guest comes", |watched| watched.fleet.get("guest-1").is_some());
    watched.until("the first has left", |watched| watched.fleet.get("guest-0").is_none());
    assert_eq!((watched.ids()[0], watched.fleet.server.as_deref()), ("glider-1", None));
}

#[test]
fn a_flood_is_borne() {
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
        // With requests unread, the end of the connection would take with it what is on its way.
        let _ = sent.and_then(|()| stream.flush()).and_then(|()| io::copy(&mut received, &mut io::sink()));
    });
    let mut watched = Watched::new(&format!("tcp://{address}"));
    watched.until("all of it was read", |watched| watched.fleet.unreadable == FLOOD / 2);
    assert_eq!((watched.fleet.len(), watched.fleet.is_overfull), (UAV_LIMIT, true));
}
