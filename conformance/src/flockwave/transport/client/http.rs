//! Stateless HTTP: each message is a POST request, and the HTTP response contains the answer. Later messages from the
//! server are lost.
//!
//! The specification doesn't describe this transport. The body of an HTTP response is returned unchanged. Some servers
//! send the body of their answer without an envelope.

use std::collections::VecDeque;
use std::io;
use std::time::{Duration, Instant};

use ureq::Agent;

use super::{Client, Received, invalid};
use crate::flockwave::transport::MESSAGE_LIMIT;
use crate::net::Address;

pub(super) struct OneShot {
    agent: Agent,
    url: String,
    answers: VecDeque<Vec<u8>>,
}

impl OneShot {
    /// Creates a client that waits up to `limit` for each answer.
    pub(super) fn new(address: &Address, path: &str, limit: Duration) -> Self {
        let url = format!("http://{address}{path}");
        Self { agent: agent(limit), url, answers: VecDeque::new() }
    }
}

impl Client for OneShot {
    fn send(&mut self, message: &[u8]) -> io::Result<()> {
        let request = self.agent.post(&self.url).header("Content-Type", "application/json");
        let answer = body(request.send(message))?;
        self.answers.push_back(answer);
        Ok(())
    }

    fn receive(&mut self, until: Instant) -> io::Result<Received> {
        if let Some(answer) = self.answers.pop_front() {
            return Ok(Received::Message(answer));
        }
        // Nothing arrives without a request. Sleep, so that callers don't loop without a pause.
        std::thread::sleep(until.saturating_duration_since(Instant::now()));
        Ok(Received::Silence)
    }
}

/// Creates an agent for HTTP requests with a time limit.
pub(super) fn agent(limit: Duration) -> Agent {
    // Requests to local servers must not go through a proxy from the environment.
    let config = Agent::config_builder().timeout_global(Some(limit)).http_status_as_error(false).proxy(None);
    config.build().into()
}

/// The body of a response, if its status code indicates success.
pub(super) fn body(response: Result<ureq::http::Response<ureq::Body>, ureq::Error>) -> io::Result<Vec<u8>> {
    let mut response = response.map_err(ureq::Error::into_io)?;
    let read = response.body_mut().with_config().limit(MESSAGE_LIMIT as u64 * 2).read_to_vec();
    let body = read.map_err(ureq::Error::into_io)?;
    let status = response.status();
    if status.is_success() {
        return Ok(body);
    }
    let text = String::from_utf8_lossy(&body[..body.len().min(200)]).trim().to_owned();
    Err(invalid(format!("HTTP status {status}: {text}")))
}
