//! A conforming Flockwave session, recorded by a client that monitors two gliders. The client also runs trials on
//! separate connections.

mod trials;

use serde_json::{Value, json};
use uavspec_model::Rule;

/// The start time, in seconds since the epoch.
const START: f64 = 1_790_000_000.0;

/// The time between messages, in seconds.
const STEP: f64 = 0.05;

/// The number of status reports at the end, and the time between reports, in seconds.
const REPORTS: (u32, f64) = (12, 5.0);

/// A recorded session.
#[derive(Clone, Debug)]
pub struct Session {
    /// The records.
    pub lines: Vec<Value>,
    connection: &'static str,
    time: f64,
    num_requests: u64,
    num_messages: u64,
}

impl Default for Session {
    fn default() -> Self {
        Self::new()
    }
}

#[allow(clippy::needless_pass_by_value)] // bodies are written where they are passed
impl Session {
    /// Creates the conforming session.
    pub fn new() -> Self {
        let mut session = Self::opened();
        session.server();
        session.fleet();
        session.operations();
        session.rest();
        session.trials();
        for _ in 0..REPORTS.0 {
            session.time += REPORTS.1;
            session.report();
        }
        session.notify(json!({ "type": "SYS-CLOSE", "reason": "The wind drops" }));
        session.closed("eof");
        session
    }

    /// Creates a session with an open connection and no messages.
    pub fn opened() -> Self {
        let mut session =
            Self { lines: Vec::new(), connection: "hill", time: START, num_requests: 0, num_messages: 0 };
        session.event("connect");
        session
    }

    /// Adds a request and a response of the same type.
    pub fn exchange(&mut self, request: Value, answer: Value) {
        let mut answer = answer;
        answer["type"] = request["type"].clone();
        self.exchange_with(request, answer);
    }

    /// Adds a request and a response with this body.
    pub fn exchange_with(&mut self, request: Value, answer: Value) {
        let id = self.sends(request);
        self.answers(&id, json!({ "body": answer }));
    }

    /// Adds a request. Returns the id of the request.
    pub fn sends(&mut self, request: Value) -> String {
        self.num_requests += 1;
        let id = format!("ask-{}", self.num_requests);
        self.line("out", json!({ "$fw.version": "1.0", "id": id, "body": request }));
        id
    }

    /// Adds a request that tests a rule. Returns the id of the request.
    pub fn tries(&mut self, rule: &Rule, how: &str, request: Value) -> String {
        let id = self.sends(request);
        self.marks_trial(rule, how);
        id
    }

    /// Marks the last record as a trial of a rule.
    fn marks_trial(&mut self, rule: &Rule, how: &str) {
        if let Some(line) = self.lines.last_mut() {
            line["trial"] = rule.id.into();
            line["how"] = how.into();
        }
    }

    /// Adds records on another connection. The name of the connection starts with its transport.
    pub fn over(&mut self, connection: &'static str, add: impl FnOnce(&mut Self)) {
        let before = std::mem::replace(&mut self.connection, connection);
        let url = match connection {
            _ if connection.starts_with("udp") => "udp://hill:7002",
            _ if connection.starts_with("socketio") => "socketio://hill:7003?protocol=5&transport=websocket",
            _ => "tcp://hill:7001",
        };
        self.noted("connect", "url", url);
        add(self);
        self.closed("client");
        self.connection = before;
    }

    /// Adds a refused connection that tests a rule.
    pub fn refused(&mut self, rule: &Rule, how: &str, reason: &str) {
        self.noted("refused", "why", reason);
        self.marks_trial(rule, how);
    }

    /// Adds an HTTP request that fails and tests a rule.
    pub fn failed(&mut self, rule: &Rule, how: &str, reason: &str) {
        self.noted("failed", "why", reason);
        self.marks_trial(rule, how);
    }

    /// Adds client text that is not a message.
    pub fn sends_raw(&mut self, text: &str) {
        let mut line = self.next("out");
        line["raw"] = text.into();
        self.lines.push(line);
    }

    /// Adds server text that is not a message.
    pub fn send_raw(&mut self, text: &str) {
        let mut line = self.next("in");
        line["raw"] = text.into();
        self.lines.push(line);
    }

    /// Closes the connection.
    pub fn closed(&mut self, reason: &str) {
        self.noted("closed", "why", reason);
    }

