//! What a client tries, over connections of their own.

use serde_json::{Value, json};

use super::Session;

/// Trials over TCP that any request makes.
const LINES: [(&str, &str); 4] = [
    ("FW-TCP-02", "a message in two segments"),
    ("FW-TCP-02", "two messages in a segment"),
    ("FW-TCP-03", "after a line that is no JSON"),
    ("FW-TCP-04", "the rest of a message after a pause"),
];

/// How often something is asked over UDP.
const ATTEMPTS: u32 = 3;

#[allow(clippy::needless_pass_by_value)] // bodies are written where they are passed
impl Session {
    /// All of them.
    pub(super) fn trials(&mut self) {
        self.over("tcp#2", |session| {
            session.envelopes();
            session.contents();
        });
        self.over("tcp#3", Self::families);
        self.over("tcp#4", Self::lists);
        self.over("tcp#5", |session| {
            let login = json!({ "methods": ["basic"], "required": true });
            session.asks(json!({ "type": "AUTH-INF" }), login);
            let nobody = json!({ "type": "ACK-NAK", "reason": "Log in first" });
            session.tries_and_hears("FW-ACK-06", "before the login", json!({ "type": "UAV-LIST" }), nobody);
        });
        self.over("udp#1", |session| {
            for (rule, how) in [("FW-UDP-02", "any request"), ("FW-UDP-03", "after what is no JSON")] {
                for _ in 0..ATTEMPTS {
                    session.pings(rule, how);
                }
            }
        });
        self.over("socketio#1", |session| {
            session.pings("FW-SIO-01", "over a WebSocket");
            session.pings("FW-SIO-03", "after an event of another name");
        });
        self.over("socketio#2", |session| session.pings("FW-SIO-02", "by long polling"));
    }

    /// The client asks, to try a rule, and the server answers with this body.
    pub fn tries_and_hears(&mut self, rule: &str, how: &str, request: Value, answer: Value) {
        let id = self.tries(rule, how, request);
        self.answers(&id, json!({ "body": answer }));
    }

    /// The same, of any request.
    pub fn pings(&mut self, rule: &str, how: &str) {
        self.tries_and_hears(rule, how, json!({ "type": "SYS-PING" }), json!({ "type": "ACK-ACK" }));
    }

    /// Requests of a rule are all sent before the first of these answers comes: each by the number of its request.
    pub fn pipelines(&mut self, rule: &str, answered: &[usize]) {
        let ids: Vec<String> =
            answered.iter().map(|_| self.tries(rule, "", json!({ "type": "SYS-PING" }))).collect();
        for id in answered.iter().filter_map(|at| ids.get(*at)) {
            self.answers(id, json!({ "body": { "type": "ACK-ACK" } }));
        }
    }

    /// The client tries a rule with a request whose envelope is another.
    pub fn tries_with(&mut self, rule: &str, how: &str, member: (&str, Value), answer: Option<Value>) {
        let id = self.tries(rule, how, json!({ "type": "SYS-PING" }));
        let (key, value) = member;
        let id = if key == "id" { value.as_str().unwrap_or_default().to_owned() } else { id };
        if let Some(line) = self.lines.last_mut() {
            line["msg"][key] = value;
        }
        if let Some(answer) = answer {
            self.answers(&id, json!({ "body": answer }));
        }
    }

    fn envelopes(&mut self) {
        for (rule, how) in LINES {
            self.pings(rule, how);
        }
        let done = || Some(json!({ "type": "ACK-ACK" }));
        self.tries_with("FW-ENV-13", "an unknown key", ("wind", "fair".into()), done());
        for _ in 0..2 {
            self.tries_with("FW-ENV-19", "an id that was answered", ("id", "again".into()), done());
        }
        self.tries_with("FW-ENV-21", "an id with other letters", ("id", "Höhe über Grund".into()), done());
        let no_list = json!({ "type": "UAV-INF", "ids": "kite" });
        let refused = json!({ "type": "ACK-NAK", "reason": "The ids aren't a list" });
        self.tries_and_hears("FW-ENV-22", "a malformed request: ids that are no list", no_list, refused);
        self.pings("FW-ENV-22", "after a malformed request");
        self.pipelines("FW-ENV-25", &[0, 1, 2]);
    }

