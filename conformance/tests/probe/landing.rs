//! Probes in this process that lose their connection, their time or their UAV while it flies, and that panic.

use uavspec_conformance::probe::Stop;
use uavspec_conformance::transport::Trust;

use super::flight::{FLIGHT, GROUND, Requests, UAV, assert_safe, recording, state, state_after};
use super::*;
use crate::support::proxy::{Pass, Proxy, Watch, certified};

/// The options of a short probe that flies.
fn flight_options(endpoint: &Endpoint) -> Options {
    let only = FLIGHT.iter().filter(|name| name.starts_with("UAV")).map(|name| (*name).to_owned()).collect();
    let selection = Selection::new(only, Vec::new(), &DEFINITIONS, endpoint).expect("known types");
    Options {
        selection: selection.without_trials(),
        ..Options::new(Duration::ZERO, None, vec![UAV.to_owned()])
    }
}

/// A probe through a proxy, in this process.
fn flown(server: &Server, watch: Watch, change: impl FnOnce(Options) -> Options) -> Probed {
    let proxy = Proxy { watch: Some(watch), ..Proxy::default() }.start(server.listening()[0].address);
    let endpoint: Endpoint = format!("tcp://{proxy}").parse().expect("an endpoint");
    probe(&endpoint, &change(flight_options(&endpoint)), &DEFINITIONS, None, &|_, _| {})
}

#[test]
fn lands_uavs_on_a_new_connection_and_logs_in_again() {
    let login = ("pilot".to_owned(), "secret".to_owned());
    for points in [&["UAV-HOVER"][..], &["UAV-RTH", "UAV-LAND"], &["UAV-LAND"]] {
        let (server, _) = reference_server(Some(login.clone()));
        let requests = Requests::default();
        let left = Mutex::new(points.to_vec());
        let watch = recording(&requests, move |name| {
            let mut left = left.lock().unwrap_or_else(PoisonError::into_inner);
            match left.iter().position(|point| *point == name) {
                Some(at) => {
                    left.remove(at);
                    Pass::Cut
                }
                None => Pass::Forward,
            }
        });
        let probed = flown(&server, watch, |options| Options { login: Some(login.clone()), ..options });
        assert_eq!(probed.danger, None, "{points:?}: {:?}", requests.types());
        let after = requests.after(points[0]);
        let position = |name: &str| after.iter().position(|sent| sent == name).expect(name);
        assert!(
            position("AUTH-REQ") < position("UAV-LAND") || points == ["UAV-LAND"],
            "{points:?}: {after:?}"
        );
        let login = json!({ "type": "AUTH-REQ", "method": "basic", "data": "cGlsb3Q6c2VjcmV0" });
        let (height, codes) = state_after(&server, Some(login));
        assert_eq!((height, codes.contains(&GROUND)), (0, true), "{points:?}: {after:?}");
    }
}

#[test]
fn lands_uavs_on_connections_that_are_shorter_than_a_landing() {
    let stay = Some(Duration::from_millis(1_500));
    let options = serve::Options { stay, speed: 10.0, ..serve::Options::default() };
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    let server = Server::start(options, &[(Transport::Tcp, free)]).expect("it starts");
    let requests = Requests::default();
    let watch = recording(&requests, |_| Pass::Forward);
    let limit = Duration::from_secs(30);
    let probed = flown(&server, watch, |options| Options { landing_limit: limit, ..options });
    assert_eq!(probed.danger, None, "{:?}", requests.types());
    assert!(requests.types().contains(&"UAV-TAKEOFF".to_owned()));
    assert_safe(&server, "after short connections");
}

#[test]
fn lands_uavs_after_the_time_limit() {
    let (server, _) = reference_server(None);
    let (requests, began) = (Requests::default(), Instant::now());
    let limit = Duration::from_secs(6);
    let watch = recording(&requests, move |name| {
        if name == "UAV-HOVER" {
            // The probe begins a little later.
            let end = began + limit + Duration::from_millis(500);
            thread::sleep(end.saturating_duration_since(Instant::now()));
        }
        Pass::Forward
    });
    let probed = flown(&server, watch, |options| Options { limit, ..options });
    assert_eq!(probed.danger, None);
    assert!(probed.cut_short.expect("a reason").starts_with("out of time"));
    assert!(requests.after("UAV-HOVER").contains(&"UAV-LAND".to_owned()));
    assert!(!requests.types().contains(&"UAV-FLY".to_owned()));
    assert_safe(&server, "after the time limit");
}

/// Panics when certain text is recorded.
struct Panicking {
    left: Vec<&'static str>,
    tape: Shared,
}

