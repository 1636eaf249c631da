//! Tests of messages whose context is uncertain: before a gap in the recording, over UDP, from the client, or in
//! pieces.

use serde_json::{Value, json};
use uavspec_rules::flockwave::sample::Session;
use uavspec_rules::mutants;
use uavspec_rules::sample::Flight;
use uavspec_test_support::extent;

use super::{DEFINITIONS, checked, covered, ping, violated, violated_by};

type Part = fn(&mut Session);

fn uav_list(session: &mut Session) {
    session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": ["kite"] }));
}

fn obj_list(session: &mut Session) {
    session.exchange(json!({ "type": "OBJ-LIST" }), json!({ "ids": ["kite"] }));
}

fn filtered(session: &mut Session, kind: &str, ids: &[&str]) {
    session.exchange(json!({ "type": "OBJ-LIST", "filter": [kind] }), json!({ "ids": ids }));
}

fn version(session: &mut Session, version: &str) {
    let answer = json!({ "software": "Windward", "version": version, "name": "Hill", "revision": "b7" });
    session.exchange(json!({ "type": "SYS-VER" }), answer);
}

/// A gap in a recording.
const GAP: &[u8] = b"{\"t\":1790000001,\"conn\"\n";

/// The connection opens.
fn connect(session: &mut Session) {
    session.event("connect");
    if let Some(line) = session.lines.last_mut() {
        line["url"] = "tcp://hill:7001".into();
    }
}