    fn contents(&mut self) {
        self.pings("FW-SYS-PING-01", "");
        let clouds = json!({ "type": "OBJ-LIST", "filter": ["cloud"] });
        let none = json!({ "type": "OBJ-LIST", "ids": [] });
        self.tries_and_hears("FW-OBJ-LIST-03", "an unknown type", clouds, none);
        let unknown = json!({ "type": "UAV-INF", "ids": ["nobody"] });
        let error = json!({ "type": "UAV-INF", "error": { "nobody": "No such glider" } });
        self.tries_and_hears("FW-UAV-INF-06", "an unknown id", unknown, error);
        let nothing = json!({ "type": "UAV-INF", "ids": [] });
        self.tries_and_hears("FW-UAV-INF-07", "no ids", nothing, json!({ "type": "UAV-INF", "status": {} }));
        let kite = json!({ "kite": self.kite() });
        let twice = json!({ "type": "UAV-INF", "ids": ["kite", "kite"] });
        let status = json!({ "type": "UAV-INF", "status": kite });
        self.asks(json!({ "type": "UAV-LIST" }), json!({ "ids": ["kite", "swift"] }));
        self.tries_and_hears("FW-UAV-INF-07", "an id twice", twice, status);
        for kind in ["ASYNC-CANCEL", "ASYNC-RESUME"] {
            let error = json!({ "type": kind, "error": { "rcpt-none": "No such receipt" } });
            let unknown = json!({ "type": kind, "ids": ["rcpt-none"] });
            self.tries_and_hears("FW-ASY-18", "an unknown receipt", unknown, error);
        }
        self.command("rcpt-20");
        let resume = json!({ "type": "ASYNC-RESUME", "ids": ["rcpt-20"] });
        let error = json!({ "type": "ASYNC-RESUME", "error": { "rcpt-20": "It isn't suspended" } });
        self.tries_and_hears("FW-ASY-19", "an operation that goes on", resume, error);
        self.tells(json!({ "type": "ASYNC-RESP", "id": "rcpt-20", "result": "Flaps out" }));
    }

    /// A glider is told to do what takes longer than an answer may.
    pub fn command(&mut self, receipt: &str) {
        let command = json!({ "type": "OBJ-CMD", "ids": ["kite"], "command": "flaps" });
        self.asks(command, json!({ "receipt": { "kite": receipt } }));
    }

    /// A request of each family that servers have to know, and one of a family that there isn't.
    fn families(&mut self) {
        self.logs_in();
        let nobody = json!({ "type": "ACK-NAK", "reason": "No handler for UAV-SOAR" });
        self.tries_and_hears("FW-ENV-07", "an unknown type", json!({ "type": "UAV-SOAR" }), nobody);
        let none = json!({ "ids": [] });
        let version = json!({ "software": "Windward", "version": "3.1", "name": "Hill", "revision": "b7" });
        let error = json!({ "error": { "rcpt-none": "No such receipt" } });
        let families = [
            (json!({ "type": "ASYNC-CANCEL", "ids": ["rcpt-none"] }), error),
            (json!({ "type": "AUTH-WHOAMI" }), json!({ "user": "wind" })),
            (json!({ "type": "CONN-LIST" }), json!({ "ids": ["winch"] })),
            (
                json!({ "type": "DEV-LIST", "ids": ["kite"] }),
                json!({ "devices": { "kite": { "type": "object" } } }),
            ),
            (json!({ "type": "EXT-LIST" }), json!({ "available": ["wind"], "loaded": ["wind"] })),
            (json!({ "type": "OBJ-LIST" }), json!({ "ids": ["kite", "swift", "mast"] })),
            (json!({ "type": "RTK-LIST" }), none),
            (json!({ "type": "SYS-VER" }), version),
            (json!({ "type": "UAV-LIST" }), json!({ "ids": ["kite", "swift"] })),
        ];
        for (request, mut answer) in families {
            answer["type"] = request["type"].clone();
            self.tries_and_hears("FW-ENV-24", "", request, answer);
        }
    }

    /// What is asked more than once, or in more than one way.
    fn lists(&mut self) {
        let version =
            || json!({ "software": "Windward", "version": "3.1", "name": "Hill", "revision": "b7" });
        for _ in 0..2 {
            self.asks(json!({ "type": "SYS-VER" }), version());
        }
        for request in [json!({}), json!({ "adjustment": 0 }), json!({})] {
            let mut request = request;
            request["type"] = "SYS-TIME".into();
            let now = self.now() + 40;
            self.asks(request, json!({ "timestamp": now }));
        }
        let ports = json!({ "ports": { "tcp": 7001, "udp": 7002, "socketio": 7003 } });
        self.asks(json!({ "type": "SYS-PORTS" }), ports);
        let gliders = || json!({ "ids": ["kite", "swift"] });
        let all = || json!({ "ids": ["kite", "swift", "mast"] });
        let status = json!({ "kite": self.kite(), "swift": self.swift() });
        self.asks(json!({ "type": "OBJ-LIST" }), all());
        self.asks(json!({ "type": "UAV-LIST" }), gliders());
        self.asks(json!({ "type": "OBJ-LIST", "filter": ["uav"] }), gliders());
        self.asks(json!({ "type": "OBJ-LIST", "filter": ["beacon"] }), json!({ "ids": ["mast"] }));
        self.asks(json!({ "type": "UAV-INF", "ids": ["kite", "swift"] }), json!({ "status": status }));
        self.asks(json!({ "type": "UAV-LIST" }), gliders());
        self.asks(json!({ "type": "OBJ-LIST" }), all());
    }
}
