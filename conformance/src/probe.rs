//! Asks a live Flockwave server, and judges what it says.
//!
//! ```text
//!  survey, commands, trials ──▶ session ──▶ tape ──line──▶ checker ──▶ findings
//!                                  ▲          └──line──▶ file
//!                                server
//! ```
//!
//! First comes a *survey*: requests that change nothing, over one connection, then listening for what comes by itself,
//! and, where the caller allows it, *commands* for the UAVs that he names. Then come *trials* of what a server has to
//! bear, each on a connection of its own. All that goes over the wire is written to a *tape* as a line of a recording,
//! and judged as that: [`check`](crate::check) finds the same in the recording later on.
//!
//! Nothing here waits without a limit; a server that is silent, floods, or dies is told of in the findings and notes.
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

/// How long a probe may take that only asks, but for listening.
const TIME_LIMIT: Duration = Duration::from_secs(45);

/// How long a server may take to take a connection, and until it answers the first request.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// How long it waits from one attempt to connect to the next.
const PAUSE: Duration = Duration::from_millis(250);

/// How long an answer is waited for, before the next request is sent; it may still come later.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(2);

/// The same once the server has left so many requests without an answer.
const REDUCED_TIMEOUT: (u32, Duration) = (3, Duration::from_millis(300));

/// How long late answers may take that nobody waits for any more.
const LATE_ANSWER_TIME: Duration = Duration::from_millis(400);

/// How far apart messages are sent, so that each comes in a segment of its own.
const SEND_INTERVAL: Duration = Duration::from_millis(20);

/// How often a connection is made anew after the server has closed it.
const MAX_RECONNECTS: u32 = 20;

/// How many notes are kept.
const MAX_NOTES: usize = 50;

/// How a server is to be probed.
#[derive(Clone, Debug)]
pub struct Options {
    /// How long to listen for what comes by itself.
    pub observe: Duration,
    /// Name and password to log in with.
    pub login: Option<(String, String)>,
    /// The UAVs that commands may be sent to; none, where commands aren't allowed.
    pub uavs: Vec<String>,
    /// How long all of it may take, but for [`observe`](Self::observe).
    pub limit: Duration,
}

impl Options {
    /// To listen so long, log in so, and send commands to these UAVs, within the time that is usual for that.
    pub fn new(observe: Duration, login: Option<(String, String)>, uavs: Vec<String>) -> Self {
        let limit = if uavs.is_empty() { TIME_LIMIT } else { TIME_LIMIT + commands::EXTRA_TIME };
        Self { observe, login, uavs, limit }
    }
}

/// What came of a probe.
#[derive(Debug)]
pub struct Probed {
    /// What was found in all that went over the wire.
    pub result: CaptureResult,
    /// What happened on the way, in order.
    pub notes: Vec<String>,
    /// Why not all could be asked.
    pub failure: Option<String>,
    /// Why the recording isn't whole.
    pub unrecorded: Option<io::Error>,
}

/// Probes a server. What goes over the wire is also written to `record`; `on_progress` hears how many of how many steps are
/// done.
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

/// A probe under way.
struct Probe<'p, 'd> {
    endpoint: &'p Endpoint,
    options: &'p Options,
    tape: Tape<'d>,
    /// The connection of the survey.
    session: Option<Session>,
    connections: usize,
    reconnects: u32,
    requests: u64,
    /// How many requests had no answer in time.
    silences: u32,
    /// The longest that an answer took.
    slowest: Duration,
    /// When all has to be over.
    end: Instant,
    notes: Vec<String>,
    failure: Option<String>,
    /// Whether answers come without an envelope.
    is_bare: bool,
    steps: (usize, usize),
    on_progress: &'p dyn Fn(usize, usize),
}

