//! The client's trials on separate connections.

use serde_json::{Value, json};
use uavspec_model::Rule;

use super::Session;
use crate::flockwave::{
    ack_06, asy_10, asy_18, asy_19, env_07, env_13, env_19, env_21, env_22, env_24, env_25, env_27,
    obj_list_03, sio_01, sio_02, sio_03, sys_ping_01, tcp_02, tcp_03, tcp_04, uav_inf_06, uav_inf_07, udp_02,
    udp_03,
};

/// Trials over TCP that can use any type of request.
static TCP_TRIALS: [(&Rule, &str); 4] = [
    (&tcp_02::RULE.rule, "a message in two segments"),
    (&tcp_02::RULE.rule, "two messages in a segment"),
    (&tcp_03::RULE.rule, "after a line that is not JSON"),
    (&tcp_04::RULE.rule, "the rest of a message after a pause"),
];

/// The number of requests for each trial over UDP.
const ATTEMPTS: u32 = 3;

#[allow(clippy::needless_pass_by_value)] // bodies are written where they are passed
impl Session {
    /// Adds a UAV-LAND with this answer, and then the states of the glider at these heights in mm, one every 1.5 s.
    pub(crate) fn lands(&mut self, answer: Value, heights: &[i64]) {
        self.exchange(json!({ "type": "UAV-LAND", "ids": ["kite"] }), answer.clone());
        if let Some(receipt) = answer["receipt"]["kite"].as_str() {
            self.notify(json!({ "type": "ASYNC-RESP", "id": receipt, "result": true }));
        }
        for height in heights {
            let position = json!([465_410_000, 115_520_000, 812_000 + height, height]);
            let state = json!({ "id": "kite", "timestamp": self.now(), "position": position });
            self.exchange(
                json!({ "type": "UAV-INF", "ids": ["kite"] }),
                json!({ "status": { "kite": state } }),
            );
            self.wait(1.5);
        }
    }

    /// Adds all trials.
    pub(super) fn trials(&mut self) {
        self.over("tcp#2", |session| {
            session.envelopes();
            session.contents();
        });
        self.over("tcp#3", Self::families);
        self.over("tcp#4", Self::lists);
        self.over("tcp#5", |session| {
            let login = json!({ "methods": ["basic"], "required": true });
            session.exchange(json!({ "type": "AUTH-INF" }), login);
            let refusal = json!({ "type": "ACK-NAK", "reason": "Log in first" });
            session.tries_and_receives(
                &ack_06::RULE.rule,
                "before the login",
                json!({ "type": "UAV-LIST" }),
                refusal,
            );
        });
        self.over("tcp#6", |session| {
            session.lands(json!({ "receipt": { "kite": "rcpt-60" } }), &[9_000, 9_500, 9_000, 4_000, 0]);
        });
        self.over("tcp#7", |session| {
            let ping = json!({ "type": "SYS-PING" });
            session.line("out", json!({ "$fw.version": "1.0", "id": 17, "body": ping }));
            session.notify(json!({ "type": "ACK-NAK", "reason": "The id isn't a string" }));
        });
        self.over("udp#1", |session| {
            for (rule, how) in [
                (&udp_02::RULE.rule, "any request"),
                (&udp_03::RULE.rule, "after a datagram that is not JSON"),
            ] {
                for _ in 0..ATTEMPTS {
                    session.pings(rule, how);
                }
            }
        });
        self.over("socketio#1", |session| {
            session.pings(&sio_01::RULE.rule, "over a WebSocket");
            session.pings(&sio_03::RULE.rule, "after an event with a different name");
        });
        self.over("socketio#2", |session| session.pings(&sio_02::RULE.rule, "by long polling"));
    }

    /// Adds a request that tests a rule, and a response with this body.
    pub fn tries_and_receives(&mut self, rule: &Rule, how: &str, request: Value, answer: Value) {
        let id = self.tries(rule, how, request);
        self.answers(&id, json!({ "body": answer }));
    }

    /// Adds a SYS-PING that tests a rule, and its response.
    pub(crate) fn pings(&mut self, rule: &Rule, how: &str) {
        self.tries_and_receives(rule, how, json!({ "type": "SYS-PING" }), json!({ "type": "ACK-ACK" }));
    }

    /// Adds several requests that test a rule, followed by responses in the given order.
    pub fn pipelines(&mut self, rule: &Rule, answered: &[usize]) {
        let ids: Vec<String> =
            answered.iter().map(|_| self.tries(rule, "", json!({ "type": "SYS-PING" }))).collect();
        for id in answered.iter().filter_map(|at| ids.get(*at)) {
            self.answers(id, json!({ "body": { "type": "ACK-ACK" } }));
        }
    }

