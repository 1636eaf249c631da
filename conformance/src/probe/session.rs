//! A connection of a probe: all that goes over it is recorded.

use std::collections::BTreeSet;
use std::io::{self, ErrorKind};
use std::time::{Duration, Instant};

use serde_json::value::RawValue;
use serde_json::{Value, json};

use super::tape::Tape;
use crate::flockwave::record::{Direction, Trial};
use crate::flockwave::transport::client::{Client, Received, connect};
use crate::flockwave::transport::endpoint::Endpoint;

/// How many ids of requests without an answer are kept.
const MAX_WAITING: usize = 1_000;

/// What the recording says where the server closed a connection.
const CLOSED: &str = "eof";

/// How long is listened for what a server said before it closed the connection.
const DRAIN_TIMEOUT: Duration = Duration::from_millis(200);

/// A connection.
pub(super) struct Session {
    name: String,
    /// Whether each message is a request of HTTP, which goes wrong for itself.
    is_one_shot: bool,
    is_stream: bool,
    client: Box<dyn Client>,
    waiting: BTreeSet<String>,
    /// The last request.
    last_request: Option<String>,
    /// How many answers came without an envelope.
    bare: u64,
    is_over: bool,
}

impl Session {
    /// Connects, under a name that no other connection has.
    pub(super) fn open(
        endpoint: &Endpoint,
        number: usize,
        tape: &mut Tape<'_>,
        limit: Duration,
    ) -> io::Result<Self> {
        let client = connect(endpoint, Instant::now() + limit)?;
        let name = name(endpoint, number);
        tape.connected(&name, &endpoint.to_string());
        let is_one_shot = matches!(endpoint, Endpoint::Http { .. });
        let is_stream = matches!(endpoint, Endpoint::Tcp(_));
        Ok(Self {
            name,
            is_one_shot,
            is_stream,
            client,
            waiting: BTreeSet::new(),
            last_request: None,
            bare: 0,
            is_over: false,
        })
    }

    /// How many answers came without an envelope.
    pub(super) fn bare_answers(&self) -> u64 {
        self.bare
    }

    /// Whether bytes make a stream, in which messages may come in pieces.
    pub(super) fn is_stream(&self) -> bool {
        self.is_stream
    }

    /// Whether nothing more can go over it.
    pub(super) fn is_over(&self) -> bool {
        self.is_over
    }

    /// Whether a request has no answer yet.
    pub(super) fn is_waiting(&self) -> bool {
        !self.waiting.is_empty()
    }

    /// Whether this request has no answer yet.
    pub(super) fn waits_for(&self, id: &str) -> bool {
        self.waiting.contains(id)
    }

    /// Sends a message, or what is none. Where it has an id by which an answer can be known, that is waited for.
    pub(super) fn send(
        &mut self,
        tape: &mut Tape<'_>,
        text: &[u8],
        id: Option<&str>,
        trial: Option<Trial<'_>>,
    ) {
        self.note(tape, text, id, trial);
        match self.client.send(text) {
            Err(error) if self.is_one_shot && error.kind() == ErrorKind::InvalidData => {
                tape.failed(&self.name, &error.to_string());
                self.waiting.retain(|waiting| Some(waiting.as_str()) != id);
            }
            sent => {
                self.end_with(tape, sent);
                self.last_request = id.map(str::to_owned);
            }
        }
    }

    /// Notes a message that is sent in another way than all others.
    pub(super) fn note(
        &mut self,
        tape: &mut Tape<'_>,
        text: &[u8],
        id: Option<&str>,
        trial: Option<Trial<'_>>,
    ) {
        tape.message(&self.name, Direction::Out, text, trial);
        if let Some(id) = id.filter(|_| self.waiting.len() < MAX_WAITING) {
            self.waiting.insert(id.to_owned());
        }
    }

    /// Sends bytes as they are.
    pub(super) fn send_raw(&mut self, tape: &mut Tape<'_>, bytes: &[u8]) {
        let sent = self.client.send_raw(bytes);
        self.end_with(tape, sent);
    }

    /// Waits for the next message that is JSON.
    pub(super) fn receive(&mut self, tape: &mut Tape<'_>, until: Instant) -> Option<Value> {
        while !self.is_over {
            match self.client.receive(until) {
                Ok(Received::Message(bytes)) => match self.enveloped(bytes) {
                    Ok(bytes) => {
                        tape.message(&self.name, Direction::In, &bytes, None);
                        if let Ok(message) = serde_json::from_slice::<Value>(&bytes) {
                            self.take(tape, &message);
                            return Some(message);
                        }
                    }
                    Err(bytes) => tape.failed(&self.name, &String::from_utf8_lossy(&bytes)),
                },
                Ok(Received::TooLong) => tape.too_long(&self.name),
                Ok(Received::Silence) => return None,
                Ok(Received::End) => self.over(tape, CLOSED),
                Err(error) => self.fail(tape, &error),
            }
            if Instant::now() >= until {
                return None;
            }
        }
        None
    }

