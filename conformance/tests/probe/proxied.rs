//! Probes of the reference server through a proxy: the server conforms, so no rule may be violated.

use uavspec_conformance::model::Level;
use uavspec_conformance::transport::Trust;

use super::*;
use crate::support::LIMIT;
use crate::support::proxy::{MOVED, Proxy, certified};
use crate::support::server;

/// Probes the reference server through a proxy. `url` contains `ADDRESS` in place of the address.
fn probed_through(proxy: Proxy, transport: Transport, url: &str, options: &Options) -> Probed {
    let (_server, address) = server::serve(serve::Options::default(), transport);
    let is_udp = matches!(transport, Transport::Udp);
    let address = if is_udp { proxy.start_udp(address) } else { proxy.start(address) };
    let probed = probed(&url.replace("ADDRESS", &address.to_string()), options);
    assert_eq!(probed.failure, None);
    // The proxy has another port than SYS-PORTS states, which is no violation.
    let is_violation = |group: &&uavspec_conformance::model::Group| group.rule.level != Level::Info;
    let found: Vec<_> = probed.result.findings.groups().filter(is_violation).collect();
    assert!(found.is_empty(), "{url}: {found:?}");
    probed
}

fn long_options() -> Options {
    Options { limit: LIMIT, timeout: Duration::from_secs(30), ..short_options() }
}

#[test]
fn probes_a_server_behind_a_long_delay() {
    let delays = [Duration::from_millis(900); 2];
    let proxy = Proxy { delays, ..Proxy::default() };
    let options = Options { timeout: Duration::from_secs(30), ..short_options() };
    let probed = probed_through(proxy, Transport::Tcp, "tcp://ADDRESS", &options);
    let reason = probed.cut_short.expect("too slow for the time limit");
    assert!(reason.starts_with("out of time: "), "{reason}");
}

#[test]
fn probes_a_server_that_loses_datagrams() {
    let proxy = Proxy { loss: 10, ..Proxy::default() };
    // A lost datagram is sent again, and proves nothing.
    let options = Options { timeout: Duration::from_secs(2), ..long_options() };
    let probed = probed_through(proxy, Transport::Udp, "udp://ADDRESS", &options);
    assert_eq!(probed.cut_short, None);
    let unanswered: Vec<&RequestType> =
        probed.requests.iter().filter(|entry| entry.sent > 0 && entry.answered == 0).collect();
    assert!(unanswered.is_empty(), "{unanswered:?}");
}

#[test]
fn probes_a_server_behind_a_redirect() {
    let redirect = Some(("308 Permanent Redirect", MOVED.to_owned()));
    for url in ["http://ADDRESS", "socketio://ADDRESS", "socketio://ADDRESS?transport=polling"] {
        let proxy = Proxy { redirect: redirect.clone(), ..Proxy::default() };
        assert_eq!(probed_through(proxy, Transport::Http, url, &long_options()).cut_short, None, "{url}");
    }
}

#[test]
fn probes_a_server_behind_a_login() {
    let proxy = Proxy { login: Some("cGlsb3Q6c2VjcmV0"), ..Proxy::default() };
    let login = Some(("pilot".to_owned(), "secret".to_owned()));
    let options = Options { login, ..long_options() };
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
        let options = Options { trust, ..long_options() };
        assert_eq!(probed_through(proxy, transport, url, &options).cut_short, None, "{url}");
    }
}
