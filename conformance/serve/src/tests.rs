//! Tests of the hub with a simulated clock, without bugs and with each bug.

use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::rc::Rc;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use proptest::prelude::*;
use serde_json::{Value, json};
use uavspec_model::Rule;
use uavspec_rules::flockwave::{
    FlockwaveRule, RULES, ack_06, env_25, env_27, sio_01, sio_02, sio_03, tcp_01, tcp_02, tcp_03, tcp_04,
    udp_01, udp_02, udp_03,
};
use uavspec_test_support::{extent, wait_for};
use uavspec_types::flockwave::json::Request;

use super::hub::{ConnectionKind, Hub, SessionId, Sink};
use super::{Options, Server, Transport, family};

/// Rules whose bug can't be observed by a single client that sends one request at a time. `tests/live_matrix.rs` covers
/// the bugs of transports and concurrent requests. Another test in this file covers the login bug.
static NOT_OBSERVABLE: [&Rule; 13] = [
    &ack_06::RULE.rule,
    &env_25::RULE.rule,
    &env_27::RULE.rule,
    &sio_01::RULE.rule,
    &sio_02::RULE.rule,
    &sio_03::RULE.rule,
    &tcp_01::RULE.rule,
    &tcp_02::RULE.rule,
    &tcp_03::RULE.rule,
    &tcp_04::RULE.rule,
    &udp_01::RULE.rule,
    &udp_02::RULE.rule,
    &udp_03::RULE.rule,
];

#[derive(Default)]
struct RecordingSink(Mutex<Vec<String>>);

impl Sink for RecordingSink {
    fn send(&self, text: &str) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(text.to_owned());
    }

    fn close(&self) {
        self.send("closed");
    }
}

struct TestSession {
    hub: Hub,
    session: SessionId,
    received: Rc<RecordingSink>,
    time: Duration,
}

impl TestSession {
    fn new(bug: Option<&'static FlockwaveRule>, login: Option<(String, String)>) -> Self {
        let errors = vec![("glider-5".to_owned(), 193)];
        let mut hub = Hub::new(
            Options { bug, login, errors, start: 1_750_000_000_000, ..Options::default() },
            family::answer,
        );
        hub.ports = [("tcp", 5001), ("udp", 5001)].into();
        let received = Rc::new(RecordingSink::default());
        let session = hub.open(ConnectionKind::Persistent, Rc::<RecordingSink>::clone(&received));
        Self { hub, session, received, time: Duration::ZERO }
    }

    fn wait(&mut self, seconds: u32) {
        for _ in 0..seconds * 10 {
            self.time += Duration::from_millis(100);
            self.hub.advance(self.time);
        }
    }

    fn raw(&mut self, text: &str) {
        self.hub.receive(self.session, text.as_bytes(), self.time);
    }

    fn send_request(&mut self, id: &str, body: &Value) {
        self.raw(&json!({ "$fw.version": "1.0", "id": id, "body": body }).to_string());
    }