    /// Listens until all requests have their answers, or the time is over.
    pub(super) fn settle(&mut self, tape: &mut Tape<'_>, until: Instant) {
        while self.is_waiting() && Instant::now() < until && self.receive(tape, until).is_some() {}
    }

    /// Waits for the answer to a request.
    pub(super) fn answer(&mut self, tape: &mut Tape<'_>, id: &str, until: Instant) -> Option<Value> {
        self.find(tape, until, |message| message["refs"] == id)
    }

    /// Waits for a message that is wanted.
    pub(super) fn find(
        &mut self,
        tape: &mut Tape<'_>,
        until: Instant,
        is_wanted: impl Fn(&Value) -> bool,
    ) -> Option<Value> {
        while let Some(message) = self.receive(tape, until) {
            if is_wanted(&message) {
                return Some(message);
            }
            // Who says enough else must not keep anybody waiting.
            if Instant::now() >= until {
                break;
            }
        }
        None
    }

    /// Ends the connection.
    pub(super) fn close(mut self, tape: &mut Tape<'_>) {
        self.over(tape, "client");
    }

    /// Over HTTP, servers may answer with the body alone, as it is clear what it answers; the specification says nothing
    /// of this transport. Such a body gets the envelope that goes without saying. Where there is none, as what it answers
    /// has no id, it is an error.
    fn enveloped(&mut self, bytes: Vec<u8>) -> Result<Vec<u8>, Vec<u8>> {
        let Some(body) = bare(&bytes).filter(|_| self.is_one_shot) else { return Ok(bytes) };
        let Some(last_request) = &self.last_request else { return Err(bytes) };
        self.bare += 1;
        let (id, refs) = (format!("bare-{}", self.bare), Value::from(last_request.as_str()));
        Ok(format!(r#"{{"$fw.version":"1.0","id":"{id}","refs":{refs},"body":{}}}"#, body.get()).into_bytes())
    }

    /// What comes in answers requests; and the server may ask whether anybody is there.
    fn take(&mut self, tape: &mut Tape<'_>, message: &Value) {
        if let Some(refs) = message["refs"].as_str() {
            self.waiting.remove(refs);
        } else if message["body"]["type"] == "SYS-PING"
            && let Some(id) = message["id"].as_str()
        {
            let answer = json!({
                "$fw.version": "1.0", "id": format!("re-{}", short(id)), "refs": id, "body": { "type": "ACK-ACK" },
            });
            self.send(tape, answer.to_string().as_bytes(), None, None);
        }
    }

    fn end_with(&mut self, tape: &mut Tape<'_>, sent: io::Result<()>) {
        let Err(error) = sent else { return };
        if is_end(&error) {
            // What was said before stays said.
            let until = Instant::now() + DRAIN_TIMEOUT;
            while self.receive(tape, until).is_some() {}
            self.over(tape, CLOSED);
        } else {
            self.fail(tape, &error);
        }
    }

    fn fail(&mut self, tape: &mut Tape<'_>, error: &io::Error) {
        if is_end(error) { self.over(tape, CLOSED) } else { self.over(tape, &error.to_string()) }
    }

    fn over(&mut self, tape: &mut Tape<'_>, why: &str) {
        if !std::mem::replace(&mut self.is_over, true) {
            tape.closed(&self.name, why);
        }
    }
}

/// What a connection is called: after its transport, by which rules know whether messages keep their order.
pub(super) fn name(endpoint: &Endpoint, number: usize) -> String {
    format!("{}#{number}", endpoint.scheme())
}

/// A body without an envelope.
fn bare(bytes: &[u8]) -> Option<&RawValue> {
    let body: &RawValue = serde_json::from_slice(bytes).ok()?;
    let read: Value = serde_json::from_str(body.get()).ok()?;
    (read["type"].is_string() && read.get("$fw.version").is_none()).then_some(body)
}

/// Whether the server closed the connection, with what was on its way to it.
fn is_end(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::BrokenPipe
            | ErrorKind::ConnectionReset
            | ErrorKind::ConnectionAborted
            | ErrorKind::NotConnected
            | ErrorKind::UnexpectedEof
    )
}

fn short(id: &str) -> String {
    id.chars().take(30).collect()
}
