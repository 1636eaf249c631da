//! Sends requests to a live Flockwave server, and checks the session. The results are a recorded session and findings.
//! [`testee`] checks codecs in other programs.
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
//! session. The checker reads these lines, so a later [`check`](uavspec_check) of the recording returns the same
//! findings.
//!
//! All waiting times are limited. Findings and notes report servers that don't respond, flood the client, or crash.
//!
//! ```
//! use std::time::Duration;
//!
//! use uavspec_rules::definitions::Definitions;
//! use uavspec_probe::{Options, probe};
//! use uavspec_serve::{Server, Transport};
//!
//! let address = "127.0.0.1:0".parse().unwrap();
//! let server = Server::start(uavspec_serve::Options::default(), &[(Transport::Tcp, address)])?;
//! let endpoint = server.listening()[0].to_string().parse().unwrap();
//! let options = Options::new(Duration::from_millis(100), None, Vec::new());
//! let probed = probe(&endpoint, &options, &Definitions::built_in(), None, &|_, _| {});
//! assert_eq!(probed.failure, None);
//! assert_eq!(probed.result.findings.groups().count(), 0);
//! # Ok::<(), std::io::Error>(())
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod limits;
pub mod self_test;
pub mod testee;

mod altitude;
mod commanded;
mod commands;
mod connections;
mod coverage;
mod landing;
mod on_crash;
mod options;
mod selection;
mod session;
mod stop;
mod survey;
mod tape;
mod trials;
mod undoing;

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use uavspec_check::CaptureResult;
use uavspec_flockwave::record::Trial;
use uavspec_flockwave::transport::access::Access;
use uavspec_flockwave::transport::client::Network;
use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_flockwave::transport::secrets::Secrets;
use uavspec_model::Rule;
use uavspec_model::clock::Clock;
use uavspec_model::json::base64;
use uavspec_model::text::{plural, shown};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::trial::{AFTER_REQUEST, Attempt, Request};
use uavspec_rules::flockwave::{BEFORE_LOGIN, FlockwaveRule, env_07, sio_01, udp_02};

use self::altitude::Flight;
use self::connections::PAUSE;
use self::coverage::Coverage;
pub use self::coverage::RequestType;
pub use self::options::Options;
pub use self::selection::Selection;
use self::session::Session;
pub use self::stop::Stop;
use self::tape::Tape;
use crate::limits::MAX_NOTES;

/// The time limit for connecting. Refused connections are retried within this limit, because the server may be
/// starting.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// The minimum time to wait for an answer before the next request is sent. The answer may still arrive later: a request
/// counts as unanswered only after [`Options::timeout`].
const PACE: Duration = Duration::from_secs(2);

/// The reduced pace, and the number of unanswered requests after which it applies.
const REDUCED_PACE: (u32, Duration) = (3, Duration::from_millis(300));

/// The maximum number of times that a request is sent again over UDP, because the request or its answer may be lost,
/// and the minimum interval between these attempts.
const MAX_RESENDS: u32 = 3;
const RESEND_INTERVAL: Duration = Duration::from_millis(100);

/// The maximum number of panics after which the probe still tries to land UAVs.
const MAX_PANICS: u32 = 3;

/// The reason for requests that were not sent because the time limit was reached.
const OUT_OF_TIME: &str = "out of time";

/// The reason for requests that were not sent because the probe was asked to stop.
const INTERRUPTED: &str = "interrupted";

/// The result of a probe.
#[derive(Debug)]
pub struct Probed {
    /// The findings in the session.
    pub result: CaptureResult,
    /// All request types of the definitions, sorted by name.
    pub requests: Vec<RequestType>,
    /// Notable events during the probe, in order.
    pub notes: Vec<String>,
    /// The reason why the server couldn't be probed.
    pub failure: Option<String>,
    /// The reason why the probe ended early.
    pub cut_short: Option<String>,
    /// The reason why the probe left out a part.
    pub left_out: Option<String>,
    /// The reason why the recording is incomplete.
    pub unrecorded: Option<io::Error>,
    /// The UAVs that received commands and may be unsafe, with the reason.
    pub danger: Option<String>,
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
    probe_through(None, endpoint, options, definitions, record, on_progress)
}