    /// Adds a request that tests a rule and has a changed envelope.
    pub(crate) fn tries_with(
        &mut self,
        rule: &Rule,
        how: &str,
        member: (&str, Value),
        answer: Option<Value>,
    ) {
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
        for (rule, how) in TCP_TRIALS {
            self.pings(rule, how);
        }
        let acknowledged = || Some(json!({ "type": "ACK-ACK" }));
        self.tries_with(&env_13::RULE.rule, "an unknown key", ("wind", "fair".into()), acknowledged());
        for _ in 0..2 {
            self.tries_with(
                &env_19::RULE.rule,
                "the id of an answered request",
                ("id", "again".into()),
                acknowledged(),
            );
        }
        self.tries_with(
            &env_21::RULE.rule,
            "an id with non-ASCII letters",
            ("id", "Höhe über Grund".into()),
            acknowledged(),
        );
        let no_list = json!({ "type": "UAV-INF", "ids": "kite" });
        let refused = json!({ "type": "ACK-NAK", "reason": "The ids aren't a list" });
        self.tries_and_receives(
            &env_22::RULE.rule,
            "a malformed request: ids that are not a list",
            no_list,
            refused,
        );
        self.pings(&env_22::RULE.rule, "after a malformed request");
        self.pipelines(&env_25::RULE.rule, &[0, 1, 2]);
        self.pings(&env_27::RULE.rule, "after a trial");
    }

    fn contents(&mut self) {
        self.pings(&sys_ping_01::RULE.rule, "");
        let clouds = json!({ "type": "OBJ-LIST", "filter": ["cloud"] });
        let none = json!({ "type": "OBJ-LIST", "ids": [] });
        self.tries_and_receives(&obj_list_03::RULE.rule, "an unknown type", clouds, none);
        let unknown = json!({ "type": "UAV-INF", "ids": ["nobody"] });
        let error = json!({ "type": "UAV-INF", "error": { "nobody": "No such glider" } });
        self.tries_and_receives(&uav_inf_06::RULE.rule, "an unknown id", unknown, error);
        let nothing = json!({ "type": "UAV-INF", "ids": [] });
        self.tries_and_receives(
            &uav_inf_07::RULE.rule,
            "no ids",
            nothing,
            json!({ "type": "UAV-INF", "status": {} }),
        );
        for kind in ["ASYNC-CANCEL", "ASYNC-RESUME"] {
            let error = json!({ "type": kind, "error": { "rcpt-none": "No such receipt" } });
            let unknown = json!({ "type": kind, "ids": ["rcpt-none"] });
            self.tries_and_receives(&asy_18::RULE.rule, "an unknown receipt", unknown, error);
        }
        let test = json!({ "type": "UAV-TEST", "ids": ["kite"], "component": "lamp" });
        let tested = json!({ "type": "UAV-TEST", "receipt": { "kite": "rcpt-21" } });
        self.tries_and_receives(&asy_10::RULE.rule, "", test, tested);
        self.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-21", "result": true }));
        self.command("rcpt-20");
        let resume = json!({ "type": "ASYNC-RESUME", "ids": ["rcpt-20"] });
        let error = json!({ "type": "ASYNC-RESUME", "error": { "rcpt-20": "It isn't suspended" } });
        self.tries_and_receives(&asy_19::RULE.rule, "a running operation", resume, error);
        self.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-20", "result": "Flaps out" }));
    }

    /// Adds a command that is answered with a receipt.
    pub fn command(&mut self, receipt: &str) {
        let command = json!({ "type": "OBJ-CMD", "ids": ["kite"], "command": "flaps" });
        self.exchange(command, json!({ "receipt": { "kite": receipt } }));
    }

    /// Adds a request of each mandatory family, and a request of an unknown type.
    fn families(&mut self) {
        self.logs_in();
        let refusal = json!({ "type": "ACK-NAK", "reason": "No handler for UAV-SOAR" });
        self.tries_and_receives(
            &env_07::RULE.rule,
            "an unknown type",
            json!({ "type": "UAV-SOAR" }),
            refusal,
        );
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
            self.tries_and_receives(&env_24::RULE.rule, "", request, answer);
        }
    }

    /// Adds repeated and filtered queries.
    fn lists(&mut self) {
        let version =
            || json!({ "software": "Windward", "version": "3.1", "name": "Hill", "revision": "b7" });
        for _ in 0..2 {
            self.exchange(json!({ "type": "SYS-VER" }), version());
        }
        for request in [json!({}), json!({ "adjustment": 0 }), json!({})] {
            let mut request = request;
            request["type"] = "SYS-TIME".into();
            let now = self.now() + 40;
            self.exchange(request, json!({ "timestamp": now }));
        }
        let ports = json!({ "ports": { "tcp": 7001, "udp": 7002, "socketio": 7003 } });
        self.exchange(json!({ "type": "SYS-PORTS" }), ports);
        let gliders = || json!({ "ids": ["kite", "swift"] });
        let all = || json!({ "ids": ["kite", "swift", "mast"] });
        let status = json!({ "kite": self.kite(), "swift": self.swift() });
        self.exchange(json!({ "type": "OBJ-LIST" }), all());
        self.exchange(json!({ "type": "UAV-LIST" }), gliders());
        self.exchange(json!({ "type": "OBJ-LIST", "filter": ["uav"] }), gliders());
        self.exchange(json!({ "type": "OBJ-LIST", "filter": ["beacon"] }), json!({ "ids": ["mast"] }));
        self.exchange(json!({ "type": "UAV-INF", "ids": ["kite", "swift"] }), json!({ "status": status }));
        self.exchange(json!({ "type": "UAV-LIST" }), gliders());
        self.exchange(json!({ "type": "OBJ-LIST" }), all());
    }
}
