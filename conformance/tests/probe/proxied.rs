//! Tests of probes of the reference server through a proxy. The server conforms, so no rule may be violated.

use std::rc::Rc;

use uavspec_flockwave::transport::Trust;
use uavspec_model::Level;
use uavspec_test_server::memory::Watched;
use uavspec_test_server::proxy::{MOVED, Pass, Proxy, certified};
use uavspec_test_server::server;
use uavspec_test_support::{LIMIT, Random, extent};

use super::*;

/// Probes the reference server through a proxy. In `url`, `ADDRESS` is replaced with the address.
fn probed_through(proxy: Proxy, transport: Transport, url: &str, options: &Options) -> Probed {
    let (_server, address) = server::serve(uavspec_serve::Options::default(), transport);
    let probed = probed(&url.replace("ADDRESS", &proxy.start(address).to_string()), options);
    assert_conforms(&probed);
    probed
}

/// Probes the reference server in memory, in simulated time. `passes` is called for each message in both directions. If
/// it returns false, the message is lost.
fn probed_in_memory(url: &str, options: Options, passes: impl Fn(&Clock, &[u8]) -> bool + 'static) -> Probed {
    let clock = Clock::simulated();
    let (server, endpoint) =
        (InMemory::new(uavspec_serve::Options::default(), &clock), url.parse().expect("a URL"));
    let (options, passes) =
        (Options { clock: clock.clone(), ..options }, Rc::new(move |bytes: &[u8]| passes(&clock, bytes)));
    let hears = Rc::clone(&passes);
    let watch = move |bytes: &[u8]| if passes(bytes) { Pass::Forward } else { Pass::Lose };
    let network = Watched { hears: Rc::new(move |bytes| hears(bytes)), ..Watched::new(server, watch) };
    let probed = compared(|tape| probe_on(&network, &endpoint, &options, &DEFINITIONS, Some(tape)));
    assert_conforms(&probed);
    probed
}

fn assert_conforms(probed: &Probed) {
    assert_eq!(probed.failure, None);
    // The proxy's port differs from the port in SYS-PORTS. This isn't a violation.
    let is_violation = |group: &&uavspec_model::Group| group.rule.level != Level::Info;
    let found: Vec<_> = probed.result.findings.groups().filter(is_violation).collect();
    assert!(found.is_empty(), "{found:?}");
}

fn long_options() -> Options {
    Options { limit: LIMIT, timeout: Duration::from_secs(30), ..short_options() }
}

#[test]
fn probes_a_server_behind_a_long_delay() {
    let options = Options { timeout: Duration::from_secs(30), ..short_options() };
    let probed = probed_in_memory("tcp://memory:5001", options, |clock, message| {
        // Notifications are more frequent than answers.
        if String::from_utf8_lossy(message).contains("\"refs\"") {
            clock.sleep(Duration::from_millis(1_800));
        }
        true
    });
    let reason = probed.cut_short.expect("too slow for the time limit");
    assert!(reason.starts_with("out of time: "), "{reason}");
}

#[test]
fn probes_a_server_that_loses_datagrams() {
    // A lost datagram is sent again, and proves nothing.
    let (random, lost) = (RefCell::new(Random(1)), Rc::new(Cell::new(0)));
    let count = Rc::clone(&lost);
    let probed = probed_in_memory("udp://memory:5001", long_options(), move |_, _| {
        let passes = random.borrow_mut().below(100) >= 10;
        count.set(count.get() + u32::from(!passes));
        passes
    });
    assert!(lost.get() > 10, "{}", lost.get());
    assert_eq!(probed.cut_short, None);
    let unanswered: Vec<&RequestType> =
        probed.requests.iter().filter(|entry| entry.sent > 0 && entry.answered == 0).collect();
    assert!(unanswered.is_empty(), "{unanswered:?}");
}

/// Options for tests of a connection. They exclude trials, which open further connections, except in thorough tests.
fn connection_options() -> Options {
    let selection = Selection::default();
    Options { selection: extent(selection.clone(), selection.without_trials()), ..long_options() }
}

#[test]
fn probes_a_server_behind_a_redirect() {
    let redirect = Some(("308 Permanent Redirect", MOVED.to_owned()));
    for url in ["http://ADDRESS", "socketio://ADDRESS", "socketio://ADDRESS?transport=polling"] {
        let proxy = Proxy { redirect: redirect.clone(), ..Proxy::default() };
        assert_eq!(
            probed_through(proxy, Transport::Http, url, &connection_options()).cut_short,
            None,
            "{url}"
        );
    }
}

#[test]
fn probes_a_server_behind_a_login() {
    let proxy = Proxy { login: Some("cGlsb3Q6c2VjcmV0"), ..Proxy::default() };
    let login = Some(("pilot".to_owned(), "secret".to_owned()));
    let options = Options { login, ..connection_options() };
    let probed = probed_through(proxy, Transport::SocketIo, "socketio://ADDRESS", &options);
    assert_eq!(probed.cut_short, None);
}

#[test]
fn probes_a_server_with_tls() {
    let (pem, config) = certified(&["127.0.0.1"]);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ca.pem");
    std::fs::write(&path, pem).expect("a file");
    for (transport, url) in [
        (Transport::Tcp, "tcps://ADDRESS"),
        (Transport::Http, "https://ADDRESS"),
        (Transport::Http, "wss://ADDRESS"),
    ] {
        let proxy = Proxy { tls: Some(config.clone()), ..Proxy::default() };
        let trust = Trust::new(Some(&path), false).expect("a certificate");
        let options = Options { trust, ..connection_options() };
        assert_eq!(probed_through(proxy, transport, url, &options).cut_short, None, "{url}");
    }
}
