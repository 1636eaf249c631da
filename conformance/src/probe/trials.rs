//! What a server has to bear. Each attempt has a connection of its own, so that none hides what comes of another.

use std::time::Duration;

use serde_json::json;

use super::malformed;
use super::tape::Trial;
use crate::flockwave::transport::endpoint::{Carrier, Endpoint};
use crate::model::Rule;
use crate::rules::rule;

/// How long it takes until the next piece of a message follows, where pieces follow soon.
const SOON: Duration = Duration::from_millis(60);

/// The same where the server has time to think that nothing follows.
const LATE: Duration = Duration::from_millis(1_200);

/// What is no JSON, by kind.
const NOISE: [(&str, &[u8]); 4] = [
    ("words", b"the wind turns"),
    ("a message that is cut off", b"{\"$fw.version\":\"1.0\",\"id\":\"cut"),
    ("bytes that are no UTF-8", b"\xff\xfe\x00\x01"),
    ("nothing", b""),
];

/// Something to try on a connection of its own.
pub(super) struct Attempt {
    /// The rule that is tried.
    pub(super) rule: &'static Rule,
    /// How, in a few words.
    pub(super) how: String,
    /// The endpoint, where it is another than all others have.
    pub(super) endpoint: Option<Endpoint>,
    /// What is done, in this order.
    pub(super) steps: Vec<Step>,
}

/// Something that is done on a connection.
pub(super) enum Step {
    /// A message is sent.
    Send(Said),
    /// Messages are sent at once: over TCP in one segment.
    Together(Vec<Said>),
    /// A message is sent in so many pieces, with pauses between them.
    Pieces(Said, usize, Duration),
    /// A packet of Socket.IO is sent.
    Packet(String),
}

impl Step {
    /// The id of the last request of it.
    pub(super) fn id(&self) -> Option<&str> {
        match self {
            Self::Send(said) | Self::Pieces(said, ..) => said.id(),
            Self::Together(all) => all.last()?.id(),
            Self::Packet(_) => None,
        }
    }
}

/// What is sent.
pub(super) struct Said {
    /// The message.
    pub(super) text: Vec<u8>,
    id: Option<String>,
}

impl Said {
    /// Its id, where it can be answered.
    pub(super) fn id(&self) -> Option<&str> {
        self.id.as_deref()
    }

    /// What is tried with it: what can't be answered tries nothing by itself.
    pub(super) fn tries<'t>(&self, trial: Trial<'t>) -> Option<Trial<'t>> {
        self.id.is_some().then_some(trial)
    }

    /// A request that every server answers, and has no reason to refuse.
    fn plain(id: impl Into<String>) -> Self {
        Self::request(id, "SYS-VER")
    }

    fn request(id: impl Into<String>, kind: &str) -> Self {
        let id = id.into();
        let text = json!({ "$fw.version": "1.0", "id": id, "body": { "type": kind } }).to_string();
        Self { text: text.into_bytes(), id: Some(id) }
    }

    fn noise(text: impl Into<Vec<u8>>) -> Self {
        Self { text: text.into(), id: None }
    }
}

/// All attempts at a server, in the order in which they are made.
pub(super) fn all(endpoint: &Endpoint) -> Vec<Attempt> {
    let mut attempts = Attempts(Vec::new());
    match endpoint {
        Endpoint::Tcp(_) => {
            attempts.ids();
            attempts.order();
            attempts.tcp();
        }
        Endpoint::Udp(_) => {
            attempts.ids();
            attempts.udp();
        }
        Endpoint::Http { .. } => attempts.ids(),
        Endpoint::SocketIo { carrier, .. } => {
            attempts.ids();
            attempts.order();
            attempts.socket_io(endpoint, *carrier);
        }
    }
    attempts.malformed();
    attempts.0
}

struct Attempts(Vec<Attempt>);

impl Attempts {
    fn add(&mut self, id: &str, how: impl Into<String>, steps: Vec<Step>) {
        // All ids here are of rules that there are; a test tries it.
        if let Some(rule) = rule(id) {
            self.0.push(Attempt { rule, how: how.into(), endpoint: None, steps });
        }
    }

