//! Sends requests to a live Flockwave server, and checks the session.
//!
//! ```text
//!  survey, commands, trials ──▶ session ──▶ tape ──line──▶ checker ──▶ findings
//!                                  ▲          └──line──▶ file
//!                                server
//! ```
//!
//! A probe starts with a *survey* over one connection: requests that change nothing, and a period of listening for
//! notifications. If the caller allows it, *commands* for the named UAVs follow. Then each *trial* uses a separate
//! connection to test how the server handles unusual input. All messages are written to a *tape* as lines of a recorded
//! session. The checker reads these lines, so a later [`check`](crate::check) of the recording returns the same
//! findings.
//!
//! All waiting times are limited. Findings and notes report servers that don't respond, flood the client, or crash.
//!
//! ```
//! use std::time::Duration;
//!
//! use uavspec_conformance::definitions::Definitions;
//! use uavspec_conformance::probe::{Options, probe};
//! use uavspec_conformance::serve::{self, Server, Transport};
//!
//! let address = "127.0.0.1:0".parse().unwrap();
//! let server = Server::start(serve::Options::default(), &[(Transport::Tcp, address)])?;
//! let endpoint = server.listening()[0].to_string().parse().unwrap();
//! let options = Options::new(Duration::from_millis(100), None, Vec::new());
//! let probed = probe(&endpoint, &options, &Definitions::built_in(), None, &|_, _| {});
//! assert_eq!(probed.failure, None);
//! assert_eq!(probed.result.findings.groups().count(), 0);
//! # Ok::<(), std::io::Error>(())
//! ```

mod commands;
mod session;
mod survey;
mod tape;

use std::io::{self, Write};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use self::session::Session;
use self::tape::Tape;
use crate::check::CaptureResult;
use crate::definitions::Definitions;
use crate::flockwave::record::Trial;
use crate::flockwave::transport::endpoint::Endpoint;
use crate::json::base64;
use crate::model::Rule;
use crate::rules::flockwave::trial::{self, Attempt, Request, Sent, Step};
use crate::rules::flockwave::{FlockwaveRule, env_07, sio_01, udp_02};

/// The time limit of a probe without commands, excluding the listening period.
const TIME_LIMIT: Duration = Duration::from_secs(45);

/// The time limit for connecting, and for the answer to the first request.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// The delay between attempts to connect.
const PAUSE: Duration = Duration::from_millis(250);

/// The timeout of a request. After the timeout, the next request is sent, but the answer may still arrive.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(2);

/// The number of unanswered requests after which a reduced timeout applies, and the reduced timeout.
const REDUCED_TIMEOUT: (u32, Duration) = (3, Duration::from_millis(300));

/// The time limit for late answers.
const LATE_ANSWER_TIME: Duration = Duration::from_millis(400);

/// The delay between messages. The delay ensures that each message is sent in a separate segment.
const SEND_INTERVAL: Duration = Duration::from_millis(20);

/// The maximum number of reconnections to a server that closes its connections.
const MAX_RECONNECTS: u32 = 20;

/// The maximum number of notes.
const MAX_NOTES: usize = 50;

/// Options of a probe.
#[derive(Clone, Debug)]
pub struct Options {
    /// The time to listen for notifications.
    pub observe: Duration,
    /// Name and password for the login.
    pub login: Option<(String, String)>,
    /// The UAVs that may receive commands; empty if commands aren't allowed.
    pub uavs: Vec<String>,
    /// The time limit of the probe, excluding [`observe`](Self::observe).
    pub limit: Duration,
}

impl Options {
    /// Options with the default time limit.
    pub fn new(observe: Duration, login: Option<(String, String)>, uavs: Vec<String>) -> Self {
        let limit = if uavs.is_empty() { TIME_LIMIT } else { TIME_LIMIT + commands::EXTRA_TIME };
        Self { observe, login, uavs, limit }
    }
}

/// The result of a probe.
#[derive(Debug)]
pub struct Probed {
    /// The findings in the session.
    pub result: CaptureResult,
    /// Notable events during the probe, in order.
    pub notes: Vec<String>,
    /// The reason why the probe ended early.
    pub failure: Option<String>,
    /// The reason why the recording is incomplete.
    pub unrecorded: Option<io::Error>,
}

