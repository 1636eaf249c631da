//! Trials: probe requests that test whether a server follows a rule.

use std::time::Duration;

use serde_json::{Value, json};
use uavspec_flockwave::session::Exchange;
use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_model::Rule;

use super::RULES;

/// The prefix of the description of a control request that a probe sends after a trial.
pub const AFTER_TRIAL: &str = "after a trial: ";
/// The prefix of the description of a control request that a probe sends after another request.
pub const AFTER_REQUEST: &str = "after a request: ";

/// The suffix of a control request's description, if the probe sent a single message of a trial again before it.
pub const SENT_ALONE: &str = ", sent alone";

/// A short pause between the parts of a message.
pub(super) const SHORT_PAUSE: Duration = Duration::from_millis(60);

/// An id that no object should have.
pub const UNKNOWN_ID: &str = "unknown-id";

/// Texts that are not JSON, by description.
const INVALID_TEXTS: [(&str, &[u8]); 4] = [
    ("words", b"not a message"),
    ("a truncated message", b"{\"$fw.version\":\"1.0\",\"id\":\"cut"),
    ("invalid UTF-8", b"\xff\xfe\x00\x01"),
    ("empty", b""),
];

/// The trial of a rule.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Trial {
    /// Requests on the survey's connection, created from the UAV ids.
    Requests(fn(&[String]) -> Vec<Request>),
    /// Attempts on separate connections; empty if the rule does not apply to the transport.
    Attempts(Strain, fn(&Endpoint) -> Vec<Attempt>),
}

/// The load that attempts put on a server. Attempts with the lowest load come first, because a server might not survive
/// higher loads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Strain {
    /// Common requests. If they fail, so does everything else.
    Plain,
    /// Valid but unusual requests.
    Sound,
    /// Data that is not a message.
    Noise,
    /// Malformed messages.
    Malformed,
}

/// A request that tests a rule.
pub struct Request {
    /// A short description of the test.
    pub how: &'static str,
    /// The body of the request.
    pub body: Value,
    /// An additional member of the envelope.
    pub member: Option<(&'static str, Value)>,
    /// True if the request is sent and answered once before the test.
    pub is_repeated: bool,
}

impl Request {
    /// Creates a request with this body.
    pub fn new(how: &'static str, body: Value) -> Self {
        Self { how, body, member: None, is_repeated: false }
    }
}

/// A trial on a separate connection, so its result does not depend on other trials.
pub struct Attempt {
    /// A short description of the test.
    pub how: String,
    /// An endpoint for this attempt only; `None` to use the probe's endpoint.
    pub endpoint: Option<Endpoint>,
    /// The steps, in order.
    pub steps: Vec<Step>,
}

impl Attempt {
    /// Creates an attempt with these steps.
    pub(super) fn new(how: impl Into<String>, steps: impl Into<Vec<Step>>) -> Self {
        Self { how: how.into(), endpoint: None, steps: steps.into() }
    }
}

/// A step of an attempt.
pub enum Step {
    /// Sends a message.
    Send(Sent),
    /// Sends messages together. Over TCP, they are sent in one segment.
    Together(Vec<Sent>),
    /// Sends a message in this many parts, with pauses between them.
    Pieces(Sent, usize, Duration),
    /// Sends a Socket.IO packet.
    Packet(String),
}

impl Step {
    /// The messages.
    pub fn messages(&self) -> &[Sent] {
        match self {
            Self::Send(sent) | Self::Pieces(sent, ..) => std::slice::from_ref(sent),
            Self::Together(all) => all,
            Self::Packet(_) => &[],
        }
    }

    /// The id of the last request, if any.
    pub fn id(&self) -> Option<&str> {
        self.messages().last()?.id()
    }

    /// Sends a request that every server must serve.
    pub fn request(id: &str) -> Self {
        Self::Send(Sent::request(id, "SYS-VER"))
    }
}

/// A message to send.
#[derive(Clone)]
pub struct Sent {
    /// The message.
    pub text: Vec<u8>,
    id: Option<String>,
    /// True for a request that shows only whether the server still serves.
    pub is_control: bool,
}

impl Sent {
    /// The id of the message, if the message can be answered.
    pub fn id(&self) -> Option<&str> {
        self.id.as_deref()
    }

