//! Tests of servers that stop responding, servers that fail over HTTP, and faults with a common cause.

use serde_json::{Value, json};
use uavspec_rules::flockwave::sample::Session;
use uavspec_rules::flockwave::{env_07, env_22, env_24, env_27};

use super::{checked, done, ping, violated_by};

/// The messages of the findings of a rule.
fn messages(session: &Session, id: &str) -> Vec<String> {
    let result = checked(&session.to_bytes());
    let groups = result.findings.groups().filter(|group| group.rule.id == id);
    groups.flat_map(|group| &group.examples).map(|(_, detail)| detail.to_string()).collect()
}

fn states() -> Value {
    json!({ "type": "UAV-INF", "status": { "kite": { "id": "kite", "timestamp": 1_790_000_000_000_i64 } } })
}

/// A server that is being shut down may accept a connection and then close it.
#[test]
fn a_family_with_a_served_request_has_a_handler_whatever_happens_later() {
    let mut session = Session::opened();
    let request = || json!({ "type": "UAV-INF", "ids": ["kite"] });
    session.tries_and_receives(&env_24::RULE.rule, "", request(), states());
    session.closed("eof");
    session.event("connect");
    session.tries(&env_24::RULE.rule, "", request());
    session.closed("eof");
    session.event("refused");
    assert_eq!(violated_by(&session), []);
}

#[test]
fn reports_a_closed_connection_in_place_of_the_first_response() {
    let mut session = Session::opened();
    session.exchange_with(ping(), done()["body"].clone());
    session.tries(&env_24::RULE.rule, "", json!({ "type": "UAV-LIST" }));
    session.closed("eof");
    assert_eq!(violated_by(&session), [("FW-ENV-07", 1)]);
}

#[test]
fn names_the_message_that_ended_the_service() {
    for connection in ["tcp#1", "udp#1", "http#1", "socketio#1"] {
        let mut session = Session::opened();
        session.over(connection, |session| {
            session.exchange_with(ping(), done()["body"].clone());
            session.sends_raw("not a glider");
        });
        session.over("tcp#2", |session| session.refused(&env_27::RULE.rule, "after a trial: one", "refused"));
        assert_eq!(violated_by(&session), [("FW-ENV-27", 1)], "{connection}");
        let found = messages(&session, "FW-ENV-27");
        assert!(found[0].ends_with("the service ended after `not a glider`"), "{found:?}");
    }
}

/// A session in which one of two messages ended the service over this connection. Then, the server responds again, and
/// `again` adds messages on another connection.
fn unclear(connection: &'static str, again: impl FnOnce(&mut Session)) -> Session {
    let mut session = Session::opened();
    session.over(connection, |session| {
        session.exchange_with(ping(), done()["body"].clone());
        session.sends_raw("one wind");
        session.sends_raw("two winds");
    });
    session.over("tcp#2", |session| session.refused(&env_27::RULE.rule, "after a trial: one", "refused"));
    session.over("tcp#3", |session| {
        session.exchange_with(ping(), done()["body"].clone());
        again(session);
    });
    session
}

/// Sends a message alone. If `is_served` is true, the server answers the next request.
fn sends_alone(session: &mut Session, message: &str, is_served: bool) {
    let (rule, how) = (&env_27::RULE.rule, "after a trial: one, sent alone");
    session.sends_raw(message);
    if is_served {
        session.tries_and_receives(rule, how, ping(), done()["body"].clone());
    } else {
        session.refused(rule, how, "refused");
    }
}

#[test]
fn names_the_message_that_ended_the_service_again_when_it_was_sent_alone() {
    for connection in ["tcp#1", "udp#1", "http#1", "socketio#1"] {
        for (are_served, end) in [
            (&[][..], "after `one wind` or the message after it"),
            (&[false], "after `one wind`"),
            (&[true], "after `one wind` or the message after it"),
            (&[true, false], "after `two winds`"),
            (&[true, true], "or the message after it; sent alone, none of them ended the service"),
        ] {
            let session = unclear(connection, |session| {
                for (message, is_served) in ["one wind", "two winds"].into_iter().zip(are_served) {
                    sends_alone(session, message, *is_served);
                }
            });
            assert_eq!(violated_by(&session), [("FW-ENV-27", 1)], "{connection}");
            let found = messages(&session, "FW-ENV-27");
            assert!(found[0].ends_with(end), "{connection}, {are_served:?}: {found:?}");
        }
    }
}

/// The last message was not followed by a request that the server answered.
#[test]
fn an_interrupted_probe_does_not_clear_the_last_suspect() {
    let session = unclear("tcp#1", |session| {
        sends_alone(session, "one wind", true);
        session.sends_raw("two winds");
    });
    assert!(messages(&session, "FW-ENV-27")[0].ends_with("after `one wind` or the message after it"));
}

/// The server reads the messages of an ordered connection in order.
#[test]
fn a_response_clears_only_the_messages_before_its_request() {
    for (connection, expected) in [("tcp#1", &[("FW-ENV-27", 1)][..]), ("udp#1", &[])] {
        let mut session = Session::opened();
        session.over(connection, |session| {
            session.sends_raw("one wind");
            let id = session.sends(ping());
            session.sends_raw("two winds");
            session.answers(&id, done());
        });
        session.over("tcp#2", |session| session.refused(&env_27::RULE.rule, "after a trial: one", "refused"));
        assert_eq!(violated_by(&session), expected, "{connection}");
        let found = messages(&session, "FW-ENV-27");
        assert!(found.iter().all(|text| text.ends_with("the service ended after `two winds`")), "{found:?}");
    }
}