    /// Adds a connection event with a note.
    fn noted(&mut self, name: &str, key: &str, note: &str) {
        self.event(name);
        if let Some(line) = self.lines.last_mut() {
            line[key] = note.into();
        }
    }

    /// Adds a response to a request.
    pub fn answers(&mut self, id: &str, answer: Value) {
        self.num_messages += 1;
        let mut message =
            json!({ "$fw.version": "1.0", "id": format!("say-{}", self.num_messages), "refs": id });
        if let (Some(message), Value::Object(answer)) = (message.as_object_mut(), answer) {
            message.extend(answer);
        }
        self.line("in", message);
    }

    /// Adds a notification.
    pub fn notify(&mut self, body: Value) {
        self.num_messages += 1;
        let id = format!("say-{}", self.num_messages);
        self.line("in", json!({ "$fw.version": "1.0", "id": id, "body": body }));
    }

    /// Adds a connection event.
    pub fn event(&mut self, name: &str) {
        let mut line = self.next("event");
        line["event"] = name.into();
        self.lines.push(line);
    }

    /// Advances the time.
    pub fn wait(&mut self, seconds: f64) {
        self.time += seconds;
    }

    /// Adds a line that contains this message.
    pub(crate) fn line(&mut self, direction: &str, message: Value) {
        let mut line = self.next(direction);
        line["msg"] = message;
        self.lines.push(line);
    }

    fn next(&mut self, direction: &str) -> Value {
        self.time += STEP;
        json!({ "t": self.time, "conn": self.connection, "dir": direction })
    }

    /// The server time, in milliseconds.
    pub fn now(&self) -> u64 {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the time is in 2026
        let now = ((self.time + STEP) * 1000.0) as u64;
        now
    }

    /// Queries the server.
    fn server(&mut self) {
        let version = json!({ "software": "Windward", "version": "3.1", "name": "Hill", "revision": "b7" });
        self.exchange(json!({ "type": "SYS-VER" }), version);
        self.exchange_with(json!({ "type": "SYS-PING" }), json!({ "type": "ACK-ACK" }));
        for _ in 0..2 {
            let now = self.now() + 40;
            self.exchange(json!({ "type": "SYS-TIME" }), json!({ "timestamp": now }));
        }
        self.exchange(json!({ "type": "SYS-PORTS" }), json!({ "ports": { "tcp": 7001, "udp": 7002 } }));
        self.logs_in();
        // The server pings the client.
        self.notify(json!({ "type": "SYS-PING" }));
        let answer = json!({
            "$fw.version": "1.0", "id": "here-1", "refs": format!("say-{}", self.num_messages),
            "body": { "type": "ACK-ACK" },
        });
        self.line("out", answer);
        let refusal = json!({ "type": "ACK-NAK", "reason": "Nobody here can soar" });
        self.exchange_with(json!({ "type": "UAV-SOAR" }), refusal);
        let id = self.sends(json!({ "type": "LCN-INF" }));
        self.answers(&id, json!({ "error": { "code": 3, "message": "The licence can't be read" } }));
    }

    /// Adds the login of the client.
    pub(crate) fn logs_in(&mut self) {
        let login = json!({ "type": "AUTH-REQ", "method": "basic", "data": "d2luZDpoaWxs" });
        self.exchange_with(login, json!({ "type": "AUTH-RESP", "result": true, "user": "wind" }));
    }

    /// Queries the gliders and their states.
    fn fleet(&mut self) {
        self.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": ["kite", "swift"] }));
        self.exchange(json!({ "type": "OBJ-LIST" }), json!({ "ids": ["kite", "swift", "vane"] }));
        let status = json!({ "kite": self.kite(), "swift": self.swift() });
        let request = json!({ "type": "UAV-INF", "ids": ["kite", "swift", "owl"] });
        self.exchange(request, json!({ "status": status, "error": { "owl": "No such glider" } }));
        self.report();
        self.notify(json!({ "type": "OBJ-DEL", "ids": ["vane"] }));
        self.exchange(json!({ "type": "OBJ-LIST" }), json!({ "ids": ["kite", "swift"] }));
        let items = json!([{ "message": "Thermals in the east", "severity": "info", "sender": "kite" }]);
        self.notify(json!({ "type": "SYS-MSG", "items": items }));
    }

    /// Adds a status report.
    pub fn report(&mut self) {
        let status = json!({ "kite": self.kite(), "swift": self.swift() });
        self.notify(json!({ "type": "UAV-INF", "status": status }));
    }