/// Like [`probe`], over a network in memory. In simulated time, the probe then takes no real time.
pub fn probe_on<'d>(
    network: &dyn Network,
    endpoint: &Endpoint,
    options: &Options,
    definitions: &'d Definitions,
    record: Option<Box<dyn Write + 'd>>,
) -> Probed {
    probe_through(Some(network), endpoint, options, definitions, record, &|_, _| {})
}

fn probe_through<'d>(
    network: Option<&dyn Network>,
    endpoint: &Endpoint,
    options: &Options,
    definitions: &'d Definitions,
    record: Option<Box<dyn Write + 'd>>,
    on_progress: &dyn Fn(usize, usize),
) -> Probed {
    let attempts = trials::selected(endpoint, &options.selection);
    let access = Access::new(options.login.clone(), options.trust.clone());
    let secrets = access.secrets(endpoint.path());
    let commands = if options.uavs.is_empty() { 0 } else { commands::STEPS };
    let mut probe = Probe {
        endpoint,
        options,
        stop: options.stop.clone(),
        access,
        network,
        clock: options.clock.clone(),
        tape: Tape::new(definitions, options.clock.clone(), secrets.clone(), record),
        secrets,
        coverage: Coverage::new(definitions),
        session: None,
        witness: None,
        lingering: Vec::new(),
        connections: 0,
        reconnects: 0,
        requests: 0,
        silences: 0,
        stops: 0,
        is_refused: false,
        slowest: Duration::ZERO,
        end: options.clock.now() + options.limit + options.observe,
        flights: BTreeMap::new(),
        danger: None,
        landing_end: None,
        notes: Vec::new(),
        failure: None,
        cut_short: None,
        left_out: None,
        unsent: (0, 0),
        unknown_type: None,
        has_login: options.login.is_some(),
        is_ending: false,
        is_exclusive: false,
        is_bare: false,
        has_survey: false,
        steps: (0, survey::STEPS + commands + attempts.len()),
        on_progress,
    };
    probe.coverage.exclude(options);
    probe.guard(|probe| {
        if probe.begin() {
            probe.survey();
            probe.has_survey = true;
        }
    });
    // Nothing may prevent the landing.
    for _ in 0..MAX_PANICS {
        if probe.guard(Probe::make_safe) {
            break;
        }
    }
    probe.guard(|probe| probe.complete(&attempts, survey::STEPS + commands));
    probe.finish()
}

/// The state of a probe.
#[allow(clippy::struct_excessive_bools)] // independent observations of the server
struct Probe<'p, 'd> {
    endpoint: &'p Endpoint,
    options: &'p Options,
    stop: Stop,
    access: Access,
    /// A network in memory; `None` for the network of the system.
    network: Option<&'p dyn Network>,
    clock: Clock,
    secrets: Secrets,
    tape: Tape<'d>,
    coverage: Coverage,
    /// The connection used for the survey.
    session: Option<Session>,
    /// A connection that stays open during the trials, to show whether they affect other clients.
    witness: Option<Session>,
    /// Connections that wait for late answers.
    lingering: Vec<Session>,
    connections: usize,
    reconnects: u32,
    requests: u64,
    /// The number of requests that weren't answered in time.
    silences: u32,
    /// The number of times that the server stopped serving.
    stops: u32,
    /// True if a new connection failed while the probe waited for the server.
    is_refused: bool,
    /// The longest time that the server has taken to answer.
    slowest: Duration,
    /// The time after which no further requests are sent.
    end: Instant,
    /// The flights of the UAVs that may take off.
    flights: BTreeMap<String, Flight>,
    /// The UAVs that aren't known to be safe, with the reason.
    danger: Option<String>,
    landing_end: Option<Instant>,
    notes: Vec<String>,
    failure: Option<String>,
    cut_short: Option<String>,
    left_out: Option<String>,
    /// The numbers of requests and trials that were not sent because the time limit was reached.
    unsent: (u64, usize),
    /// The reason with which the server refuses a request of an unknown type.
    unknown_type: Option<String>,
    /// True if each new connection logs in.
    has_login: bool,
    /// True if the server announced that it ends connections.
    is_ending: bool,
    /// True if the server serves only one connection.
    is_exclusive: bool,
    /// True if answers have no envelope.
    is_bare: bool,
    /// True if the survey was completed.
    has_survey: bool,
    steps: (usize, usize),
    on_progress: &'p dyn Fn(usize, usize),
}