    /// Returns the messages received since the last call.
    fn take_received(&mut self) -> Vec<String> {
        std::mem::take(&mut *self.received.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// The messages of a session whose requests cover all rules.
fn transcript(bug: Option<&'static FlockwaveRule>) -> Vec<String> {
    let mut session = TestSession::new(bug, None);
    let both = ["glider-1", "missing-1"];
    let requests = [
        json!({ "type": "SYS-PING" }),
        json!({ "type": "SYS-VER" }),
        json!({ "type": "SYS-VER" }),
        json!({ "type": "SYS-TIME" }),
        json!({ "type": "SYS-TIME", "adjustment": 0 }),
        json!({ "type": "SYS-TIME" }),
        json!({ "type": "SYS-PORTS" }),
        json!({ "type": "GLIDE-INF" }),
        json!({ "type": "OBJ-LIST" }),
        json!({ "type": "OBJ-LIST", "filter": ["beacon"] }),
        json!({ "type": "OBJ-LIST", "filter": ["kite"] }),
        json!({ "type": "UAV-LIST" }),
        json!({ "type": "UAV-INF", "ids": both }),
        json!({ "type": "UAV-INF", "ids": [] }),
        json!({ "type": "UAV-INF", "ids": ["glider-1", "glider-1"] }),
        json!({ "type": "UAV-PREFLT", "ids": both }),
        json!({ "type": "UAV-VER", "ids": both }),
        json!({ "type": "AUTH-INF" }),
        json!({ "type": "AUTH-REQ", "method": "basic", "data": "YTpi" }),
        json!({ "type": "CONN-LIST" }),
        json!({ "type": "CONN-INF", "ids": ["radio-1", "missing-1"] }),
        json!({ "type": "BCN-INF", "ids": ["mark-1", "missing-1"] }),
        json!({ "type": "CLK-INF", "ids": ["system", "missing-1"] }),
        json!({ "type": "WTH-INF", "ids": ["wind-1", "missing-1"] }),
        json!({ "type": "WTH-AT", "position": [504_980_000, 99_520_000] }),
        json!({ "type": "RTK-LIST" }),
        json!({ "type": "RTK-SOURCE", "id": "base" }),
        json!({ "type": "EXT-LIST" }),
        json!({ "type": "DEV-LIST", "ids": both }),
        json!({ "type": "DEV-INF", "paths": ["/glider-1/battery", "/missing-1"] }),
        json!({ "type": "DEV-SUB", "paths": ["/glider-1/gps/satellites"] }),
        json!({ "type": "PRM-SET-MANY", "ids": both, "parameters": { "CRUISE_SPEED": 7, "COLOUR": 1 } }),
        json!({ "type": "LOG-DATA", "uavId": "glider-1", "logId": "1" }),
        json!({ "type": "UAV-TAKEOFF", "ids": both }),
        json!({ "type": "UAV-TEST", "ids": both, "component": "led" }),
        json!({ "type": "UAV-CALIB", "ids": ["glider-2"], "component": "compass" }),
        json!({ "type": "UAV-CALIB", "ids": ["glider-3"], "component": "baro" }),
        json!({ "type": "ASYNC-RESUME", "ids": ["r3", "missing-1"] }),
        json!({ "type": "UAV-SLEEP", "ids": ["glider-4"] }),
        json!({ "type": "UAV-SIGNAL", "ids": ["glider-4"] }),
    ];
    for (number, body) in requests.iter().enumerate() {
        session.send_request(&format!("höh {number}"), body);
    }
    session.send_request("höh 1", &json!({ "type": "SYS-PING" }));
    session.wait(1);
    // Cancels the barometer's calibration. The receipt is fixed, since a bug may have changed it in the response.
    session.send_request("cancel", &json!({ "type": "ASYNC-CANCEL", "ids": ["r4", "missing-1"] }));
    session.wait(7);
    session.send_request("land", &json!({ "type": "UAV-LAND", "ids": ["glider-1"] }));
    session.wait(1);
    session.send_request("lose", &json!({ "type": "OBJ-CMD", "ids": ["glider-5"], "command": "lose" }));
    session.send_request("list", &json!({ "type": "UAV-LIST" }));
    session.raw(r#"{"$fw.version":"1.0","id":"broken"}"#);
    session.raw(r#"{"$fw.version":"1.0","id":17,"body":{"type":"SYS-PING"}}"#);
    session.hub.end();
    session.take_received()
}

/// The bodies of the responses to requests, in order.
fn responses(options: &Options, requests: &[Value]) -> Vec<Value> {
    let mut session = TestSession::new(None, None);
    session.hub.options.is_for_skybrush = options.is_for_skybrush;
    session.take_received();
    for (number, body) in requests.iter().enumerate() {
        session.send_request(&number.to_string(), body);
    }
    let messages = session.take_received().into_iter();
    let messages = messages.map(|text| serde_json::from_str::<Value>(&text).expect("JSON"));
    messages
        .filter(|message| message.get("refs").is_some())
        .map(|mut message| message["body"].take())
        .collect()
}

#[test]
fn takes_numbers_that_clients_write_as_text() {
    let requests = [
        json!({ "type": "OBJ-CMD", "ids": ["glider-1"], "command": "battery", "args": ["90%"] }),
        json!({ "type": "OBJ-CMD", "ids": ["glider-1"], "command": "battery", "args": [" 35.5 % "] }),
        json!({ "type": "OBJ-CMD", "ids": ["glider-1"], "command": "battery", "args": ["full"] }),
        json!({ "type": "OBJ-CMD", "ids": ["glider-2"], "command": "error", "args": ["193"] }),
        json!({ "type": "PRM-SET", "ids": ["glider-1"], "name": "CRUISE_SPEED", "value": "7.5" }),
        json!({ "type": "PRM-GET", "ids": ["glider-1", "glider-2"], "name": "CRUISE_SPEED" }),
        json!({ "type": "PRM-SET-MANY", "ids": ["glider-1"], "parameters": { "LIGHT_MODE": "red" } }),
    ];
    let bodies = responses(&Options::default(), &requests);
    let data = |at: usize| bodies[at]["result"].to_string();
    assert!(data(0).contains("charged to 90 %") && data(1).contains("charged to 36 %"), "{bodies:?}");
    assert_eq!(bodies[2]["error"]["glider-1"], "expected the charge in percent");
    assert!(data(3).contains("193"), "{bodies:?}");
    assert_eq!(bodies[4]["result"], json!({ "glider-1": true }));
    assert_eq!(bodies[5]["result"], json!({ "glider-1": 7.5, "glider-2": 8 }));
    assert_eq!(bodies[6]["result"]["glider-1"], json!({ "success": false, "failed": ["LIGHT_MODE"] }));
}

#[test]
fn stores_the_configuration_of_a_show() {
    let start =
        json!({ "authorized": true, "clock": null, "time": 5.0, "method": "auto", "uavIds": ["glider-1"] });
    let lights = json!({ "effect": "solid", "color": [255.0, 0.0, 0.0] });
    let requests = [
        json!({ "type": "SHOW-CFG" }),
        json!({ "type": "SHOW-SETCFG", "configuration": { "start": start } }),
        json!({ "type": "SHOW-CFG" }),
        json!({ "type": "SHOW-LIGHTS" }),
        json!({ "type": "SHOW-SETLIGHTS", "configuration": lights }),
        json!({ "type": "SHOW-LIGHTS" }),
        json!({ "type": "SHOW-CRTH-START" }),
        json!({ "type": "RTK-SURVEY" }),
    ];
    let bodies = responses(&Options::default(), &requests);
    assert_eq!(bodies[0]["configuration"]["start"]["authorized"], false);
    assert_eq!([&bodies[1]["type"], &bodies[4]["type"]], ["ACK-ACK", "ACK-ACK"]);
    assert_eq!(bodies[2]["configuration"]["start"], start);
    assert_eq!(bodies[3]["configuration"]["effect"], "off");
    assert_eq!(bodies[5]["configuration"], lights);
    let segment = &bodies[6]["schedule"][0];
    assert!(
        segment["type"] == "rth" && segment["startMs"].is_i64() && segment["endMs"].is_i64(),
        "{segment}"
    );
    assert_eq!(bodies[7]["settings"]["duration"], 60.0);
}

/// Skybrush Live uses some fields and types that differ from the specification.
#[test]
fn answers_as_skybrush_live_expects() {
    let requests = [
        json!({ "type": "UAV-PREFLT", "ids": ["glider-1"] }),
        json!({ "type": "X-RTK-SOURCE" }),
        json!({ "type": "X-RTK-SOURCE", "id": "base" }),
        json!({ "type": "RTK-SURVEY", "settings": { "duration": 30, "accuracy": 2 } }),
        json!({ "type": "RTK-SURVEY" }),
        json!({ "type": "X-GLIDE-INF" }),
        json!({ "type": "X-SHOW-CRTH-START" }),
    ];
    let bodies = responses(&Options { is_for_skybrush: true, ..Options::default() }, &requests);
    let types: Vec<&str> = bodies.iter().map(|body| body["type"].as_str().expect("a type")).collect();
    let expected =
        ["UAV-PREFLT", "X-RTK-SOURCE", "ACK-ACK", "ACK-ACK", "RTK-SURVEY", "ACK-NAK", "X-SHOW-CRTH-START"];
    assert_eq!(types, expected);
    assert_eq!(bodies[0]["result"]["glider-1"]["result"], "pass");
    assert_eq!(bodies[0]["result"], bodies[0]["status"]);
    assert_eq!(bodies[4]["settings"]["duration"], 30.0);

    let bodies = responses(&Options::default(), &requests);
    assert!(bodies[0].get("result").is_none());
    assert_eq!([&bodies[1]["type"], &bodies[3]["type"]], ["ACK-NAK", "RTK-SURVEY"]);
}

/// The bodies with this type.
fn bodies(transcript: &[String], kind: &str) -> Vec<Value> {
    let messages = transcript.iter().filter_map(|text| serde_json::from_str::<Value>(text).ok());
    let mut bodies = messages.map(|mut message| message["body"].take());
    bodies.by_ref().filter(|body| body["type"] == kind).collect()
}

#[test]
fn sends_the_same_messages_for_the_same_calls() {
    assert!(transcript(None) == transcript(None));
}

#[test]
fn every_bug_changes_the_messages() {
    let correct = transcript(None);
    let step = extent(1, 5);
    let hidden = RULES.iter().step_by(step).filter(|rule| transcript(Some(rule)) == correct);
    let hidden: Vec<&str> = hidden.map(|rule| rule.rule.id).collect();
    let is_hidden = |id: &&str| NOT_OBSERVABLE.iter().any(|rule| rule.id == *id);
    let expected = RULES.iter().step_by(step).map(|rule| rule.rule.id).filter(is_hidden);
    assert_eq!(hidden, expected.collect::<Vec<&str>>());
}

#[test]
fn sends_valid_envelopes_without_a_bug() {
    let correct = transcript(None);
    let mut ids = Vec::new();
    let mut answered = Vec::new();
    for text in correct.iter().filter(|text| *text != "closed") {
        let message: Value = serde_json::from_str(text).expect("JSON");
        assert_eq!(message["$fw.version"], "1.0");
        ids.push(message["id"].as_str().expect("an id").to_owned());
        answered.extend(message.get("refs").map(|refs| refs.as_str().expect("an id").to_owned()));
        let body = message["body"].as_object().expect("a body");
        for state in body.get("status").and_then(Value::as_object).into_iter().flatten() {
            if body["type"] == "UAV-INF" {
                assert_eq!(state.1["id"], *state.0);
                assert!((0..3600).contains(&state.1["heading"].as_i64().expect("a heading")));
            }
        }
    }
    let count = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), count, "ids are unique");
    assert_eq!(answered.iter().filter(|refs| *refs == "höh 1").count(), 2, "the request was sent twice");
    assert_eq!(answered.len(), 46);
    assert_eq!(correct.last().map(String::as_str), Some("closed"));
}

#[test]
fn reports_the_end_of_each_operation_once() {
    let correct = transcript(None);
    let started = bodies(&correct, "UAV-TEST");
    assert_eq!(started[0]["receipt"], json!({ "glider-1": "r2" }));
    assert_eq!(started[0]["error"], json!({ "missing-1": "no such UAV" }));
    let ends = bodies(&correct, "ASYNC-RESP");
    let results: Vec<(&Value, bool)> =
        ends.iter().map(|end| (&end["id"], end.get("error").is_some())).collect();
    let expected = [json!("r4"), json!("r1"), json!("r2")];
    assert_eq!(results, [(&expected[0], true), (&expected[1], false), (&expected[2], false)]);
    assert_eq!(ends[1]["result"]["kind"], "text");
    let suspended = bodies(&correct, "ASYNC-ST").into_iter().filter(|body| body["suspended"] == json!(true));
    assert_eq!(suspended.map(|body| body["id"].clone()).collect::<Vec<_>>(), ["r3"]);
    let timeouts = bodies(&correct, "ASYNC-TIMEOUT");
    assert_eq!(timeouts, [json!({ "type": "ASYNC-TIMEOUT", "ids": ["r5"] })]);
    let resumed = bodies(&correct, "ASYNC-RESUME");
    assert_eq!(resumed[0]["success"], json!([]));
    let devices = bodies(&correct, "DEV-INF");
    assert!(devices.iter().any(|body| body["values"].get("/glider-1/gps/satellites").is_some()));
}

#[test]
fn rejects_other_requests_before_the_login() {
    let login = || Some(("pilot".to_owned(), "soar".to_owned()));
    for (bug, expected) in [(None, "ACK-NAK"), (Some(&ack_06::RULE), "UAV-LIST")] {
        let mut session = TestSession::new(bug, login());
        session.wait(2);
        assert!(session.take_received().is_empty(), "no notifications before the login");
        session.send_request("a", &json!({ "type": "UAV-LIST" }));
        assert_eq!(bodies(&session.take_received(), expected).len(), 1);
    }
    let mut session = TestSession::new(None, login());
    session.send_request("a", &json!({ "type": "AUTH-REQ", "method": "basic", "data": "cGlsb3Q6d3Jvbmc=" }));
    assert_eq!(bodies(&session.take_received(), "AUTH-RESP")[0]["result"], json!(false));
    session.send_request("b", &json!({ "type": "AUTH-REQ", "method": "basic", "data": "cGlsb3Q6c29hcg==" }));
    assert_eq!(bodies(&session.take_received(), "AUTH-RESP")[0]["user"], json!("pilot"));
    session.send_request("c", &json!({ "type": "UAV-LIST" }));
    assert_eq!(bodies(&session.take_received(), "UAV-LIST").len(), 1);
}

/// Types of requests, including invalid ones.
const KINDS: [&str; 61] = [
    "",
    "-",
    "ACK-ACK",
    "ASYNC-CANCEL",
    "ASYNC-RESUME",
    "AUTH-INF",
    "AUTH-REQ",
    "AUTH-WHOAMI",
    "BCN-INF",
    "BCN-PROPS",
    "CLK-INF",
    "CLK-LIST",
    "CONN-INF",
    "CONN-LIST",
    "DEV-INF",
    "DEV-LIST",
    "DEV-LISTSUB",
    "DEV-SUB",
    "DEV-UNSUB",
    "EXT-CFG",
    "EXT-INF",
    "EXT-LIST",
    "EXT-LOAD",
    "EXT-RELOAD",
    "EXT-SETCFG",
    "EXT-UNLOAD",
    "GLIDE-INF",
    "LOG-DATA",
    "LOG-INF",
    "OBJ-CMD",
    "OBJ-LIST",
    "PRM-GET",
    "PRM-SET",
    "PRM-SET-MANY",
    "RTK-INF",
    "RTK-LIST",
    "RTK-SOURCE",
    "RTK-STAT",
    "RTK-SURVEY",
    "SHOW-CFG",
    "SHOW-CRTH-START",
    "SHOW-LIGHTS",
    "SHOW-SETCFG",
    "SHOW-SETLIGHTS",
    "SYS-PING",
    "SYS-PORTS",
    "SYS-TIME",
    "SYS-VER",
    "UAV-CALIB",
    "UAV-FLY",
    "UAV-HALT",
    "UAV-INF",
    "UAV-MOTOR",
    "UAV-PREFLT",
    "UAV-RST",
    "UAV-SIGNAL",
    "UAV-SLEEP",
    "UAV-TAKEOFF",
    "UAV-TEST",
    "WTH-AT",
    "WTH-INF",
];

/// Fields of requests.
const FIELDS: [&str; 26] = [
    "adjustment",
    "args",
    "command",
    "component",
    "data",
    "duration",
    "filter",
    "force",
    "id",
    "ids",
    "includeSubtrees",
    "logId",
    "method",
    "name",
    "parameters",
    "pathFilter",
    "paths",
    "position",
    "removeAll",
    "settings",
    "signals",
    "start",
    "target",
    "transport",
    "uavId",
    "value",
];

/// Strings that are valid for at least one field.
const TEXTS: [&str; 14] = [
    "glider-1",
    "glider-2",
    "mark-1",
    "r1",
    "/",
    "/glider-1",
    "/glider-1/gps/position",
    "//",
    "compass",
    "base",
    "CRUISE_SPEED",
    "error",
    "lose",
    "\u{1fa82}",
];

fn value() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        prop::sample::select(&TEXTS[..]).prop_map(Value::from),
    ];
    leaf.prop_recursive(3, 20, 5, |inner| {
        let key = prop::sample::select([&TEXTS[..], &FIELDS[..]].concat()).prop_map(str::to_owned);
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..5).prop_map(Value::from),
            prop::collection::btree_map(key, inner, 0..5)
                .prop_map(|map| Value::Object(map.into_iter().collect())),
        ]
    })
}