    fn kite(&self) -> Value {
        json!({
            "id": "kite", "timestamp": self.now() - 30, "mode": "stab",
            "position": [465_410_000, 115_520_000, 812_000, null, 1_500], "positionXYZ": [120, -40, 0],
            "gps": [3, 11, 900, null], "heading": 2710, "attitude": [-12, 35, 2710], "velocity": [0, 3, -1],
            "velocityXYZ": [1, 0, 0], "battery": [118, 84, true], "light": 2016, "rssi": [71, -1], "errors": [1, 73],
            "debug": "Z2xpZGU=",
        })
    }

    fn swift(&self) -> Value {
        json!({
            "id": "swift", "timestamp": self.now() - 20, "mode": "mission", "position": [465_411_000, 115_521_000],
            "heading": 0, "battery": [0, -1], "errors": [66],
        })
    }

    /// Adds long-running operations.
    fn operations(&mut self) {
        let answer = json!({
            "receipt": { "kite": "rcpt-1" }, "result": { "swift": true }, "error": { "owl": "No such glider" },
        });
        self.exchange(json!({ "type": "UAV-TAKEOFF", "ids": ["kite", "swift", "owl"] }), answer);
        let progress = json!({ "percentage": 40, "message": "Winch is pulling" });
        self.notify(json!({ "type": "ASYNC-ST", "id": "rcpt-1", "progress": progress }));
        let waits = json!({ "percentage": 70 });
        self.notify(json!({ "type": "ASYNC-ST", "id": "rcpt-1", "progress": waits, "suspended": true }));
        let resume =
            json!({ "type": "ASYNC-RESUME", "ids": ["rcpt-1", "rcpt-9"], "values": { "rcpt-1": "let go" } });
        self.exchange(resume, json!({ "success": ["rcpt-1"], "error": { "rcpt-9": "Unknown" } }));
        self.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-1", "result": true }));
        let answer = json!({ "receipt": { "kite": "rcpt-2", "swift": "rcpt-3" } });
        self.exchange(json!({ "type": "OBJ-CMD", "ids": ["kite", "swift"], "command": "flaps" }), answer);
        self.notify(json!({ "type": "ASYNC-TIMEOUT", "ids": ["rcpt-2"] }));
        let cancel = json!({ "type": "ASYNC-CANCEL", "ids": ["rcpt-3"] });
        self.exchange(cancel, json!({ "success": ["rcpt-3"] }));
        self.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-3", "error": "Cancelled" }));
        self.exchange(
            json!({ "type": "LOG-DATA", "uavId": "kite", "logId": "7" }),
            json!({ "receipt": "rcpt-4" }),
        );
        let log = json!({ "id": "7", "kind": "text", "body": "Took off" });
        self.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-4", "result": log }));
        let set = json!({ "type": "PRM-SET-MANY", "ids": ["kite"], "parameters": { "FLAPS": 2, "GEAR": 1 } });
        self.exchange(set, json!({ "result": { "kite": { "success": false, "failed": ["GEAR"] } } }));
    }