    fn ids(&mut self) {
        let ids = [
            ("an id of 36 characters", "c0ffee00-1234-4abc-9def-0123456789ab"),
            ("an id with spaces", " two words "),
            ("an id that isn't ASCII", "Höhe 高度 \u{1fa82}"),
            ("an id with characters that JSON escapes", "\"\\/\u{7}\t<&>"),
        ];
        for (how, id) in ids {
            self.add("FW-ENV-21", how, vec![Step::Send(Said::plain(id))]);
        }
    }

    fn order(&mut self) {
        let kinds =
            ["SYS-VER", "SYS-TIME", "UAV-LIST", "SYS-PORTS", "CONN-LIST", "OBJ-LIST", "SYS-VER", "SYS-TIME"];
        let requests =
            kinds.iter().enumerate().map(|(at, kind)| Said::request(format!("at-once-{at}"), kind));
        self.add("FW-ENV-25", "", vec![Step::Together(requests.collect())]);
    }

    fn tcp(&mut self) {
        let (one, two) = (|| Said::plain("one"), || Said::plain("two"));
        self.add("FW-TCP-02", "a message in two segments", vec![Step::Pieces(one(), 2, SOON)]);
        self.add("FW-TCP-02", "a message in many segments", vec![Step::Pieces(one(), 12, SOON / 4)]);
        self.add("FW-TCP-02", "two messages in one segment", vec![Step::Together(vec![one(), two()])]);
        self.add(
            "FW-TCP-02",
            "a message in one segment with a line that is no JSON",
            vec![Step::Together(vec![one(), Said::noise("the wind turns")])],
        );
        self.add("FW-TCP-04", "a message whose second half comes late", vec![Step::Pieces(one(), 2, LATE)]);
        for (kind, noise) in NOISE {
            let steps = vec![Step::Send(Said::noise(noise)), Step::Send(one())];
            self.add("FW-TCP-03", format!("after a line that is no JSON: {kind}"), steps);
        }
    }

    fn udp(&mut self) {
        // Datagrams get lost: one answer is enough.
        let asked = || ["one", "two", "three"].map(|id| Step::Send(Said::plain(id)));
        self.add("FW-UDP-02", "", asked().into());
        for (kind, noise) in NOISE {
            let steps = [Step::Send(Said::noise(noise))].into_iter().chain(asked()).collect();
            self.add("FW-UDP-03", format!("after a datagram that is no JSON: {kind}"), steps);
        }
    }

    fn socket_io(&mut self, endpoint: &Endpoint, carrier: Carrier) {
        self.add("FW-SIO-01", "", vec![Step::Send(Said::plain("one"))]);
        self.add("FW-SIO-02", "long polling", vec![Step::Send(Said::plain("one"))]);
        if let (Carrier::WebSocket, Some(last)) = (carrier, self.0.last_mut()) {
            last.endpoint = Some(endpoint.by(Carrier::Polling));
        }
        let odd = [
            ("one of another name", r#"2["wind","turns"]"#),
            ("one without a message", r#"2["fw"]"#),
            ("one whose message is a number", r#"2["fw",17]"#),
            ("one whose message is a string", r#"2["fw","the wind turns"]"#),
            ("one whose message is null", r#"2["fw",null]"#),
            ("one with two messages", r#"2["fw",{},{}]"#),
            ("one whose name is a number", r"2[17,{}]"),
        ];
        for (kind, packet) in odd {
            let steps = vec![Step::Packet(packet.to_owned()), Step::Send(Said::plain("one"))];
            self.add("FW-SIO-03", format!("after an odd event: {kind}"), steps);
        }
    }

    fn malformed(&mut self) {
        for malformed::Malformed { how, text, has_id } in malformed::all("malformed") {
            let id = has_id.then(|| "malformed".to_owned());
            let first = Said { text: text.into_bytes(), id };
            let steps = vec![Step::Send(first), Step::Send(Said::plain("next"))];
            self.add("FW-ENV-22", how, steps);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_transport_is_tried_by_all_rules_on_it() {
        let rules = |url: &str| -> BTreeSet<&str> {
            let endpoint: Endpoint = url.parse().expect("a URL");
            all(&endpoint).iter().map(|attempt| attempt.rule.id).collect()
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