impl Probe<'_, '_> {
    /// Runs a part of the probe. After a panic, the probe continues with the next part, because UAVs may have to land.
    /// Returns false if the part panicked.
    fn guard(&mut self, part: impl FnOnce(&mut Self)) -> bool {
        let Err(panic) = catch_unwind(AssertUnwindSafe(|| part(self))) else { return true };
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        self.failure = Some(format!("internal error of uavspec: {text}"));
        self.tape.stop_checking();
        false
    }

    /// Runs the trials. They may stop a server, so they run only if no UAV depends on the server.
    fn complete(&mut self, attempts: &[(&'static Rule, Attempt)], steps: usize) {
        if let Some(danger) = self.danger() {
            // The danger to UAVs matters more than any other reason.
            self.cut_short = Some(format!("{danger}; check the UAVs"));
        }
        if self.stop.is_requested() || self.failure.is_some() {
            self.cancel_operations();
        }
        self.leave();
        self.steps.0 = steps;
        if self.has_survey {
            self.run_trials(attempts);
        }
    }

    /// Connects to the server, and waits for its first answer. Returns false if this isn't a Flockwave server.
    fn begin(&mut self) -> bool {
        let tested = match self.endpoint {
            Endpoint::Udp(_) => &udp_02::RULE,
            Endpoint::SocketIo { .. } => &sio_01::RULE,
            Endpoint::Tcp(_) | Endpoint::Http { .. } => &env_07::RULE,
        };
        let trial = Some(Trial { rule: &tested.rule, how: BEFORE_LOGIN });
        let until = self.clock.now() + CONNECT_TIMEOUT;
        loop {
            match self.connect(None) {
                Ok(session) => self.session = Some(session),
                Err(error) => {
                    self.refused(None, &error, None);
                    if !self.stop.is_due() {
                        self.failure = Some(format!("can't connect: {error}"));
                    }
                    return false;
                }
            }
            if self.post(&json!({ "type": "SYS-VER" }), trial, self.patience()).is_some() {
                return true;
            }
            // The server may be starting.
            if self.stop.is_due() {
                return false;
            }
            let is_over = self.session.as_ref().is_none_or(Session::is_over);
            if !is_over || self.tape.is_heard() || self.clock.now() + PAUSE >= until {
                break;
            }
            self.leave();
            self.tape.forget();
            self.sleep(PAUSE);
        }
        let refused = self.session.as_ref().filter(|session| session.is_refused_login());
        self.failure = Some(if let Some(why) = refused.and_then(Session::trouble) {
            why
        } else if self.tape.is_identified() {
            "the server doesn't answer".to_owned()
        } else {
            format!("this is not a Flockwave server: {}", self.why_unknown())
        });
        false
    }

    /// Describes the behaviour of a server that doesn't speak Flockwave, and suggests what kind of server it is.
    fn why_unknown(&self) -> String {
        let other = self.session.as_ref().and_then(Session::trouble);
        match (self.tape.unknown(), other) {
            (Some(data), _) if data.starts_with("HTTP/") || data.starts_with('<') => {
                format!("it sent {data:?}; for an HTTP server, use an http:// or socketio:// URL")
            }
            (Some(data), _) if data.starts_with('\u{15}') => {
                "it sent a TLS alert; for a server with TLS, use a tcps:// or https:// URL".to_owned()
            }
            (Some(data), _) => format!("it sent {data:?}"),
            (None, Some(trouble)) => trouble,
            (None, None) => format!("no answer to SYS-VER within {} s", self.patience().as_secs()),
        }
    }

    fn finish(mut self) -> Probed {
        self.leave();
        if let Some(witness) = self.witness.take() {
            self.close(witness);
        }
        while !self.lingering.is_empty() && !self.stop.is_due() {
            self.catch_up();
        }
        for session in std::mem::take(&mut self.lingering) {
            session.close(&mut self.tape);
        }
        let reason = if self.stop.is_requested() { INTERRUPTED } else { OUT_OF_TIME };
        let is_over = self.stop.is_requested() || self.unsent != (0, 0);
        let rest = self.cut_short.as_deref().or(is_over.then_some(reason)).or(self.failure.as_deref());
        let rest = rest.unwrap_or("not selected").to_owned();
        self.count_unsent(reason);
        let hidden = |text: String| self.secrets.hide(&text).into_owned();
        let danger = self.danger().map(hidden);
        let (mut result, unrecorded) = self.tape.finish();
        result.findings.retain(|rule| self.options.selection.has_rule(rule));
        let requests = self.coverage.finish(&self.secrets.hide(&rest));
        let notes = self.notes.into_iter().map(hidden).collect();
        let (failure, cut_short) = (self.failure.map(hidden), self.cut_short.map(hidden));
        let left_out = self.left_out.map(hidden);
        Probed { result, requests, notes, failure, cut_short, left_out, unrecorded, danger }
    }

    /// Adds the numbers of requests and trials that were not sent to the reason for the early end.
    fn count_unsent(&mut self, reason: &str) {
        if self.unsent != (0, 0) {
            let (requests, trials) = self.unsent;
            let unsent = format!("{} and {}", plural(requests, "request"), plural(trials, "trial"));
            let reason = self.cut_short.take().unwrap_or_else(|| reason.to_owned());
            self.cut_short = Some(format!("{reason}: {unsent} were not sent"));
        } else if self.stop.is_requested() {
            self.cut_short.get_or_insert(reason.to_owned());
        }
    }

    /// Sends a request on the survey's connection, and waits for the answer. A missing answer violates a rule.
    #[allow(clippy::needless_pass_by_value)] // callers build the body in the call
    fn query(&mut self, body: Value) -> Option<Value> {
        self.query_for_trial(&env_07::RULE, body)
    }

    /// Like [`query`](Self::query), for a request that tests a rule.
    #[allow(clippy::needless_pass_by_value)] // as above
    fn query_for_trial(&mut self, rule: &'static FlockwaveRule, body: Value) -> Option<Value> {
        let is_selected = self.options.selection.has_request(body["type"].as_str().unwrap_or_default());
        if is_selected { self.request(&rule.rule, Request::new("", body)) } else { None }
    }

    /// Sends a request that tests a rule, and waits for the answer.
    fn request(&mut self, rule: &'static Rule, request: Request) -> Option<Value> {
        self.step();
        self.catch_up();
        // The server may have closed the connection meanwhile.
        if let Some(session) = &mut self.session {
            session.catch_up(&mut self.tape);
        }
        let Request { how, body, member, is_repeated } = request;
        let type_name = body["type"].as_str().unwrap_or_default().to_owned();
        if let Some(reason) = self.must_stop() {
            self.coverage.not_sent(&[&type_name], reason);
            self.unsent.0 += 1;
            return None;
        }
        if !self.ensure_connected() {
            self.unsent.0 += 1;
            return None;
        }
        let id = self.next_id();
        let mut message = json!({ "$fw.version": "1.0", "id": id });
        if let Some((key, value)) = member {
            message[key] = value;
        }
        message["body"] = body;
        if is_repeated {
            self.post_message(&id, &message, Some(plain()), self.pace())?;
        }
        let answer = self.post_message(&id, &message, Some(Trial { rule, how }), self.pace());
        self.coverage.sent(&type_name, answer.as_ref());
        if answer.is_none() {
            self.unanswered(&type_name);
        }
        answer
    }

    /// Handles an unanswered request. If the connection doesn't answer `SYS-VER` either, only the first unanswered
    /// request is reported, and the probe continues on a new connection.
    fn unanswered(&mut self, type_name: &str) {
        self.silences += 1;
        let is_open = self.session.as_ref().is_some_and(|session| !session.is_over());
        if self.stop.is_due()
            || is_open && self.post(&json!({ "type": "SYS-VER" }), None, self.patience()).is_some()
            || self.stop.is_due()
        {
            return;
        }
        if is_open {
            self.note(format!("a connection stopped answering after {type_name}; the probe connected again"));
            self.leave();
        } else if !self.stop.commanded().is_safe() {
            // Landing needs a connection immediately.
            return;
        }
        self.recover(&format!("{AFTER_REQUEST}{type_name}"));
    }

    /// Sends a request, and waits for its answer.
    fn post(&mut self, body: &Value, trial: Option<Trial<'_>>, patience: Duration) -> Option<Value> {
        let id = self.next_id();
        let message = json!({ "$fw.version": "1.0", "id": id, "body": body });
        self.post_message(&id, &message, trial, patience)
    }

    fn post_message(
        &mut self,
        id: &str,
        message: &Value,
        trial: Option<Trial<'_>>,
        patience: Duration,
    ) -> Option<Value> {
        let body = &message["body"];
        self.stop.commanded().sent(body, self.flights.keys());
        let session = self.session.as_mut()?;
        let (text, end) = (message.to_string(), self.clock.now() + patience);
        // A command that arrives late or twice may have an effect twice.
        let is_command = body["type"].as_str().is_some_and(|name| commands::COMMANDS.contains(&name));
        let is_resent = matches!(self.endpoint, Endpoint::Udp(_)) && !is_command;
        let resends = if is_resent { MAX_RESENDS } else { 0 };
        for left in (0..=resends).rev() {
            let sent_at = self.clock.now();
            session.send(&mut self.tape, text.as_bytes(), Some(id), trial);
            let until =
                if left == 0 { end } else { end.min(sent_at + RESEND_INTERVAL.max(self.slowest * 3)) };
            if let Some(answer) = session.answer(&mut self.tape, id, until) {
                self.slowest = self.slowest.max(self.clock.now().saturating_duration_since(sent_at));
                self.stop.commanded().answered(body, &answer);
                return Some(answer);
            }
        }
        None
    }

    fn next_id(&mut self) -> String {
        self.requests += 1;
        format!("probe-{}", self.requests)
    }

    /// Logs in, if the caller provided a name. Returns false if the server refuses the login.
    fn log_in(&mut self) -> bool {
        let Some((name, password)) = self.options.login.as_ref().filter(|_| self.has_login) else {
            return true;
        };
        let data = base64::encode(format!("{name}:{password}").as_bytes());
        let body = json!({ "type": "AUTH-REQ", "method": "basic", "data": data });
        let answer = self.post(&body, Some(plain()), self.patience());
        self.coverage.sent("AUTH-REQ", answer.as_ref());
        let is_accepted = answer.as_ref().is_some_and(|answer| answer["body"]["result"] == true);
        if let Some(answer) = answer.filter(|_| !is_accepted) {
            // Further attempts could lock the account.
            self.cut_short(refused_login(&answer));
        }
        is_accepted
    }

    /// The time to wait for an answer before the next request is sent.
    fn pace(&self) -> Duration {
        let usual = if self.silences < REDUCED_PACE.0 { PACE } else { REDUCED_PACE.1 };
        usual.max(self.slowest * 3).min(self.patience())
    }

    /// The time for which a request may remain unanswered.
    fn patience(&self) -> Duration {
        self.options.timeout
    }

    /// The reason why no further request may be sent, if there is one.
    fn must_stop(&self) -> Option<&'static str> {
        match () {
            () if self.stop.is_due() => Some(INTERRUPTED),
            () if self.clock.now() >= self.end => Some(OUT_OF_TIME),
            () => None,
        }
    }

    /// Waits until the time has passed or the probe must stop.
    fn sleep(&self, time: Duration) {
        self.stop.sleep(&self.clock, time);
    }

    fn step(&mut self) {
        self.steps.0 = (self.steps.0 + 1).min(self.steps.1);
        (self.on_progress)(self.steps.0, self.steps.1);
    }

    fn note(&mut self, text: String) {
        if self.notes.len() < MAX_NOTES && !self.stop.is_due() {
            self.notes.push(text);
        }
    }

    /// Ends the probe early for this reason. If the user has interrupted the probe, the reason is ignored.
    fn cut_short(&mut self, why: String) {
        if !self.stop.is_due() {
            self.cut_short.get_or_insert(why);
        }
    }
}

/// Describes the refusal of a login, with the server's reason.
fn refused_login(answer: &Value) -> String {
    let reason = answer["body"]["reason"].as_str().or_else(|| answer["error"]["message"].as_str());
    let reason = reason.map_or_else(String::new, |reason| format!(": {}", shown(reason)));
    format!("the server refused the login{reason}")
}

/// The default trial. It tests only whether the server answers a request.
fn plain() -> Trial<'static> {
    Trial { rule: &env_07::RULE.rule, how: "" }
}