    /// Adds the remaining message types.
    fn rest(&mut self) {
        let now = self.now();
        let winch =
            json!({ "id": "winch", "purpose": "uavRadioLink", "status": "connected", "timestamp": now });
        let missing = json!({ "gone": "Unknown" });
        let answer = json!({ "status": { "winch": winch }, "error": missing });
        self.exchange(json!({ "type": "CONN-INF", "ids": ["winch", "gone"] }), answer);
        self.notify(json!({ "type": "CONN-INF", "status": { "winch": winch } }));
        let clock = json!({ "id": "day", "retrievedAt": now, "running": true, "ticks": 5 });
        let answer = json!({ "status": { "day": clock }, "error": missing });
        self.exchange(json!({ "type": "CLK-INF", "ids": ["day", "gone"] }), answer);
        let paths = json!(["/kite/vario", "/kite/none"]);
        let error = json!({ "/kite/none": "No such channel" });
        let answer = json!({ "values": { "/kite/vario": 1.5 }, "error": error });
        self.exchange(json!({ "type": "DEV-INF", "paths": paths }), answer);
        let answer = json!({ "success": ["/kite/vario"], "error": error });
        self.exchange(json!({ "type": "DEV-SUB", "paths": paths }), answer);
        self.notify(json!({ "type": "DEV-INF", "values": { "/kite/vario": -0.5 } }));
        let answer = json!({ "devices": { "kite": { "type": "object" } }, "error": missing });
        self.exchange(json!({ "type": "DEV-LIST", "ids": ["kite", "gone"] }), answer);
        let beacon = json!({ "id": "mast", "timestamp": now, "active": true });
        let answer = json!({ "status": { "mast": beacon }, "error": missing });
        self.exchange(json!({ "type": "BCN-INF", "ids": ["mast", "gone"] }), answer);
        let weather = json!({ "position": [465_410_000, 115_520_000], "timestamp": now, "windSpeed": 6200 });
        let answer = json!({ "status": { "ridge": weather }, "error": missing });
        self.exchange(json!({ "type": "WTH-INF", "ids": ["ridge", "gone"] }), answer);
        let location = json!({ "type": "WTH-AT", "position": [465_410_000, 115_520_000] });
        self.exchange(location, json!({ "weather": weather }));
        let preset = json!({ "title": "Field", "format": "auto", "sources": ["tcp://field:9000"] });
        let answer = json!({ "preset": { "field": preset }, "error": missing });
        self.exchange(json!({ "type": "RTK-INF", "ids": ["field", "gone"] }), answer);
        self.exchange_with(json!({ "type": "RTK-SOURCE", "id": "field" }), json!({ "type": "ACK-ACK" }));
        let extension = json!({ "id": "wind", "loaded": true, "name": "Wind" });
        let answer = json!({ "status": { "wind": extension }, "error": missing });
        self.exchange(json!({ "type": "EXT-INF", "ids": ["wind", "gone"] }), answer);
        let checks = json!({ "result": "pass", "items": [{ "id": "spoilers", "result": "pass" }] });
        let answer = json!({ "status": { "kite": checks }, "error": missing });
        self.exchange(json!({ "type": "UAV-PREFLT", "ids": ["kite", "gone"] }), answer);
    }

    /// Changes the body of the server's first response of this type.
    pub fn reply(self, type_name: &str, change: impl FnOnce(&mut Value)) -> Option<Self> {
        self.reply_message(type_name, |message| change(&mut message["body"]))
    }

    /// Changes the server's first response of this type.
    pub(crate) fn reply_message(self, type_name: &str, change: impl FnOnce(&mut Value)) -> Option<Self> {
        let is_reply = |line: &&mut Value| line["msg"].get("refs").is_some() && is(line, "in", type_name);
        self.change(is_reply, change)
    }

    /// Changes the body of the first notification of this type.
    pub(crate) fn notice(self, type_name: &str, change: impl FnOnce(&mut Value)) -> Option<Self> {
        let is_notice = |line: &&mut Value| line["msg"].get("refs").is_none() && is(line, "in", type_name);
        self.change(is_notice, |message| change(&mut message["body"]))
    }

    /// Changes the state of one glider in the last status report.
    pub fn state(mut self, change: impl FnOnce(&mut Value)) -> Option<Self> {
        let last = self.lines.iter_mut().rfind(|line| is(line, "in", "UAV-INF"))?;
        change(&mut last["msg"]["body"]["status"]["kite"]);
        Some(self)
    }

    /// Changes the error codes of one glider in the last status report.
    pub fn errors(self, codes: &[i64]) -> Option<Self> {
        self.state(|kite| kite["errors"] = codes.into())
    }

    /// Adds records before SYS-CLOSE.
    #[must_use]
    pub fn then(mut self, add: impl FnOnce(&mut Self)) -> Self {
        let closing = self.lines.split_off(self.lines.len().saturating_sub(2));
        add(&mut self);
        self.lines.extend(closing);
        self
    }

    /// Removes the server's first message of this type.
    pub(crate) fn without(mut self, type_name: &str) -> Option<Self> {
        let at = self.lines.iter().position(|line| is(line, "in", type_name))?;
        self.lines.remove(at);
        Some(self)
    }

    fn change(
        mut self,
        predicate: impl FnMut(&&mut Value) -> bool,
        change: impl FnOnce(&mut Value),
    ) -> Option<Self> {
        let line = self.lines.iter_mut().find(predicate)?;
        change(&mut line["msg"]);
        Some(self)
    }

    /// The bytes of the JSON Lines file.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.lines.iter().map(|line| format!("{line}\n")).collect::<String>().into_bytes()
    }
}

fn is(line: &Value, direction: &str, type_name: &str) -> bool {
    line["dir"] == direction && line["msg"]["body"]["type"] == type_name
}