/// Probes a server. The session is also written to `record`. `on_progress` receives the number of finished steps and
/// their total.
pub fn probe<'d>(
    endpoint: &Endpoint,
    options: &Options,
    definitions: &'d Definitions,
    record: Option<Box<dyn Write + 'd>>,
    on_progress: &dyn Fn(usize, usize),
) -> Probed {
    let attempts = trial::attempts(endpoint);
    let commands = if options.uavs.is_empty() { 0 } else { commands::STEPS };
    let mut probe = Probe {
        endpoint,
        options,
        tape: Tape::new(definitions, record),
        session: None,
        connections: 0,
        reconnects: 0,
        requests: 0,
        silences: 0,
        slowest: Duration::ZERO,
        end: Instant::now() + options.limit + options.observe,
        notes: Vec::new(),
        failure: None,
        is_bare: false,
        steps: (0, survey::STEPS + commands + attempts.len()),
        on_progress,
    };
    if probe.begin() {
        probe.survey();
        probe.leave();
        probe.reset_steps(survey::STEPS + commands);
        for (rule, attempt) in &attempts {
            if probe.failure.is_some() || !probe.attempt(rule, attempt) {
                break;
            }
        }
    }
    probe.finish()
}

/// The state of a probe.
struct Probe<'p, 'd> {
    endpoint: &'p Endpoint,
    options: &'p Options,
    tape: Tape<'d>,
    /// The connection used for the survey.
    session: Option<Session>,
    connections: usize,
    reconnects: u32,
    requests: u64,
    /// The number of requests that weren't answered in time.
    silences: u32,
    /// The longest time that the server has taken to answer.
    slowest: Duration,
    /// The time limit of the probe.
    end: Instant,
    notes: Vec<String>,
    failure: Option<String>,
    /// True if answers have no envelope.
    is_bare: bool,
    steps: (usize, usize),
    on_progress: &'p dyn Fn(usize, usize),
}

impl Probe<'_, '_> {
    /// Connects to the server, and waits for its first answer.
    fn begin(&mut self) -> bool {
        let until = Instant::now() + CONNECT_TIMEOUT;
        loop {
            match self.open(None) {
                Ok(session) => {
                    self.session = Some(session);
                    break;
                }
                Err(error) if Instant::now() + PAUSE >= until => {
                    self.refused(self.endpoint, &error, None);
                    self.fail(format!("can't connect: {error}"));
                    return false;
                }
                Err(_) => thread::sleep(PAUSE),
            }
        }
        let tried = match self.endpoint {
            Endpoint::Udp(_) => &udp_02::RULE,
            Endpoint::SocketIo { .. } => &sio_01::RULE,
            Endpoint::Tcp(_) | Endpoint::Http { .. } => &env_07::RULE,
        };
        let trial = Some(Trial { rule: &tried.rule, how: "" });
        let until = until.max(Instant::now() + ANSWER_TIMEOUT);
        let answer = self.post(&json!({ "type": "SYS-VER" }), trial, until);
        if answer.is_none() {
            self.fail("the server doesn't answer".to_owned());
        }
        answer.is_some()
    }

    fn finish(mut self) -> Probed {
        self.leave();
        let (result, unrecorded) = self.tape.finish();
        Probed { result, notes: self.notes, failure: self.failure, unrecorded }
    }

    /// Opens a new connection.
    fn open(&mut self, endpoint: Option<&Endpoint>) -> io::Result<Session> {
        self.connections += 1;
        let limit = CONNECT_TIMEOUT.min(self.left()).max(PAUSE);
        Session::open(endpoint.unwrap_or(self.endpoint), self.connections, &mut self.tape, limit)
    }

    /// Records that a connection was refused.
    fn refused(&mut self, endpoint: &Endpoint, error: &io::Error, trial: Option<Trial<'_>>) {
        self.tape.refused(&session::name(endpoint, self.connections), &error.to_string(), trial);
    }

    /// Makes sure that the survey has an open connection. Reconnects if the server closed it.
    fn ensure_connected(&mut self) -> bool {
        if self.session.as_ref().is_some_and(|session| !session.is_over()) {
            return true;
        }
        if self.failure.is_some() || self.is_late() {
            return false;
        }
        if self.reconnects >= MAX_RECONNECTS {
            self.fail(format!("the server closed the connection {MAX_RECONNECTS} times"));
            return false;
        }
        self.reconnects += 1;
        self.session = self.reopen(None);
        if self.session.is_some() {
            self.note(format!(
                "the server closed connection {}; the probe connected again",
                self.connections - 1
            ));
            self.log_in();
        }
        self.session.is_some()
    }

    /// Opens a new connection to a server that may be restarting.
    fn reopen(&mut self, endpoint: Option<&Endpoint>) -> Option<Session> {
        let until = Instant::now() + CONNECT_TIMEOUT;
        loop {
            match self.open(endpoint) {
                Ok(session) => return Some(session),
                Err(_) if Instant::now() + PAUSE < until.min(self.end) => thread::sleep(PAUSE),
                Err(error) => {
                    self.refused(endpoint.unwrap_or(self.endpoint), &error, None);
                    self.fail(format!("can't reconnect: {error}"));
                    return None;
                }
            }
        }
    }