fn body() -> impl Strategy<Value = Value> {
    let field = (prop::sample::select(&FIELDS[..]), value());
    (prop::sample::select(&KINDS[..]), prop::collection::vec(field, 0..4)).prop_map(|(kind, fields)| {
        let mut body = json!({ "type": kind, "ids": ["glider-1"], "paths": ["/glider-1"] });
        for (name, value) in fields {
            body[name] = value;
        }
        body
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(extent(256, 48)))]

    #[test]
    fn answers_each_request_once(
        bodies in prop::collection::vec(body(), 1..12),
        bug in prop::option::of(prop::sample::select(&RULES[..])),
    ) {
        let mut session = TestSession::new(bug, None);
        for (number, body) in bodies.iter().enumerate() {
            session.send_request(&number.to_string(), body);
            session.wait(1);
        }
        let received = session.take_received();
        if bug.is_none() {
            let messages = received.iter().map(|text| serde_json::from_str::<Value>(text).expect("JSON"));
            let refs: Vec<Value> = messages.filter_map(|message| message.get("refs").cloned()).collect();
            let expected: Vec<Value> = (0..bodies.len()).map(|number| json!(number.to_string())).collect();
            prop_assert_eq!(refs, expected);
        }
    }
}

#[test]
fn reports_a_server_that_stopped_because_of_an_internal_error() {
    let address = SocketAddr::from(([127, 0, 0, 1], 0));
    let handler = |_: &mut Hub, _: SessionId, _: Request| panic!("an expected panic of a test");
    let server =
        Server::start_with(Options::default(), &[(Transport::Tcp, address)], handler).expect("a server");
    let mut stream = TcpStream::connect(server.listening()[0].address).expect("a connection");
    let mut greeting = [0; 1];
    stream.read_exact(&mut greeting).expect("a greeting");
    assert!(!server.has_failed());
    stream
        .write_all(b"{\"$fw.version\":\"1.0\",\"id\":\"a\",\"body\":{\"type\":\"SYS-PING\"}}\n")
        .expect("a request");
    // The connection ends with the thread.
    let _ = stream.read_to_end(&mut Vec::new());
    wait_for("the failure is reported", || server.has_failed().then_some(()));
}