/// Pairs of session parts. Each second part violates the rule, but only in combination with the first part.
fn contradictions() -> [(&'static str, Part, Part); 7] {
    [
        ("FW-OBJ-DEL-02", |session| session.notify(json!({ "type": "OBJ-DEL", "ids": ["kite"] })), uav_list),
        (
            "FW-OBJ-LIST-02",
            |session| filtered(session, "uav", &["kite"]),
            |session| filtered(session, "beacon", &["kite"]),
        ),
        (
            "FW-OBJ-LIST-04",
            |session| {
                obj_list(session);
                filtered(session, "beacon", &["mast"]);
            },
            obj_list,
        ),
        (
            "FW-UAV-LIST-02",
            |session| {
                uav_list(session);
                filtered(session, "uav", &["kite", "owl"]);
            },
            uav_list,
        ),
        (
            "FW-UAV-LIST-03",
            |session| {
                uav_list(session);
                let answer = json!({ "status": {}, "error": { "kite": "Unknown" } });
                session.exchange(json!({ "type": "UAV-INF", "ids": ["kite"] }), answer);
            },
            uav_list,
        ),
        ("FW-SYS-VER-04", |session| version(session, "3.1"), |session| version(session, "3.2")),
        ("FW-SYS-PORTS-02", connect, |session| {
            session.exchange(json!({ "type": "SYS-PORTS" }), json!({ "ports": { "tcp": 7002 } }));
        }),
    ]
}

/// The lost records may explain the difference.
#[test]
fn messages_before_a_gap_are_not_compared_with_later_messages() {
    for (id, before, after) in contradictions() {
        let count = |gap: &[u8]| {
            let mut session = Session::opened();
            before(&mut session);
            let mut bytes = session.to_bytes();
            bytes.extend(gap);
            session.lines.clear();
            after(&mut session);
            bytes.extend(session.to_bytes());
            violated(&checked(&bytes)).get(id).copied().unwrap_or_default()
        };
        assert_eq!((count(b""), count(GAP)), (1, 0), "{id}");
    }
}

/// Datagrams may get lost, or arrive in a different order.
#[test]
fn lists_over_udp_are_not_compared() {
    for (id, before, after) in contradictions().into_iter().filter(|(id, ..)| id.contains("LIST")) {
        let mut session = Session::opened();
        session.over("udp#1", |session| {
            before(session);
            after(session);
        });
        assert_eq!(violated_by(&session), [], "{id}");
    }
}

/// Adds a client message that refers to the last message of the server.
fn client_responds(session: &mut Session, body: &Value) {
    let refs = session.lines.last().map(|line| line["msg"]["id"].clone());
    session.sends(body.clone());
    if let Some(line) = session.lines.last_mut() {
        line["msg"]["refs"] = refs.into();
    }
}

#[test]
fn responses_of_the_client_are_not_checked() {
    let flight = Flight::new(&DEFINITIONS);
    let mut bodies: Vec<Value> = Vec::new();
    let mutants = mutants().filter(|mutant| mutant.rule.is_on_flockwave());
    for mutant in mutants.step_by(extent(1, 16)) {
        for (_, bytes) in mutant.captures(&flight) {
            let lines = bytes.split(|byte| *byte == b'\n');
            let lines = lines.filter_map(|line| serde_json::from_slice::<Value>(line).ok());
            bodies.extend(lines.filter(|line| line["dir"] == "in").map(|line| line["msg"]["body"].clone()));
        }
    }
    bodies.retain(Value::is_object);
    bodies.sort_by_key(ToString::to_string);
    bodies.dedup();
    assert!(bodies.len() > extent(200, 30), "{}", bodies.len());
    for bodies in bodies.chunks(20) {
        let mut session = Session::opened();
        for body in bodies {
            session.notify(ping());
            client_responds(&mut session, body);
        }
        assert_eq!(violated_by(&session), [], "{bodies:?}");
        assert_eq!(covered(&checked(&session.to_bytes()), "FW-ENV-16"), 0, "{bodies:?}");
    }
    // A client may answer twice, and a server needn't choose new ids for its requests.
    let mut session = Session::opened();
    session.notify(ping());
    session.notify(ping());
    let line = session.lines.last_mut().expect("a ping");
    line["msg"]["id"] = "say-1".into();
    for _ in 0..3 {
        session.sends(json!({ "type": "ACK-ACK" }));
        session.lines.last_mut().expect("an answer")["msg"]["refs"] = "say-1".into();
    }
    assert_eq!(violated_by(&session), []);
}

/// The server may parse such a request differently, so its answer can't be checked.
#[test]
fn answers_to_requests_that_parsers_read_differently_are_not_checked() {
    let request = |rest: &str| {
        format!("{{\"$fw.version\":\"1.0\",\"id\":\"ask-9\",\"body\":{{\"type\":\"SYS-PORTS\"}}{rest}")
    };
    let answer =
        "{\"$fw.version\":\"1.0\",\"id\":\"s9\",\"refs\":\"ask-9\",\"body\":{\"type\":\"SYS-PING\"}}";
    let violated = |text: &str, key: &str, is_answered: bool| {
        let mut session = Session::opened();
        let mut bytes = session.to_bytes();
        let text = if key == "raw" { Value::from(text).to_string() } else { text.to_owned() };
        let out = format!("{{\"t\":1790000100,\"conn\":\"hill\",\"dir\":\"out\",\"{key}\":{text}}}\n");
        let answer = format!("{{\"t\":1790000101,\"conn\":\"hill\",\"dir\":\"in\",\"msg\":{answer}}}\n");
        bytes.extend(out.as_bytes());
        if is_answered {
            bytes.extend(answer.as_bytes());
        }
        session.lines.clear();
        session.notify(json!({ "type": "OBJ-DEL", "ids": ["kite"] }));
        if let Some(line) = session.lines.last_mut() {
            line["t"] = 1_790_000_200.into();
        }
        bytes.extend(session.to_bytes());
        violated(&checked(&bytes)).into_keys().collect::<Vec<_>>()
    };
    for key in ["msg", "raw"] {
        assert_eq!(violated(&request("}"), key, true), ["FW-ENV-16"], "{key}");
        assert_eq!(violated(&request("}"), key, false), ["FW-ENV-07"], "{key}");
        for rest in [",\"body\":{\"type\":\"SYS-PING\"}}", ",\"name\":{\"a\":1,\"a\":1}}"] {
            assert_eq!(violated(&request(rest), key, true), Vec::<&str>::new(), "{key} {rest}");
            assert_eq!(violated(&request(rest), key, false), Vec::<&str>::new(), "{key} {rest}");
        }
    }
    for rest in ["}]", ",\"name\":\"\u{fffd}\"}"] {
        for is_answered in [false, true] {
            let found = violated(&request(rest), "raw", is_answered);
            assert_eq!(found, Vec::<&str>::new(), "{rest} {is_answered}");
        }
    }
}

/// A message from the server that is split into lines.
fn pieces(session: &mut Session, number: usize) {
    session.send_raw("{\"$fw.version\":\"1.0\",\"id\":\"long-1\",");
    for _ in 2..number {
        session.send_raw("");
    }
    session.send_raw("\"body\":{\"type\":\"SYS-PING\"}}");
}

/// The numbers of violations of `FW-TCP-01` and `FW-ENV-01` over TCP.
fn split_and_other(add: impl FnOnce(&mut Session)) -> (u64, u64) {
    let mut session = Session::opened();
    session.over("tcp#9", add);
    let found = violated(&checked(&session.to_bytes()));
    let count = |id| found.get(id).copied().unwrap_or_default();
    (count("FW-TCP-01"), count("FW-ENV-01"))
}

#[test]
fn a_message_in_many_lines_is_one_violation_up_to_a_limit() {
    assert_eq!(split_and_other(|session| pieces(session, 2)), (1, 0));
    assert_eq!(split_and_other(|session| pieces(session, 10_000)), (1, 0));
    let (split, other) = split_and_other(|session| pieces(session, 10_001));
    assert_eq!((split, other > 0), (0, true));
    let long = |size: usize| {
        split_and_other(|session| {
            // The lines end with line feeds.
            session.send_raw(&format!("{{\"body\":\"{}\"", "x".repeat(size - 13)));
            session.send_raw("}");
        })
    };
    assert_eq!(long(1 << 20), (1, 0));
    assert_eq!(long((1 << 20) + 1).0, 0);
}

#[test]
fn pieces_before_and_after_a_gap_are_not_one_message() {
    let mut session = Session::opened();
    session.over("tcp#9", |session| session.send_raw("{\"body\":"));
    session.lines.pop();
    let mut bytes = session.to_bytes();
    bytes.extend(GAP);
    session.lines.clear();
    session.over("tcp#9", |session| session.send_raw("{}}"));
    session.lines.remove(0);
    bytes.extend(session.to_bytes());
    let found: Vec<_> = violated(&checked(&bytes)).into_iter().collect();
    assert_eq!(found, [("FW-ENV-01", 2)]);
}

#[test]
fn client_messages_do_not_interrupt_a_message_in_pieces() {
    let found = split_and_other(|session| {
        session.send_raw("{\"body\":");
        session.sends(json!({ "type": "SYS-PING" }));
        session.send_raw("{}}");
    });
    assert_eq!(found, (1, 0));
    let found = split_and_other(|session| {
        session.send_raw("{\"body\":");
        session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
        session.send_raw("{}}");
    });
    assert_eq!(found, (0, 2));
}

#[test]
fn messages_in_pieces_on_several_connections_are_separate() {
    let mut session = Session::opened();
    let begin = |session: &mut Session| session.send_raw("{\"body\":");
    let end = |session: &mut Session| session.send_raw("{}}");
    session.over("tcp#1", begin);
    session.over("tcp#2", begin);
    session.over("tcp#1", end);
    session.over("tcp#2", end);
    session.lines.retain(|line| line["event"].is_null() || line["conn"] == "hill");
    let found = violated(&checked(&session.to_bytes()));
    assert_eq!(found.get("FW-TCP-01"), Some(&2), "{found:?}");
}

#[test]
fn an_unfinished_message_is_a_violation_unless_the_client_leaves() {
    let ends = |reason: Option<&str>| {
        let mut session = Session::opened();
        session.over("tcp#9", |session| {
            session.send_raw("{\"body\":");
            session.sends(ping());
        });
        match reason {
            Some(reason) => session.lines.last_mut().expect("an event")["why"] = reason.into(),
            None => _ = session.lines.pop(),
        }
        violated(&checked(&session.to_bytes())).get("FW-ENV-01").copied().unwrap_or_default()
    };
    assert_eq!((ends(Some("eof")), ends(None), ends(Some("client"))), (1, 1, 0));
}

/// A part of the specification allows fractions of milliseconds.
#[test]
fn fractions_of_times_are_disputed() {
    for body in [
        json!({ "type": "CLK-INF", "status": { "day": { "id": "day", "retrievedAt": 1.5, "running": true, "ticks": 5 } } }),
        json!({ "type": "SYS-MSG", "items": [{ "message": "Wind", "severity": "info", "timestamp": 1.5 }] }),
    ] {
        let mut session = Session::opened();
        session.notify(body.clone());
        assert_eq!(violated_by(&session), [("FW-ENV-26", 1)], "{body}");
    }
}

/// The value is disputed only as the longitude 180°.
#[test]
fn other_values_of_1800000000_are_wrong() {
    let session = Session::new().state(|kite| kite["attitude"] = json!([0, 1_800_000_000, 0]));
    assert_eq!(violated_by(&session.expect("a state")), [("FW-UST-ATTITUDE", 1)]);
}

#[test]
fn objects_may_have_many_members() {
    let members: serde_json::Map<String, Value> = (0..200).map(|at| (format!("m{at}"), json!(at))).collect();
    let mut session = Session::opened();
    session.exchange(json!({ "type": "SOAR-INF" }), Value::Object(members));
    assert_eq!(violated_by(&session), []);
}

#[test]
fn a_huge_time_is_implausible() {
    let mut session = Session::opened();
    let link =
        json!({ "id": "winch", "purpose": "uavRadioLink", "status": "connected", "timestamp": 123_456_789 });
    session.notify(json!({ "type": "CONN-INF", "status": { "winch": link } }));
    let text = String::from_utf8(session.to_bytes()).expect("JSON");
    for huge in ["123456789", "1e999", &"9".repeat(60)] {
        let found = violated(&checked(text.replace("123456789", huge).as_bytes()));
        assert_eq!(found.get("FW-VAL-01"), Some(&1), "{huge}: {found:?}");
    }
}