    /// Closes the survey's connection after waiting for late answers.
    fn leave(&mut self) {
        let Some(mut session) = self.session.take() else { return };
        let until =
            Instant::now() + if session.is_waiting() { self.answer_timeout() } else { Duration::ZERO };
        if session.is_waiting() {
            session.settle(&mut self.tape, until);
        }
        if session.bare_answers() > 0 && !std::mem::replace(&mut self.is_bare, true) {
            self.note("HTTP responses have no envelope; uavspec adds one before checking them".to_owned());
        }
        session.close(&mut self.tape);
    }

    /// Sends a request on the survey's connection, and waits for the answer. A missing answer violates a rule.
    #[allow(clippy::needless_pass_by_value)] // callers build the body in the call
    fn query(&mut self, body: Value) -> Option<Value> {
        self.query_for_trial(&env_07::RULE, body)
    }

    /// Like [`query`](Self::query), for a request that tests a rule.
    #[allow(clippy::needless_pass_by_value)] // as above
    fn query_for_trial(&mut self, rule: &'static FlockwaveRule, body: Value) -> Option<Value> {
        self.request(&rule.rule, Request::new("", body))
    }

    /// Sends a request that tests a rule, and waits for the answer.
    fn request(&mut self, rule: &'static Rule, request: Request) -> Option<Value> {
        self.step();
        if self.is_late() || !self.ensure_connected() {
            return None;
        }
        let Request { how, body, member, is_repeated } = request;
        let (id, sent_at) = (self.next_id(), Instant::now());
        let until = sent_at + self.answer_timeout();
        let mut message = json!({ "$fw.version": "1.0", "id": id });
        if let Some((key, value)) = member {
            message[key] = value;
        }
        message["body"] = body;
        if is_repeated {
            self.post_message(&id, &message, Some(plain()), until)?;
        }
        let answer = self.post_message(&id, &message, Some(Trial { rule, how }), until);
        match answer {
            Some(_) => self.slowest = self.slowest.max(sent_at.elapsed()),
            None => self.silences += 1,
        }
        answer
    }

    /// Sends a request, and waits for its answer.
    fn post(&mut self, body: &Value, trial: Option<Trial<'_>>, until: Instant) -> Option<Value> {
        let id = self.next_id();
        let message = json!({ "$fw.version": "1.0", "id": id, "body": body });
        self.post_message(&id, &message, trial, until)
    }

    fn post_message(
        &mut self,
        id: &str,
        message: &Value,
        trial: Option<Trial<'_>>,
        until: Instant,
    ) -> Option<Value> {
        let session = self.session.as_mut()?;
        session.send(&mut self.tape, message.to_string().as_bytes(), Some(id), trial);
        session.answer(&mut self.tape, id, until)
    }

    fn next_id(&mut self) -> String {
        self.requests += 1;
        format!("probe-{}", self.requests)
    }

    /// Logs in, if the caller provided a name.
    fn log_in(&mut self) {
        let Some((name, password)) = &self.options.login else { return };
        let data = base64::encode(format!("{name}:{password}").as_bytes());
        let until = Instant::now() + ANSWER_TIMEOUT;
        let answer =
            self.post(&json!({ "type": "AUTH-REQ", "method": "basic", "data": data }), Some(plain()), until);
        if answer.is_none_or(|answer| answer["body"]["result"] != true) {
            self.note("the login failed".to_owned());
        }
    }

    /// Runs an attempt on a separate connection. Returns true if the probe can continue.
    fn attempt(&mut self, rule: &'static Rule, attempt: &Attempt) -> bool {
        let Attempt { how, endpoint, steps } = attempt;
        if self.is_late() {
            let (done, all) = self.steps;
            self.fail(format!("time limit reached: {} trials were not run", all - done));
            return false;
        }
        self.step();
        let trial = Trial { rule, how };
        let session = match endpoint {
            // Some trials test whether the server accepts a connection to a different endpoint.
            Some(other) => match self.open(Some(other)) {
                Ok(session) => Some(session),
                Err(error) => {
                    self.refused(other, &error, Some(trial));
                    return true;
                }
            },
            None => self.reopen(None),
        };
        let Some(session) = session else { return false };
        self.session = Some(session);
        self.log_in();
        let Some(mut session) = self.session.take() else { return false };
        self.carry_out(&mut session, steps, trial);
        let is_answered = !session.is_waiting();
        session.close(&mut self.tape);
        // If the server has crashed, further trials are meaningless.
        if is_answered || self.is_alive() {
            return true;
        }
        self.fail(format!("the server stopped answering after a trial for {}: {how}", rule.id));
        false
    }