#[test]
fn accepts_any_rate() {
    for rate in [f64::MIN_POSITIVE, 1e-20, 1e-19, 1e-10] {
        let mut hub = Hub::new(Options { rate, ..Options::default() }, family::answer);
        let sink = Rc::new(RecordingSink::default());
        hub.open(ConnectionKind::Persistent, Rc::<RecordingSink>::clone(&sink));
        hub.advance(Duration::from_secs(1));
        let sent = sink.0.lock().unwrap_or_else(PoisonError::into_inner);
        assert!(!sent.iter().any(|text| text.contains("UAV-INF")), "{rate}");
    }
}

#[test]
fn limits_notifications_that_requests_cause() {
    let mut hub = Hub::new(Options { rate: 0.0, ..Options::default() }, family::answer);
    let sink = Rc::new(RecordingSink::default());
    let id = hub.open(ConnectionKind::Persistent, Rc::<RecordingSink>::clone(&sink));
    let mut elapsed = Duration::ZERO;
    for number in 0..40 {
        let preset = if number % 2 == 0 { json!("base") } else { Value::Null };
        let request =
            json!({ "$fw.version": "1.0", "id": "a", "body": { "type": "RTK-SOURCE", "id": preset } });
        hub.receive(id, request.to_string().as_bytes(), elapsed);
        elapsed += Duration::from_millis(50);
        hub.advance(elapsed);
    }
    let sent = sink.0.lock().unwrap_or_else(PoisonError::into_inner);
    let count = sent.iter().filter(|text| text.contains("CONN-INF")).count();
    assert_eq!(count, 4, "two per second");
}
