//! HTTP one-shots: each message is a POST, and the answer comes in its response. What comes by itself later, nobody
//! hears.
//!
//! The specification doesn't know this transport. The body of the response is handed on as it came: some servers put
//! the body of their answer into it without its envelope.

use std::collections::VecDeque;
use std::io;
use std::time::{Duration, Instant};

use ureq::Agent;

use super::{Client, Received, odd};
use crate::flockwave::transport::MESSAGE_LIMIT;
use crate::net::Address;

pub(super) struct OneShot {
    agent: Agent,
    url: String,
    answers: VecDeque<Vec<u8>>,
}

impl OneShot {
    /// A client of a server that may take so long for an answer.
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
        // Nothing can come without a request, but those who wait for a time shall not be called all the time.
        std::thread::sleep(until.saturating_duration_since(Instant::now()));
        Ok(Received::Silence)
    }
}

/// What sends requests of HTTP, each within a time.
pub(super) fn agent(limit: Duration) -> Agent {
    // Where the environment names a proxy, a server in the same room isn't reached through it.
    let config = Agent::config_builder().timeout_global(Some(limit)).http_status_as_error(false).proxy(None);
    config.build().into()
}

/// The body of a response, where the status says that it is one.
pub(super) fn body(response: Result<ureq::http::Response<ureq::Body>, ureq::Error>) -> io::Result<Vec<u8>> {
    let mut response = response.map_err(ureq::Error::into_io)?;
    let read = response.body_mut().with_config().limit(MESSAGE_LIMIT as u64 * 2).read_to_vec();
    let body = read.map_err(ureq::Error::into_io)?;
    let status = response.status();
    if status.is_success() {
        return Ok(body);
    }
    let text = String::from_utf8_lossy(&body[..body.len().min(200)]).trim().to_owned();
    Err(odd(format!("HTTP status {status}: {text}")))
}