    /// Performs the steps of an attempt, and waits for all answers.
    fn carry_out(&mut self, session: &mut Session, steps: &[Step], trial: Trial<'_>) {
        let grace = LATE_ANSWER_TIME.max(self.slowest * 4);
        for (at, step) in steps.iter().enumerate() {
            // The server should process and answer each step before the next message arrives.
            match at {
                0 => {}
                _ if session.is_waiting() => session.settle(&mut self.tape, Instant::now() + grace),
                _ => thread::sleep(SEND_INTERVAL),
            }
            perform(session, &mut self.tape, step, trial);
        }
        let last = steps.last().and_then(Step::id);
        let mut until = Instant::now() + self.answer_timeout();
        let mut is_last_answered = false;
        while session.is_waiting() && session.receive(&mut self.tape, until).is_some() {
            if !is_last_answered && last.is_some_and(|id| !session.awaits(id)) {
                is_last_answered = true;
                until = until.min(Instant::now() + grace);
            }
            if Instant::now() >= until {
                break;
            }
        }
        if session.is_waiting() && !session.is_over() && !is_last_answered {
            self.silences += 1;
        }
    }

    /// True if the server answers on a new connection.
    fn is_alive(&mut self) -> bool {
        self.session = self.reopen(None);
        self.log_in();
        let answer = self.post(&json!({ "type": "SYS-VER" }), None, Instant::now() + ANSWER_TIMEOUT);
        if let Some(session) = self.session.take() {
            session.close(&mut self.tape);
        }
        answer.is_some()
    }

    /// The time limit for an answer.
    fn answer_timeout(&self) -> Duration {
        let usual = if self.silences < REDUCED_TIMEOUT.0 {
            ANSWER_TIMEOUT
        } else {
            REDUCED_TIMEOUT.1.max(self.slowest * 4)
        };
        usual.min(ANSWER_TIMEOUT).min(self.left())
    }

    fn left(&self) -> Duration {
        self.end.saturating_duration_since(Instant::now())
    }

    fn is_late(&self) -> bool {
        self.left().is_zero()
    }

    fn step(&mut self) {
        self.steps.0 = (self.steps.0 + 1).min(self.steps.1);
        (self.on_progress)(self.steps.0, self.steps.1);
    }

    /// Sets the number of finished steps, since some steps may have been skipped.
    fn reset_steps(&mut self, done: usize) {
        self.steps.0 = done;
    }

    fn note(&mut self, text: String) {
        if self.notes.len() < MAX_NOTES {
            self.notes.push(text);
        }
    }

    fn fail(&mut self, why: String) {
        self.failure.get_or_insert(why);
    }
}

/// The default trial, which tests only that the server answers a request.
fn plain() -> Trial<'static> {
    Trial { rule: &env_07::RULE.rule, how: "" }
}

/// The trial that is recorded with a message. A message without an id can't be answered, so it tests nothing by itself.
fn trial_of<'t>(sent: &Sent, trial: Trial<'t>) -> Option<Trial<'t>> {
    sent.id().is_some().then_some(trial)
}

fn perform(session: &mut Session, tape: &mut Tape<'_>, step: &Step, trial: Trial<'_>) {
    // A finding already reports that an earlier message has no answer.
    if session.is_over() {
        return;
    }
    match step {
        Step::Send(sent) => session.send(tape, &sent.text, sent.id(), trial_of(sent, trial)),
        Step::Together(all) if !session.is_stream() => {
            for sent in all {
                session.send(tape, &sent.text, sent.id(), trial_of(sent, trial));
            }
        }
        Step::Together(all) => {
            let mut bytes = Vec::new();
            for sent in all {
                session.note(tape, &sent.text, sent.id(), trial_of(sent, trial));
                bytes.extend_from_slice(&sent.text);
                bytes.push(b'\n');
            }
            session.send_raw(tape, &bytes);
        }
        Step::Pieces(sent, count, pause) => {
            session.note(tape, &sent.text, sent.id(), trial_of(sent, trial));
            let line = [&sent.text[..], b"\n"].concat();
            for (at, piece) in line.chunks(line.len().div_ceil(*count)).enumerate() {
                if at > 0 {
                    thread::sleep(*pause);
                }
                session.send_raw(tape, piece);
            }
        }
        Step::Packet(text) => {
            session.note(tape, text.as_bytes(), None, None);
            session.send_raw(tape, text.as_bytes());
        }
    }
}
