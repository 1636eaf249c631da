//! Tests of HTTP statuses, redirects and logins.

use uavspec_test_server::proxy::MOVED;

use super::*;

/// `pilot:secret` in base64.
const LOGIN: &str = "cGlsb3Q6c2VjcmV0";

fn access(password: &str) -> Access {
    Access::new(Some(("pilot".to_owned(), password.to_owned())), Trust::default())
}

/// Starts a server and a proxy. Over HTTP, the server requires the login. Over Socket.IO, only the proxy requires it.
fn start_with_login(scheme: &str, proxy: &Proxy) -> (Server, SocketAddr) {
    let login = (scheme == "http").then(|| ("pilot".to_owned(), "secret".to_owned()));
    let (server, address) = serve(Options { login, ..Options::default() }, Transport::Http);
    (server, proxy.clone().start(address))
}

#[test]
fn sends_the_login_to_servers_that_require_one() {
    let proxy = Proxy { login: Some(LOGIN), ..Proxy::default() };
    for parts in http_urls() {
        let (_server, address) = start_with_login(parts.0, &proxy);
        let endpoint = url(parts, address);
        assert_eq!(ping_at(&endpoint, &access("secret")).expect("a response"), "ACK-ACK", "{endpoint}");
        let error = refusal(&endpoint, &access("wrong"));
        assert_eq!(http_status(&error), Some(401));
        let expected = "HTTP status 401 Unauthorized: the server refused the login: check the name and the password \
                        in --login; the server says: log in";
        assert_eq!(error.to_string(), expected, "{endpoint}");
        let error = refusal(&endpoint, &Access::default());
        let expected = "HTTP status 401 Unauthorized: the server requires a login: use --login NAME:PASSWORD; the \
                        server says: log in";
        assert_eq!(error.to_string(), expected, "{endpoint}");
        assert!(!is_temporary(&error));
    }
}

#[test]
fn names_a_login_that_is_not_supported() {
    let address = custom_server(|mut stream| {
        let _ = stream.read(&mut [0; 1 << 12]);
        let answer = "HTTP/1.1 401 Unauthorized\r\nWWW-Authenticate: Bearer realm=\"fleet\"\r\nContent-Length: 0\r\n\r\n";
        let _ = stream.write_all(answer.as_bytes());
    });
    for parts in http_urls() {
        let error = refusal(&url(parts, address), &access("secret")).to_string();
        assert!(
            error.ends_with("the server requires a login with Bearer, but only Basic is supported"),
            "{error}"
        );
    }
}

#[test]
fn follows_redirects_on_the_same_host() {
    for status in [
        "301 Moved Permanently",
        "302 Found",
        "303 See Other",
        "307 Temporary Redirect",
        "308 Permanent Redirect",
    ] {
        let redirect = Some((status, MOVED.to_owned()));
        let proxy = Proxy { redirect, login: Some(LOGIN), ..Proxy::default() };
        for parts in http_urls() {
            let (_server, address) = start_with_login(parts.0, &proxy);
            let endpoint = url(parts, address);
            let kind = ping_at(&endpoint, &access("secret"));
            assert_eq!(kind.expect("a response"), "ACK-ACK", "{endpoint}, {status}");
        }
    }
}

#[test]
fn names_the_other_host_of_a_redirect() {
    let (_server, address) = start("http");
    let redirect = Some(("308 Permanent Redirect", "http://glider.example:8080".to_owned()));
    let proxy = Proxy { redirect, ..Proxy::default() }.start(address);
    for parts in http_urls() {
        let endpoint = url(parts, proxy);
        let error = refusal(&endpoint, &access("secret"));
        assert_eq!(http_status(&error), Some(308));
        let start = "HTTP status 308 Permanent Redirect: the server redirects to http://glider.example:8080/";
        let text = error.to_string();
        assert!(text.starts_with(start) && text.ends_with(": use that URL instead"), "{endpoint}: {text}");
    }
}

#[test]
fn ends_a_loop_of_redirects() {
    let address = custom_server(|mut stream| {
        let _ = stream.read(&mut [0; 1 << 12]);
        let answer =
            "HTTP/1.1 302 Found\r\nLocation: /loop\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";
        let _ = stream.write_all(answer.as_bytes());
    });
    for parts in http_urls() {
        let error = refusal(&url(parts, address), &Access::default());
        let expected = format!("more than 5 redirects, the last one to http://{address}/loop");
        assert_eq!(error.to_string(), expected);
    }
}

#[test]
fn reports_statuses_as_errors_and_never_as_messages() {
    let (_server, address) = start("http");
    let body = r#"{"$fw.version":"1.0","id":"a","refs":"calm","body":{"type":"ACK-ACK"}}"#;
    for (status, expected) in [
        ("404 Not Found", "check the host, the port and the path in the URL"),
        ("403 Forbidden", "the server refuses access to http://"),
        ("405 Method Not Allowed", "check the path in the URL"),
        ("500 Internal Server Error", "unexpected response from http://"),
        ("503 Service Unavailable", "the server is not available at the moment"),
        ("304 Not Modified", "unexpected response from http://"),
    ] {
        let proxy = Proxy { answer: Some((status, body)), ..Proxy::default() }.start(address);
        for parts in http_urls() {
            let endpoint = url(parts, proxy);
            let error = refusal(&endpoint, &Access::default());
            let text = error.to_string();
            assert!(text.starts_with(&format!("HTTP status {status}: ")), "{endpoint}: {text}");
            assert!(text.contains(expected), "{endpoint}: {text}");
            // A response with this status has no body.
            assert!(text.contains("ACK-ACK") || status.starts_with("304"), "{endpoint}: {text}");
            assert_eq!(is_temporary(&error), status.starts_with("503"));
        }
    }
}

#[test]
fn reports_a_server_without_a_web_socket() {
    let (_server, address) = start("http");
    let proxy = Proxy { answer: Some(("200 OK", "welcome")), ..Proxy::default() }.start(address);
    let error = refusal(&url(("ws", ""), proxy), &Access::default()).to_string();
    let expected = format!(
        "HTTP status 200 OK: the server doesn't open a WebSocket at http://{proxy}/socket.io/; the server says: \
         welcome"
    );
    assert_eq!(error, expected);
}

#[test]
fn reports_an_answer_that_is_not_http() {
    let address = custom_server(|mut stream| {
        let _ = stream.read(&mut [0; 1 << 12]);
        let _ = stream.write_all(b"{\"id\":1}\n\n");
    });
    for parts in http_urls() {
        let error = refusal(&url(parts, address), &Access::default());
        assert!(error.to_string().starts_with("the server's answer isn't HTTP ("), "{error}");
        assert_eq!(error.kind(), ErrorKind::InvalidData);
    }
}
