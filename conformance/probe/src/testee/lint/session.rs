//! A session with a testee that records all received lines.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use serde_json::Value;
use uavspec_model::clock::Clock;

use crate::testee::case::Case;
use crate::testee::link::{Link, Received, remaining_stderr};
use crate::testee::options::{Options, excerpt};
use crate::testee::protocol::{Hello, Response};

/// The first id that is assigned automatically.
const FIRST_ID: i64 = 1_000;

/// The delay between the parts of a line, so that they are sent separately.
const PAUSE: Duration = Duration::from_millis(10);

/// A session with a testee that has sent its hello.
pub(super) struct Session<'o> {
    link: Link,
    options: &'o Options,
    next_id: i64,
    /// The lines received so far.
    pub(super) received: ReceivedResponses,
    /// True if a response didn't come in time.
    pub(super) has_timed_out: bool,
}

/// The received lines, and the responses that may still arrive.
#[derive(Default)]
pub(super) struct ReceivedResponses {
    /// Requests without a response.
    pending: BTreeSet<i64>,
    /// Requests for which a response is optional.
    optional: BTreeSet<i64>,
    /// The received responses.
    responses: BTreeMap<i64, Response>,
    /// The number of `error` responses without an id that may still arrive: one for each line without an id.
    refusals: usize,
    /// The number of hellos that may still arrive.
    hellos_due: usize,
    /// The lines of repeated hellos.
    pub(super) hellos: Vec<Vec<u8>>,
    /// The id of the first response that belongs to no request.
    pub(super) foreign: Option<i64>,
    /// The first id with more than one response.
    pub(super) repeated: Option<i64>,
    /// Lines that are neither a response nor a hello.
    pub(super) strays: Strays,
}

/// Unexpected lines. Only the first few are stored.
#[derive(Default)]
pub(super) struct Strays {
    first: Vec<String>,
    more: usize,
}

impl Strays {
    /// The maximum number of stored lines.
    const MAX_LINES: usize = 5;

    fn push(&mut self, what: String) {
        if self.first.len() < Self::MAX_LINES {
            self.first.push(what);
        } else {
            self.more += 1;
        }
    }

    /// Adds the lines of another session.
    pub(super) fn append(&mut self, others: Self) {
        others.first.into_iter().for_each(|what| self.push(what));
        self.more += others.more;
    }

    /// A description of all lines; `None` if there are none.
    pub(super) fn summary(&self) -> Option<String> {
        let more = if self.more > 0 { format!("; and {} more", self.more) } else { String::new() };
        (!self.first.is_empty()).then(|| self.first.join("; ") + &more)
    }
}

impl<'o> Session<'o> {
    pub(super) fn start(options: &'o Options) -> Result<Self, String> {
        let mut link = Link::open(options, true)?;
        link.introduction(options).map_err(|wrong| format!("no valid hello in a new session: {wrong}"))?;
        let received = ReceivedResponses::default();
        Ok(Self { link, options, next_id: FIRST_ID, received, has_timed_out: false })
    }

    /// Returns an unused id.
    pub(super) fn fresh_id(&mut self) -> i64 {
        self.next_id += 1;
        self.next_id
    }

    /// Returns a request for a case, and its id.
    pub(super) fn request(&mut self, case: &Case) -> (i64, Value) {
        let id = self.fresh_id();
        let mut request = case.request(0);
        request["id"] = id.into();
        (id, request)
    }

    /// Sends a request that must get a response.
    pub(super) fn send(&mut self, id: i64, request: &Value) {
        self.expect(id);
        self.link.send(request.to_string());
    }

    /// Sends a request for a case, and returns its id.
    pub(super) fn send_case(&mut self, case: &Case) -> i64 {
        let (id, request) = self.request(case);
        self.send(id, &request);
        id
    }

    /// Registers a request that is sent by other means.
    pub(super) fn expect(&mut self, id: i64) {
        self.received.pending.insert(id);
    }