impl Probe<'_, '_> {
    /// Waits until the server can be reached, and answers.
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
                    self.fail(format!("no connection: {error}"));
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
            self.fail("it answers nothing".to_owned());
        }
        answer.is_some()
    }

    fn finish(mut self) -> Probed {
        self.leave();
        let (result, unrecorded) = self.tape.finish();
        Probed { result, notes: self.notes, failure: self.failure, unrecorded }
    }

    /// A new connection.
    fn open(&mut self, endpoint: Option<&Endpoint>) -> io::Result<Session> {
        self.connections += 1;
        let limit = CONNECT_TIMEOUT.min(self.left()).max(PAUSE);
        Session::open(endpoint.unwrap_or(self.endpoint), self.connections, &mut self.tape, limit)
    }

    /// A connection didn't come about.
    fn refused(&mut self, endpoint: &Endpoint, error: &io::Error, trial: Option<Trial<'_>>) {
        self.tape.refused(&session::name(endpoint, self.connections), &error.to_string(), trial);
    }

    /// The connection of the survey, made anew where the server closed it.
    fn ensure_connected(&mut self) -> bool {
        if self.session.as_ref().is_some_and(|session| !session.is_over()) {
            return true;
        }
        if self.failure.is_some() || self.is_late() {
            return false;
        }
        if self.reconnects >= MAX_RECONNECTS {
            self.fail(format!("it closed the connection {MAX_RECONNECTS} times"));
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

    /// A new connection to a server that may just be starting anew.
    fn reopen(&mut self, endpoint: Option<&Endpoint>) -> Option<Session> {
        let until = Instant::now() + CONNECT_TIMEOUT;
        loop {
            match self.open(endpoint) {
                Ok(session) => return Some(session),
                Err(_) if Instant::now() + PAUSE < until.min(self.end) => thread::sleep(PAUSE),
                Err(error) => {
                    self.refused(endpoint.unwrap_or(self.endpoint), &error, None);
                    self.fail(format!("it can't be reached any more: {error}"));
                    return None;
                }
            }
        }
    }

    /// Ends the connection of the survey, after a while for late answers.
    fn leave(&mut self) {
        let Some(mut session) = self.session.take() else { return };
        let until =
            Instant::now() + if session.is_waiting() { self.answer_timeout() } else { Duration::ZERO };
        if session.is_waiting() {
            session.settle(&mut self.tape, until);
        }
        if session.bare_answers() > 0 && !std::mem::replace(&mut self.is_bare, true) {
            self.note(
                "answers over HTTP come without an envelope, and are judged as if they had one".to_owned(),
            );
        }
        session.close(&mut self.tape);
    }

    /// Asks on the connection of the survey, and waits for the answer. That it comes at all is judged as well.
    #[allow(clippy::needless_pass_by_value)] // bodies are written where they are passed
    fn query(&mut self, body: Value) -> Option<Value> {
        self.query_for_trial(&env_07::RULE, body)
    }

    /// Asks on the connection of the survey to try a rule, and waits for the answer.
    #[allow(clippy::needless_pass_by_value)] // as above
    fn query_for_trial(&mut self, of: &'static FlockwaveRule, body: Value) -> Option<Value> {
        self.request(&of.rule, Request::new("", body))
    }

    /// Makes a request that tries a rule, and waits for the answer.
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

    /// Logs in, where the caller gave a name.
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

    /// Makes an attempt on a connection of its own; whether the next one can be made.
    fn attempt(&mut self, rule: &'static Rule, attempt: &Attempt) -> bool {
        let Attempt { how, endpoint, steps } = attempt;
        if self.is_late() {
            let (done, all) = self.steps;
            self.fail(format!("the time was over: {} trials were not made", all - done));
            return false;
        }
        self.step();
        let trial = Trial { rule, how };
        let session = match endpoint {
            // That there is no such connection is what is tried.
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
        // What comes next would say nothing of a server that is dead already.
        if is_answered || self.is_alive() {
            return true;
        }
        self.fail(format!("it answers nothing any more, after a trial of {}: {how}", rule.id));
        false
    }

    /// Does what an attempt consists of, and waits for all answers.
    fn carry_out(&mut self, session: &mut Session, steps: &[Step], trial: Trial<'_>) {
        let grace = LATE_ANSWER_TIME.max(self.slowest * 4);
        for (at, step) in steps.iter().enumerate() {
            // What goes before has its effect, and its answer, before the next message comes.
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
            if !is_last_answered && last.is_some_and(|id| !session.waits_for(id)) {
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

    /// Whether the server still serves others.
    fn is_alive(&mut self) -> bool {
        self.session = self.reopen(None);
        self.log_in();
        let answer = self.post(&json!({ "type": "SYS-VER" }), None, Instant::now() + ANSWER_TIMEOUT);
        if let Some(session) = self.session.take() {
            session.close(&mut self.tape);
        }
        answer.is_some()
    }

    /// How long an answer is waited for.
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

    /// So many steps are done, whether or not there was something to do in each.
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

/// What every request tries: that it has an answer.
fn plain() -> Trial<'static> {
    Trial { rule: &env_07::RULE.rule, how: "" }
}

/// The trial of a message. One that can't be answered tries nothing by itself.
fn tries<'t>(sent: &Sent, trial: Trial<'t>) -> Option<Trial<'t>> {
    sent.id().is_some().then_some(trial)
}

fn perform(session: &mut Session, tape: &mut Tape<'_>, step: &Step, trial: Trial<'_>) {
    // Then something that went before has no answer, which is enough to know.
    if session.is_over() {
        return;
    }
    match step {
        Step::Send(sent) => session.send(tape, &sent.text, sent.id(), tries(sent, trial)),
        Step::Together(all) if !session.is_stream() => {
            for sent in all {
                session.send(tape, &sent.text, sent.id(), tries(sent, trial));
            }
        }
        Step::Together(all) => {
            let mut bytes = Vec::new();
            for sent in all {
                session.note(tape, &sent.text, sent.id(), tries(sent, trial));
                bytes.extend_from_slice(&sent.text);
                bytes.push(b'\n');
            }
            session.send_raw(tape, &bytes);
        }
        Step::Pieces(sent, count, pause) => {
            session.note(tape, &sent.text, sent.id(), tries(sent, trial));
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