impl std::io::Write for Panicking {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let text = String::from_utf8_lossy(bytes);
        if let Some(at) = self.left.iter().position(|point| text.contains(point)) {
            self.left.remove(at);
            panic!("expected by this test");
        }
        self.tape.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn lands_uavs_after_a_panic() {
    for points in [&["UAV-TAKEOFF"][..], &["UAV-HOVER"], &["UAV-LAND"], &["UAV-FLY", "UAV-LAND", "UAV-INF"]] {
        let (server, url) = reference_server(None);
        let endpoint: Endpoint = url.parse().expect("an endpoint");
        let tape = Shared::default();
        let record = Panicking { left: points.to_vec(), tape: tape.clone() };
        let options = flight_options(&endpoint);
        let probed = probe(&endpoint, &options, &DEFINITIONS, Some(Box::new(record)), &|_, _| {});
        assert_eq!(probed.danger, None, "{points:?}");
        assert_eq!(probed.failure.as_deref(), Some("internal error of uavspec: expected by this test"));
        assert_safe(&server, points[0]);
    }
}

/// A UAV whose altitude is unknown can't be confirmed.
#[test]
fn a_uav_that_is_lost_in_flight_is_not_safe() {
    let options = serve::Options {
        losses: vec![(UAV.to_owned(), Duration::from_secs(4))],
        ..serve::Options::default()
    };
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    let server = Server::start(options, &[(Transport::Tcp, free)]).expect("it starts");
    let began = Instant::now();
    let requests = Requests::default();
    let watch = recording(&requests, move |name| {
        if name == "UAV-HOVER" {
            thread::sleep((began + Duration::from_secs(5)).saturating_duration_since(Instant::now()));
        }
        Pass::Forward
    });
    let limit = Duration::from_secs(4);
    let probed = flown(&server, watch, |options| Options { landing_limit: limit, ..options });
    let danger = probed.danger.expect("a UAV");
    assert!(danger.starts_with("UAV glider-2 may still fly ("), "{danger}");
    let types = requests.types();
    assert!(!types.contains(&"UAV-HALT".to_owned()), "{types:?}");
}

/// Interrupts a flight over a transport as soon as the UAV has taken off.
fn interrupt_flight(transport: Transport, scheme: &str, query: &str, is_encrypted: bool) {
    let options = serve::Options { speed: 10.0, ..serve::Options::default() };
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    let server = Server::start(options, &[(Transport::Tcp, free), (transport, free)]).expect("it starts");
    let mut address = server.listening()[1].address;
    let folder = tempfile::tempdir().expect("a folder");
    let mut trust = Trust::default();
    if is_encrypted {
        let (pem, config) = certified(&["127.0.0.1"]);
        let path = folder.path().join("ca.pem");
        std::fs::write(&path, pem).expect("a file");
        trust = Trust::new(Some(&path), false).expect("a certificate");
        address = Proxy { tls: Some(config), ..Proxy::default() }.start(address);
    }
    let endpoint: Endpoint = format!("{scheme}://{address}{query}").parse().expect("an endpoint");
    let stop = Stop::default();
    let options = Options { trust, stop: stop.clone(), ..flight_options(&endpoint) };
    let probed = thread::scope(|scope| {
        let probing = scope.spawn(|| probe(&endpoint, &options, &DEFINITIONS, None, &|_, _| {}));
        while state(&server).0 < 2_000 && !probing.is_finished() {
            thread::sleep(Duration::from_millis(20));
        }
        assert!(stop.request(), "{endpoint}");
        probing.join().expect("no panic")
    });
    assert_eq!((&probed.danger, &probed.failure), (&None, &None), "{endpoint}");
    let reason = probed.cut_short.as_deref().expect("a reason");
    assert!(reason.starts_with("interrupted"), "{endpoint}: {reason}");
    assert_eq!(rules(&probed), BTreeSet::new(), "{endpoint}");
    assert_eq!(stop.at_risk(), None);
    assert_safe(&server, &endpoint.to_string());
}

#[test]
fn lands_uavs_over_each_transport() {
    thread::scope(|scope| {
        for (transport, scheme, query, is_encrypted) in [
            (Transport::Tcp, "tcp", "", false),
            (Transport::Tcp, "tcps", "", true),
            (Transport::Udp, "udp", "", false),
            (Transport::Http, "http", "/api/v1", false),
            (Transport::Http, "https", "/api/v1", true),
            (Transport::SocketIo, "socketio", "", false),
            (Transport::SocketIo, "socketio", "?protocol=4&transport=polling", false),
        ] {
            scope.spawn(move || interrupt_flight(transport, scheme, query, is_encrypted));
        }
    });
}