/// Messages that were sent after the service ended aren't suspects.
#[test]
fn only_messages_before_the_end_of_the_service_are_suspects() {
    let mut session = Session::opened();
    session.exchange_with(ping(), done()["body"].clone());
    session.sends_raw("not a glider");
    session.closed("connection refused: no server listens");
    session.over("udp#2", |session| session.sends_raw("no message either"));
    let mut lines = session.lines.clone();
    session.over("udp#3", |session| {
        session.tries(&env_27::RULE.rule, "after a trial: two", ping());
    });
    if let Some(line) = session.lines.last_mut() {
        line["why"] = "connection refused: no server listens".into();
    }
    assert_eq!(violated_by(&session), [("FW-ENV-27", 1)]);
    assert!(messages(&session, "FW-ENV-27")[0].ends_with("after `not a glider`"));
    // Over UDP, a missing response alone proves nothing.
    lines.extend(session.lines[lines.len()..].iter().cloned());
    if let Some(line) = lines.last_mut() {
        line["why"] = "client".into();
    }
    session.lines = lines;
    assert_eq!(violated_by(&session), []);
}

/// The server stops without a cause in the session.
#[test]
fn a_service_that_ends_without_a_message_violates_nothing() {
    let mut session = Session::opened();
    session.exchange_with(ping(), done()["body"].clone());
    session.closed("eof");
    session.over("tcp#2", |session| {
        session.sends(json!({ "type": "SYS-VER" }));
        session.closed("eof");
    });
    session.over("tcp#3", |session| session.refused(&env_27::RULE.rule, "by itself", "refused"));
    assert_eq!(violated_by(&session), []);
}

#[test]
fn a_failed_request_over_http_has_no_response() {
    let mut session = Session::opened();
    session.over("http#1", |session| {
        session.tries(&env_07::RULE.rule, "", json!({ "type": "UAV-LIST" }));
        session.failed(&env_07::RULE.rule, "", "HTTP status 500 Internal Server Error");
        let id = session.tries(&env_07::RULE.rule, "", json!({ "type": "SYS-PING" }));
        session.answers(&id, done());
        // There is neither an answer nor a reason.
        session.tries(&env_07::RULE.rule, "", json!({ "type": "OBJ-LIST" }));
    });
    assert_eq!(violated_by(&session), [("FW-ENV-07", 2)]);
    let found = messages(&session, "FW-ENV-07").join(" ");
    assert!(found.contains("HTTP status 500"), "{found}");
}

#[test]
fn a_malformed_message_that_fails_over_http_is_shown() {
    let mut session = Session::opened();
    session.over("http#1", |session| {
        session.sends_raw("{}");
        session.failed(&env_22::RULE.rule, "an empty object", "timed out");
    });
    assert_eq!(violated_by(&session), [("FW-ENV-22", 1)]);
}

#[test]
fn weather_in_seconds_has_one_finding() {
    let mut session = Session::opened();
    let weather = json!({ "position": [465_410_000, 115_520_000], "timestamp": 1_790_000_000.25 });
    let location = json!({ "type": "WTH-AT", "position": [465_410_000, 115_520_000] });
    session.exchange(location, json!({ "weather": weather }));
    session.exchange(json!({ "type": "WTH-INF", "ids": ["mast"] }), json!({ "status": { "mast": weather } }));
    let result = checked(&session.to_bytes());
    let found: Vec<_> = result.findings.groups().map(|group| (group.rule.id, group.count)).collect();
    assert_eq!(found, [("FW-WTH-01", 2)]);
}

#[test]
fn data_in_an_undefined_field_has_one_finding() {
    let mut session = Session::opened();
    let data = json!({ "result": { "kite": {} }, "error": { "swift": "Asleep" } });
    session.exchange(json!({ "type": "UAV-PREFLT", "ids": ["kite", "swift"] }), data);
    assert_eq!(violated_by(&session), [("FW-INF-01", 1)]);
    let found = messages(&session, "FW-INF-01");
    assert!(found[0].ends_with("found `kite` in `result`, which is not defined"), "{found:?}");
    // A field that doesn't contain the requested object is a separate cause.
    let mut session = Session::opened();
    let data = json!({ "wind": { "gust": {} }, "error": { "kite": "Asleep" } });
    session.exchange(json!({ "type": "UAV-PREFLT", "ids": ["kite"] }), data);
    assert_eq!(violated_by(&session), [("FW-ENV-18", 1)]);
}

/// For each finding of a rule, true if the finding is disputed.
fn disputed(session: &Session, id: &str) -> Vec<bool> {
    let result = checked(&session.to_bytes());
    let groups = result.findings.groups().filter(|group| group.rule.id == id);
    groups.map(|group| group.examples[0].1.is_disputed).collect()
}

#[test]
fn only_the_cases_of_a_contradiction_are_disputed() {
    let codes = |codes: [u8; 2]| {
        let mut session = Session::opened();
        let mut body = states();
        body["status"]["kite"]["errors"] = json!(codes);
        session.notify(body);
        session
    };
    assert_eq!(disputed(&codes([66, 134]), "FW-ERR-07"), [false]);
    assert_eq!(disputed(&codes([65, 132]), "FW-ERR-07"), [true]);
    let mut session = Session::opened();
    let land = || json!({ "type": "UAV-LAND", "ids": ["kite"] });
    session.exchange(land(), json!({ "result": { "kite": null } }));
    assert_eq!(disputed(&session, "FW-ASY-22"), [false]);
    let mut session = Session::opened();
    session.exchange(land(), json!({ "receipt": { "kite": "r1" } }));
    session.notify(json!({ "type": "ASYNC-RESP", "id": "r1", "result": 7 }));
    assert_eq!(disputed(&session, "FW-ASY-22"), [true]);
}
