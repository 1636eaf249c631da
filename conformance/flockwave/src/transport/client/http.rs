//! Stateless HTTP: each message is a POST request, and the HTTP response contains the answer. Later messages from the
//! server are lost.
//!
//! The specification doesn't describe this transport. The body of an HTTP response is returned unchanged. Some servers
//! send the body of their answer without an envelope.

use std::collections::VecDeque;
use std::io;
use std::time::{Duration, Instant};

use uavspec_model::clock::Clock;
use uavspec_model::net::{self, Stream, tls};
use ureq::http::response::Parts;
use ureq::http::{Request, header};
use ureq::{Agent, AsSendBody, Timeout};

use super::status::{Refusal, redirected, too_many_redirects};
use super::target::Target;
use super::{Client, Received, invalid, timed_out};
use crate::limits::REDIRECT_LIMIT;
use crate::transport::MESSAGE_LIMIT;
use crate::transport::access::Access;

pub(super) struct OneShot {
    client: HttpClient,
    /// The time limit of each request.
    limit: Duration,
    answers: VecDeque<Vec<u8>>,
}

impl OneShot {
    /// Creates a client with the same time limit for each answer as for the connection.
    pub(super) fn connect(target: Target, access: &Access, until: Instant) -> io::Result<Self> {
        let limit = Clock::real().left(until);
        Ok(Self { client: HttpClient::connect(target, access, until)?, limit, answers: VecDeque::new() })
    }
}

impl Client for OneShot {
    fn send(&mut self, message: &[u8]) -> io::Result<()> {
        let answer = self.client.post("application/json", message, Clock::real().now() + self.limit)?;
        self.answers.push_back(answer);
        Ok(())
    }

    fn receive(&mut self, until: Instant) -> io::Result<Received> {
        if let Some(answer) = self.answers.pop_front() {
            return Ok(Received::Message(answer));
        }
        // Nothing arrives without a request. Sleep, so that callers don't loop without a pause.
        Clock::real().sleep_until(until);
        Ok(Received::Silence)
    }
}

/// Sends HTTP requests to one target. Follows redirects on the same host, without changing the method or the body.
#[derive(Clone)]
pub(super) struct HttpClient {
    agent: Agent,
    target: Target,
    access: Access,
}

impl HttpClient {
    /// Creates a client, after a test connection. Fails if there is no server, or if its certificate is invalid.
    pub(super) fn connect(target: Target, access: &Access, until: Instant) -> io::Result<Self> {
        let is_encrypted = target.address.is_encrypted;
        // Requests open their own connections. This connection only shows that there is a server.
        Stream::open(&target.address.address(), access.trust(is_encrypted), until)?;
        Ok(Self { agent: new_agent(access, is_encrypted), target, access: access.clone() })
    }

    /// A client for another path or query on the same server.
    pub(super) fn at(&self, path: String) -> Self {
        let target = Target { path, ..self.target.clone() };
        Self { target, ..self.clone() }
    }

    /// The path and the query.
    pub(super) fn path(&self) -> &str {
        &self.target.path
    }

    /// Returns the body of the response to a GET request.
    pub(super) fn get(&self, until: Instant) -> io::Result<Vec<u8>> {
        self.request(None, until)
    }

    /// Returns the body of the response to a POST request.
    pub(super) fn post(&self, content_type: &str, body: &[u8], until: Instant) -> io::Result<Vec<u8>> {
        self.request(Some((content_type, body)), until)
    }

    fn request(&self, content: Option<(&str, &[u8])>, until: Instant) -> io::Result<Vec<u8>> {
        let (mut target, mut agent) = (self.target.clone(), self.agent.clone());
        let authorization = self.access.authorization();
        for _ in 0..=REDIRECT_LIMIT {
            let mut request = Request::builder().uri(target.url());
            if let Some(authorization) = &authorization {
                request = request.header(header::AUTHORIZATION, authorization);
            }
            let sent = match content {
                None => send(&agent, request.method("GET").body(()), until),
                Some((content_type, body)) => {
                    let request = request.method("POST").header(header::CONTENT_TYPE, content_type);
                    send(&agent, request.body(body), until)
                }
            };
            let (response, body) = sent.map_err(|error| explain(&target, error))?;
            let (status, headers) = (response.status, &response.headers);
            if status.is_success() {
                return Ok(body);
            }
            let next = redirected(&target, status, headers)?.ok_or_else(|| {
                Refusal { target: &target, status, headers, body: &body, access: &self.access }.error()
            })?;
            if next.address.is_encrypted && !target.address.is_encrypted {
                agent = new_agent(&self.access, true);
            }
            target = next;
        }
        Err(too_many_redirects(&target))
    }
}

/// Sends a request, and reads the response.
fn send(
    agent: &Agent,
    request: Result<Request<impl AsSendBody>, ureq::http::Error>,
    until: Instant,
) -> Result<(Parts, Vec<u8>), ureq::Error> {
    let limit = Clock::real().left(until);
    if limit.is_zero() {
        return Err(ureq::Error::Timeout(Timeout::Global));
    }
    let request = agent.configure_request(request?).timeout_global(Some(limit)).build();
    let (head, mut body) = agent.run(request)?.into_parts();
    let read = body.with_config().limit(MESSAGE_LIMIT as u64 * 2).read_to_vec()?;
    Ok((head, read))
}

/// An agent that neither follows redirects nor handles statuses.
fn new_agent(access: &Access, is_encrypted: bool) -> Agent {
    let config = Agent::config_builder()
        .http_status_as_error(false)
        .max_redirects(0)
        .max_redirects_will_error(false)
        // Requests to local servers must not go through a proxy from the environment.
        .proxy(None);
    #[cfg(feature = "tls")]
    let config = match access.trust(is_encrypted) {
        Some(trust) => config.tls_config(trust.agent_config()),
        None => config,
    };
    #[cfg(not(feature = "tls"))]
    let _ = (access, is_encrypted);
    config.build().into()
}

/// Names the cause of an error.
fn explain(target: &Target, error: ureq::Error) -> io::Error {
    let address = target.address.address();
    match error {
        ureq::Error::Io(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            let text =
                format!("the server closed the connection without an HTTP response{}", tls_hint(target));
            io::Error::new(error.kind(), text)
        }
        ureq::Error::Io(error) => tls::explain(net::explain(&address, error)),
        ureq::Error::Timeout(_) => no_answer(),
        ureq::Error::HostNotFound => {
            io::Error::new(io::ErrorKind::NotFound, format!("host not found: {}", address.host))
        }
        ureq::Error::Protocol(error) => not_http(target, &error),
        ureq::Error::BodyExceedsLimit(limit) => {
            invalid(format!("the HTTP response is longer than {limit} bytes"))
        }
        error => io::Error::other(error),
    }
}

/// The error for a server that doesn't answer in time.
fn no_answer() -> io::Error {
    timed_out("timed out: no HTTP response")
}

/// The error for an answer that isn't HTTP. Servers that expect TLS may also answer in this way.
pub(super) fn not_http(target: &Target, error: &dyn std::fmt::Display) -> io::Error {
    invalid(format!("the server's answer isn't HTTP ({error}){}", tls_hint(target)))
}

/// Advice to use TLS, for the error of a failed connection. Empty if the connection already used TLS.
pub(super) fn tls_hint(target: &Target) -> &'static str {
    if target.address.is_encrypted {
        ""
    } else {
        "; if the server uses TLS, use a URL with TLS (https, socketios, wss)"
    }
}