    /// Creates a request of this type without parameters.
    pub(super) fn request(id: &str, kind: &str) -> Self {
        let text = json!({ "$fw.version": "1.0", "id": id, "body": { "type": kind } }).to_string();
        Self { is_control: kind == "SYS-VER", ..Self::text(text, Some(id)) }
    }

    /// Creates a message from text. `id` is the id to which responses refer, or `None` if the message can't be
    /// answered.
    pub(super) fn text(text: impl Into<Vec<u8>>, id: Option<&str>) -> Self {
        Self { text: text.into(), id: id.map(str::to_owned), is_control: false }
    }
}

/// Creates an attempt for each invalid text. Each attempt sends the text, followed by requests with these ids.
pub(super) fn after_noise(before: &str, ids: &[&str]) -> Vec<Attempt> {
    let attempt = |(kind, noise): (&str, &[u8])| {
        let noise = Step::Send(Sent::text(noise, None));
        let steps: Vec<Step> = [noise].into_iter().chain(ids.iter().map(|id| Step::request(id))).collect();
        Attempt::new(format!("{before}: {kind}"), steps)
    };
    INVALID_TEXTS.into_iter().map(attempt).collect()
}

/// All requests that test rules on the survey's connection.
pub fn requests(uavs: &[String]) -> Vec<(&'static Rule, Request)> {
    let mut all = Vec::new();
    for flockwave in RULES {
        if let Some(Trial::Requests(make)) = flockwave.trial {
            all.extend(make(uavs).into_iter().map(|request| (&flockwave.rule, request)));
        }
    }
    all
}

/// All attempts for a server, in order of execution.
pub fn attempts(endpoint: &Endpoint) -> Vec<(&'static Rule, Attempt)> {
    let mut all = Vec::new();
    for flockwave in RULES {
        if let Some(Trial::Attempts(strain, make)) = flockwave.trial {
            all.extend(make(endpoint).into_iter().map(|attempt| (strain, &flockwave.rule, attempt)));
        }
    }
    all.sort_by_key(|(strain, ..)| *strain);
    all.into_iter().map(|(_, rule, attempt)| (rule, attempt)).collect()
}

/// The rule or message type whose requests reproduce a finding: the rule that the request tests, or the type of the
/// request.
pub fn shown_by(exchange: &Exchange<'_>) -> Option<String> {
    let request = exchange.request.as_ref();
    let of_request =
        request.and_then(|request| request.trial.as_ref()).map(|(rule, how)| (*rule, how.as_str()));
    let tried = of_request.or_else(|| exchange.record.trial.map(|trial| (trial.rule, trial.how)));
    let (rule, how) = tried.unzip();
    // FW-ENV-27 checks the server after a trial or a request.
    let how = how.unwrap_or_default();
    if let Some(trial) = how.strip_prefix(AFTER_TRIAL) {
        return trial.split(',').next().map(str::to_owned);
    }
    if let Some(type_name) = how.strip_prefix(AFTER_REQUEST) {
        return Some(type_name.to_owned());
    }
    let has_trial = |rule: &&Rule| super::rule(rule.id).is_some_and(|entry| entry.trial.is_some());
    let tested = rule.filter(has_trial).map(|rule| rule.id.to_owned());
    tested.or_else(|| request?.type_name.clone())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_transport_has_trials_of_all_its_rules() {
        let rules = |url: &str| -> BTreeSet<&str> {
            let endpoint: Endpoint = url.parse().expect("a URL");
            attempts(&endpoint).iter().map(|(rule, _)| rule.id).collect()
        };
        let expected: [(&str, &[&str]); 4] = [
            (
                "tcp://localhost:1",
                &["FW-ENV-21", "FW-ENV-22", "FW-ENV-25", "FW-TCP-02", "FW-TCP-03", "FW-TCP-04"],
            ),
            ("udp://localhost:1", &["FW-ENV-21", "FW-ENV-22", "FW-UDP-02", "FW-UDP-03"]),
            ("http://localhost:1", &["FW-ENV-21", "FW-ENV-22"]),
            (
                "socketio://localhost:1",
                &["FW-ENV-21", "FW-ENV-22", "FW-ENV-25", "FW-SIO-01", "FW-SIO-02", "FW-SIO-03"],
            ),
        ];
        for (url, expected) in expected {
            assert_eq!(rules(url), expected.iter().copied().collect::<BTreeSet<_>>(), "{url}");
        }
    }
}
