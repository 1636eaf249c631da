//! Trials: requests of a probe that show whether a server keeps a rule.

use std::time::Duration;

use serde_json::{Value, json};

use super::RULES;
use crate::flockwave::transport::endpoint::Endpoint;
use crate::model::Rule;

/// The pause between the pieces of a message that follow each other soon.
pub(super) const SHORT_PAUSE: Duration = Duration::from_millis(60);

/// An id that no object has.
pub(crate) const UNKNOWN_ID: &str = "nobody-knows-this";

/// Texts that are no JSON, by kind.
const INVALID_TEXTS: [(&str, &[u8]); 4] = [
    ("words", b"the wind turns"),
    ("a message that is cut off", b"{\"$fw.version\":\"1.0\",\"id\":\"cut"),
    ("bytes that are no UTF-8", b"\xff\xfe\x00\x01"),
    ("nothing", b""),
];

/// The trial of a rule.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Trial {
    /// Requests over the connection of the survey, made from the ids of the UAVs.
    Requests(fn(&[String]) -> Vec<Request>),
    /// Attempts over separate connections, none if the rule isn't about this transport.
    Attempts(Strain, fn(&Endpoint) -> Vec<Attempt>),
}

/// The strain that attempts put on a server. Those with the least come first: a server may not survive the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Strain {
    /// Sound requests.
    Sound,
    /// Data that is no message.
    Noise,
    /// Messages that are malformed.
    Malformed,
}

/// A request that tries a rule.
pub(crate) struct Request {
    /// How it tries the rule, in a few words.
    pub(crate) how: &'static str,
    /// Its body.
    pub(crate) body: Value,
    /// A further member of its envelope.
    pub(crate) member: Option<(&'static str, Value)>,
    /// True if it is sent and answered once before it tries the rule.
    pub(crate) is_repeated: bool,
}

impl Request {
    /// A request with this body.
    pub(crate) fn new(how: &'static str, body: Value) -> Self {
        Self { how, body, member: None, is_repeated: false }
    }
}

/// A trial on a separate connection, so that its result doesn't depend on other trials.
pub(crate) struct Attempt {
    /// How it tries the rule, in a few words.
    pub(crate) how: String,
    /// The endpoint; none if it is that of all others.
    pub(crate) endpoint: Option<Endpoint>,
    /// The steps, in order.
    pub(crate) steps: Vec<Step>,
}

impl Attempt {
    /// An attempt with these steps.
    pub(super) fn new(how: impl Into<String>, steps: impl Into<Vec<Step>>) -> Self {
        Self { how: how.into(), endpoint: None, steps: steps.into() }
    }
}

/// A step of an attempt.
pub(crate) enum Step {
    /// Sends a message.
    Send(Sent),
    /// Sends messages in one pass: over TCP in one segment.
    Together(Vec<Sent>),
    /// Sends a message in so many pieces, with pauses between them.
    Pieces(Sent, usize, Duration),
    /// Sends a packet of Socket.IO.
    Packet(String),
}

impl Step {
    /// The id of its last request.
    pub(crate) fn id(&self) -> Option<&str> {
        match self {
            Self::Send(sent) | Self::Pieces(sent, ..) => sent.id(),
            Self::Together(all) => all.last()?.id(),
            Self::Packet(_) => None,
        }
    }

    /// Sends a request that every server answers, and has no reason to refuse.
    pub(super) fn request(id: &str) -> Self {
        Self::Send(Sent::request(id, "SYS-VER"))
    }
}

/// A message that is sent.
pub(crate) struct Sent {
    /// The message.
    pub(crate) text: Vec<u8>,
    id: Option<String>,
}

impl Sent {
    /// Its id, if it can be answered.
    pub(crate) fn id(&self) -> Option<&str> {
        self.id.as_deref()
    }

    /// A request without parameters, of this type.
    pub(super) fn request(id: &str, kind: &str) -> Self {
        let text = json!({ "$fw.version": "1.0", "id": id, "body": { "type": kind } }).to_string();
        Self::text(text, Some(id))
    }

    /// A text, and the id that answers to it refer to; none if it can't be answered.
    pub(super) fn text(text: impl Into<Vec<u8>>, id: Option<&str>) -> Self {
        Self { text: text.into(), id: id.map(str::to_owned) }
    }
}

/// An attempt for each kind of noise: the noise, and then these requests.
pub(super) fn after_noise(before: &str, ids: &[&str]) -> Vec<Attempt> {
    let attempt = |(kind, noise): (&str, &[u8])| {
        let noise = Step::Send(Sent::text(noise, None));
        let steps: Vec<Step> = [noise].into_iter().chain(ids.iter().map(|id| Step::request(id))).collect();
        Attempt::new(format!("{before}: {kind}"), steps)
    };
    INVALID_TEXTS.into_iter().map(attempt).collect()
}

/// All requests that try rules over the connection of the survey.
pub(crate) fn requests(uavs: &[String]) -> Vec<(&'static Rule, Request)> {
    let mut all = Vec::new();
    for of in RULES {
        if let Some(Trial::Requests(make)) = of.trial {
            all.extend(make(uavs).into_iter().map(|request| (&of.rule, request)));
        }
    }
    all
}

/// All attempts at a server, in the order in which they are made.
pub(crate) fn attempts(endpoint: &Endpoint) -> Vec<(&'static Rule, Attempt)> {
    let mut all = Vec::new();
    for of in RULES {
        if let Some(Trial::Attempts(strain, make)) = of.trial {
            all.extend(make(endpoint).into_iter().map(|attempt| (strain, &of.rule, attempt)));
        }
    }
    all.sort_by_key(|(strain, ..)| *strain);
    all.into_iter().map(|(_, rule, attempt)| (rule, attempt)).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_transport_is_tried_by_all_rules_on_it() {
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