    /// Sends each part with a separate write.
    pub(super) fn send_parts<'p>(&self, parts: impl IntoIterator<Item = &'p [u8]>) {
        for part in parts {
            self.link.send_bytes(part.to_vec());
            Clock::real().sleep(PAUSE);
        }
    }

    /// Sends a malformed line. Valid reactions are a response with the id, an error without an id, and no response.
    pub(super) fn send_malformed(&mut self, id: Option<i64>, line: &[u8]) {
        self.received.optional.extend(id);
        self.received.refusals += 1;
        self.link.send_bytes([line, b"\n"].concat());
    }

    /// Requests another hello. Valid reactions are a hello, an error, and no response.
    pub(super) fn send_hello(&mut self) {
        self.received.hellos_due += 1;
        self.received.refusals += 1;
        self.link.send(Hello::request());
    }

    /// Waits until all requests have responses.
    pub(super) fn receive(&mut self) -> Result<(), String> {
        let mut until = self.options.clock.now() + self.options.timeout;
        let (mut stray_bytes, limit) = (0, self.options.stray_limit());
        while !self.is_answered() {
            let wrong = match self.link.receive(until) {
                Received::Line(line) => {
                    // Lines other than responses don't extend the time limit, even if they never end.
                    if self.received.take(&line) {
                        until = self.options.clock.now() + self.options.timeout;
                        stray_bytes = 0;
                    } else {
                        stray_bytes += line.len() + 1;
                    }
                    if self.is_answered() || stray_bytes <= limit && self.options.clock.now() < until {
                        continue;
                    }
                    if stray_bytes > limit {
                        format!(
                            "no response to {} in the first {limit} bytes that were received",
                            self.missing()
                        )
                    } else {
                        self.time_out()
                    }
                }
                Received::Nothing => self.time_out(),
                Received::TooLong => {
                    let what = format!("a line longer than {} bytes", self.options.line_limit);
                    self.received.strays.push(what.clone());
                    what
                }
                Received::Closed => {
                    format!("{}; no response to {}", self.link.ending(until), self.missing())
                }
                Received::Lost(how) => format!("{how}; no response to {}", self.missing()),
            };
            return Err(wrong + &remaining_stderr(&self.link.kill()));
        }
        Ok(())
    }

    /// Records a timeout. Returns a description of the requests without a response.
    fn time_out(&mut self) -> String {
        self.has_timed_out = true;
        format!("no response to {} within {} s", self.missing(), self.options.timeout.as_secs_f32())
    }

    /// Sends a case and waits for its response, which shows that the testee has survived all earlier input.
    pub(super) fn check_alive(&mut self, case: &Case) -> Result<(), String> {
        self.send_case(case);
        self.receive()
    }

    /// Closes the input of the testee, and reads its remaining output.
    pub(super) fn finish(&mut self) -> Result<(), String> {
        let received = &mut self.received;
        let finished = self.link.finish(self.options.timeout, |line| {
            received.take(line);
        });
        finished.map_err(|wrong| wrong + &remaining_stderr(&self.link.kill()))
    }

    /// The response to a request.
    pub(super) fn answer(&self, id: i64) -> Option<&Response> {
        self.received.responses.get(&id)
    }

    /// The requests without a response. If many requests have no response, only the first few are listed.
    pub(super) fn missing(&self) -> String {
        let ids: Vec<String> = self.received.pending.iter().take(3).map(ToString::to_string).collect();
        let more = self.received.pending.len() - ids.len();
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        format!("request{} {}{more}", if self.received.pending.len() == 1 { "" } else { "s" }, ids.join(", "))
    }

    /// True if all requests have responses.
    pub(super) fn is_answered(&self) -> bool {
        self.received.pending.is_empty()
    }

    /// True if any request got a response.
    pub(super) fn has_response(&self) -> bool {
        !self.received.responses.is_empty()
    }
}

impl ReceivedResponses {
    /// Processes a line. Returns true if the line is a required response.
    fn take(&mut self, line: &[u8]) -> bool {
        match Response::read(line.trim_ascii()) {
            Ok((id, answer)) => {
                let is_awaited = self.pending.remove(&id);
                if is_awaited || self.optional.remove(&id) {
                    self.responses.insert(id, answer);
                } else if self.responses.contains_key(&id) {
                    self.repeated.get_or_insert(id);
                } else {
                    self.foreign.get_or_insert(id);
                }
                return is_awaited;
            }
            Err(_) if self.hellos_due > 0 && Hello::read(line).is_ok() => {
                self.hellos_due -= 1;
                self.hellos.push(line.to_vec());
            }
            Err(_) if self.refusals > 0 && is_refusal(line) => self.refusals -= 1,
            Err(wrong) => self.strays.push(format!("{wrong}: {}", excerpt(line))),
        }
        false
    }
}

/// True if a line is a valid response to a line that has no id.
fn is_refusal(line: &[u8]) -> bool {
    serde_json::from_slice(line).is_ok_and(|value: Value| {
        value.get("id").is_none_or(Value::is_null)
            && (value.get("error").is_some() || value["unsupported"] == true)
    })
}
