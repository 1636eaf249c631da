//! Tests of TLS, with and without trusted certificates.

use std::path::PathBuf;

use uavspec_test_server::proxy::{certified, certified_with};

use super::*;

const TLS_URLS: [(&str, &str); 5] = [
    ("tcps", ""),
    ("https", "/api/v1"),
    ("wss", ""),
    ("socketios", "?protocol=5&transport=polling"),
    ("socketios", "?protocol=4&transport=websocket"),
];

/// A certificate file that is deleted when it is dropped.
struct Authorities(tempfile::TempDir);

impl Authorities {
    fn new(text: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("ca.pem"), text).expect("written");
        Self(folder)
    }

    fn path(&self) -> PathBuf {
        self.0.path().join("ca.pem")
    }

    fn access(&self) -> Access {
        Access::new(None, Trust::new(Some(&self.path()), false).expect("certificates"))
    }
}

#[test]
fn explains_certificates_that_are_not_valid() {
    let (_server, address) = start("http");
    let expired =
        certified_with(&["127.0.0.1"], |params| params.not_after = rcgen::date_time_ymd(2001, 2, 3));
    let future =
        certified_with(&["127.0.0.1"], |params| params.not_before = rcgen::date_time_ymd(2999, 2, 3));
    let authority = certified_with(&["127.0.0.1"], |params| {
        params.is_ca = rcgen::IsCa::Ca(rcgen::BasicConstraints::Unconstrained);
    });
    for ((pem, config), expected) in [
        (expired, "the server's certificate has expired: renew it, check the clock"),
        (future, "the server's certificate is not valid yet: check the clock"),
        (authority, "the server's certificate is a CA certificate: create a certificate without CA:TRUE, or"),
    ] {
        let proxy = Proxy { tls: Some(config), ..Proxy::default() }.start(address);
        for parts in [("wss", ""), ("https", "")] {
            let error = refusal(&url(parts, proxy), &Authorities::new(&pem).access()).to_string();
            assert!(error.starts_with(expected) && error.contains("--insecure"), "{error}");
        }
    }
}

/// Starts a server for this scheme, with a TLS proxy in front of it.
fn encrypted(scheme: &str, names: &[&str]) -> (Server, SocketAddr, Authorities) {
    let (server, address) = start(scheme);
    let (pem, config) = certified(names);
    let proxy = Proxy { tls: Some(config), ..Proxy::default() }.start(address);
    (server, proxy, Authorities::new(&pem))
}

#[test]
fn connects_to_servers_with_trusted_certificates() {
    for parts in TLS_URLS {
        let (_server, address, authorities) = encrypted(parts.0, &["127.0.0.1"]);
        let endpoint = url(parts, address);
        assert_eq!(ping_at(&endpoint, &authorities.access()).expect("a response"), "ACK-ACK", "{endpoint}");
        let insecure = Access::new(None, Trust::new(None, true).expect("no file"));
        assert_eq!(ping_at(&endpoint, &insecure).expect("a response"), "ACK-ACK", "{endpoint}");
    }
}

#[test]
fn refuses_certificates_with_an_unknown_issuer_or_another_name() {
    for parts in TLS_URLS {
        let (_server, address, authorities) = encrypted(parts.0, &["kite.example"]);
        let endpoint = url(parts, address);
        let error = refusal(&endpoint, &Access::default());
        let expected = "the server's certificate has an unknown issuer: name the issuer's certificate with --ca FILE, \
                        or accept any certificate with --insecure";
        assert_eq!(error.to_string(), expected, "{endpoint}");
        assert!(!is_temporary(&error));
        let error = refusal(&endpoint, &authorities.access()).to_string();
        assert!(error.contains("kite.example") && error.contains("not for 127.0.0.1"), "{endpoint}: {error}");
    }
}

#[test]
fn reports_a_server_without_tls() {
    for parts in TLS_URLS.into_iter().filter(|(scheme, _)| *scheme != "tcps") {
        let (_server, address) = start(parts.0);
        let endpoint = url(parts, address);
        let error = refusal(&endpoint, &Access::default()).to_string();
        let expected =
            "the server doesn't use TLS on this port: use a URL without TLS (tcp, http, socketio, ws)";
        assert_eq!(error, expected, "{endpoint}");
    }
    let address = custom_server(|mut stream| {
        let _ = stream.read(&mut [0; 1 << 12]);
        let _ = stream.write_all(b"{\"id\":1}\n");
    });
    let error = refusal(&url(("tcps", ""), address), &Access::default()).to_string();
    assert!(error.starts_with("the server doesn't use TLS on this port"), "{error}");
}

#[test]
fn reports_a_server_that_requires_tls() {
    for (scheme, expected) in [
        ("tcp", "the server uses TLS on this port: use a tcps:// URL"),
        ("http", "(https, socketios, wss)"),
        ("ws", "(https, socketios, wss)"),
    ] {
        let (_server, address, _) = encrypted(scheme, &["127.0.0.1"]);
        let endpoint = url((scheme, ""), address);
        let error = refusal(&endpoint, &Access::default()).to_string();
        assert!(error.contains(expected), "{endpoint}: {error}");
    }
}

#[test]
fn follows_a_redirect_to_tls_but_not_back() {
    let (_server, address, authorities) = encrypted("http", &["127.0.0.1"]);
    let (_plain_server, plain) = start("http");
    let redirect = Some(("307 Temporary Redirect", format!("https://{address}")));
    let to_tls = Proxy { redirect, ..Proxy::default() }.start(plain);
    let (pem, config) = certified(&["127.0.0.1"]);
    let redirect = Some(("307 Temporary Redirect", format!("http://{plain}")));
    let from_tls = Proxy { redirect, tls: Some(config), ..Proxy::default() }.start(plain);
    for parts in http_urls() {
        let endpoint = url(parts, to_tls);
        assert_eq!(ping_at(&endpoint, &authorities.access()).expect("a response"), "ACK-ACK", "{endpoint}");
        let endpoint = url((&format!("{}s", parts.0), parts.1), from_tls);
        let error = refusal(&endpoint, &Authorities::new(&pem).access()).to_string();
        assert!(error.contains(&format!("the server redirects to http://{plain}/")), "{endpoint}: {error}");
    }
}

#[test]
fn sends_half_a_connection_over_tls() {
    let (_server, address, authorities) = encrypted("tcps", &["127.0.0.1"]);
    let mut client =
        connect_with(&url(("tcps", ""), address), &authorities.access(), deadline()).expect("a connection");
    let message = ping("calm");
    let (first, second) = message.split_at(20);
    client.send_raw(first).expect("sent");
    client.send_raw(second).expect("sent");
    client.send_raw(b"\n").expect("sent");
    assert_eq!(ping_server(&mut *client).expect("a response"), "ACK-ACK");
    client.finish().expect("closed");
}

#[test]
fn reports_files_without_certificates() {
    let error = Trust::new(Some(&Authorities::new("glider\n").path()), false).expect_err("no certificate");
    assert!(error.ends_with("ca.pem: expected PEM certificates (BEGIN CERTIFICATE), found none"), "{error}");
    let error = Trust::new(Some(&PathBuf::from("missing.pem")), false).expect_err("no file");
    assert!(error.starts_with("missing.pem: can't read the certificates: "), "{error}");
    let text = "-----BEGIN CERTIFICATE-----\nYWJj\n-----END CERTIFICATE-----\n";
    let error = Trust::new(Some(&Authorities::new(text).path()), false).expect_err("no certificate");
    assert!(error.contains("ca.pem: invalid certificate: "), "{error}");
}
