//! Tests that valid sessions have no findings, and that one cause results in one finding.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use uavspec_check::FlockwaveChecker;
use uavspec_rules::flockwave::sample::Session;

use super::{DEFINITIONS, checked, covered, done, on_connection, ping, violated, violated_by, with_lines};

/// A session in which the client's next message is recorded as these separate texts.
fn sent(session: &mut Session, texts: &[&str]) {
    let time = 1_790_000_000.0;
    let line = |text: &&str| json!({ "t": time, "conn": "hill", "dir": "out", "raw": text });
    session.lines.extend(texts.iter().map(line));
}

fn request(id: &str) -> String {
    json!({ "$fw.version": "1.0", "id": id, "body": ping() }).to_string()
}

/// The findings of a session: the rule, the subject and the count.
fn groups(session: &Session) -> Vec<(&'static str, String, u64)> {
    let result = checked(&session.to_bytes());
    result.findings.groups().map(|group| (group.rule.id, group.subject.clone(), group.count)).collect()
}

#[test]
fn joins_requests_that_were_recorded_in_pieces() {
    let (one, two) = (request("one"), request("two"));
    let (first, second) = one.split_at(25);
    let together = format!("{one}\n{two}\n");
    let (start, end) = together.split_at(one.len() + 20);
    for texts in [&[first, second, &two][..], &[&together], &[&one, "\n", &two], &[start, end]] {
        let mut session = Session::opened();
        sent(&mut session, texts);
        session.answers("one", done());
        session.answers("two", done());
        session.answers("three", done());
        assert_eq!(violated_by(&session), [("FW-ENV-06", 1)], "{texts:?}");
    }
}

#[test]
fn pieces_may_be_separated_by_messages_from_the_server() {
    let one = request("one");
    let (first, second) = one.split_at(25);
    let mut session = Session::opened();
    sent(&mut session, &[first]);
    session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
    sent(&mut session, &[second]);
    session.answers("one", done());
    session.answers("two", done());
    assert_eq!(violated_by(&session), [("FW-ENV-06", 1)]);
}

#[test]
fn unreadable_requests_make_references_unclear() {
    let one = request("one");
    for text in ["{\"id\":one}\n", "{\"id\":\"one", &one[..40], "[1]", "(not UTF-8) \u{fffd}"] {
        let mut session = Session::opened();
        sent(&mut session, &[text]);
        session.answers("one", done());
        assert_eq!(violated_by(&session), [], "{text}");
        session.sends(ping());
        session.answers("one", done());
        assert_eq!(violated_by(&session), [], "{text}");
    }
}

#[test]
fn a_server_may_refuse_a_response_of_the_client() {
    let mut session = Session::opened();
    session.notify(ping());
    let answer =
        json!({ "$fw.version": "1.0", "id": "here-1", "refs": "say-1", "body": { "type": "UAV-LIST" } });
    session.lines.push(json!({ "t": 1_790_000_000.2, "conn": "hill", "dir": "out", "msg": answer }));
    session.answers("here-1", json!({ "body": { "type": "ACK-NAK" } }));
    assert_eq!(violated_by(&session), []);
}

#[test]
fn a_server_may_copy_an_unusual_id() {
    for id in [json!(17), json!(null), json!(""), json!("x".repeat(65)), json!({})] {
        let mut session = Session::opened();
        session.sends(ping());
        if let Some(line) = session.lines.last_mut() {
            line["msg"]["id"] = id.clone();
        }
        session.answers("", json!({ "refs": id, "body": { "type": "ACK-NAK" } }));
        let expected = if id.is_string() { vec![] } else { vec![("FW-ENV-05I", 1)] };
        assert_eq!(violated_by(&session), expected, "{id}");
        assert!(checked(&session.to_bytes()).coverage.is_full(), "{id}");
    }
}

/// If a client sends a message without a valid id, the server's refusal can't refer to an id.
#[test]
fn a_capture_may_lack_a_message_without_a_valid_id() {
    for refs in [None, Some(json!(null)), Some(json!(17)), Some(json!({}))] {
        let mut session = Session::opened();
        session.notify(json!({ "type": "ACK-NAK", "reason": "The id is missing" }));
        if let (Some(line), Some(refs)) = (session.lines.last_mut(), &refs) {
            line["msg"]["refs"] = refs.clone();
        }
        assert_eq!(violated_by(&session).len(), 1, "{refs:?}: the client has sent nothing");
        let [opened, refusal] = &session.lines[..] else { panic!("two lines") };
        for before in
            [String::new(), format!("{opened}\nno JSON"), opened.to_string().replace("connect", "closed")]
        {
            let result = checked(format!("{before}\n{refusal}\n").as_bytes());
            assert_eq!(violated(&result), BTreeMap::new(), "{refs:?} after {before}");
        }
        assert_eq!(violated_by(&with_lines(on_connection("udp#1", &session))), [], "{refs:?}");
    }
}

#[test]
fn one_null_has_one_finding() {
    let answered = |change: fn(&mut Value)| {
        let mut session = Session::opened();
        session.exchange_with(ping(), json!({ "type": "ACK-ACK" }));
        if let Some(line) = session.lines.last_mut() {
            change(&mut line["msg"]);
        }
        violated_by(&session)
    };
    let disputed = [("FW-ENV-26", 1)];
    assert_eq!(answered(|message| message["refs"] = Value::Null), disputed);
    assert_eq!(answered(|message| message["error"] = Value::Null), disputed);
    assert_eq!(answered(|message| message["id"] = Value::Null), [("FW-ENV-03", 1)]);
    assert_eq!(answered(|message| message["body"] = Value::Null), [("FW-ENV-11", 1)]);
    assert_eq!(answered(|message| message["body"]["type"] = Value::Null), [("FW-ENV-14", 1)]);
    assert_eq!(answered(|message| message["body"] = json!({ "type": "SYS-PING" })), [("FW-SYS-PING-02", 1)]);
    let without_refs = |message: &mut Value| _ = message.as_object_mut().and_then(|all| all.remove("refs"));
    assert_eq!(answered(without_refs), [("FW-ACK-01", 1)]);
    let mut session = Session::opened();
    let login = json!({ "type": "AUTH-REQ", "method": "basic", "data": "d2luZA==" });
    session.exchange_with(login, json!({ "type": "AUTH-RESP", "result": true, "user": null }));
    assert_eq!(violated_by(&session), disputed);
    let mut session = Session::opened();
    let location = json!({ "type": "WTH-AT", "position": [465_410_000, 115_520_000] });
    session.exchange(location, json!({ "weather": null }));
    assert_eq!(violated_by(&session), disputed);
}

#[test]
fn findings_do_not_show_the_password_of_a_login() {
    let mut session = Session::opened();
    let login = json!({ "type": "AUTH-REQ", "method": "basic", "data": "d2luZA==" });
    session.exchange_with(login, json!({ "type": "AUTH-RESP", "result": 1 }));
    let shown = format!("{:?}", checked(&session.to_bytes()).findings);
    assert!(shown.contains(r#"{\"type\": \"AUTH-REQ\", \"method\": \"basic\", …}"#), "{shown}");
    assert!(!shown.contains("d2luZA=="), "{shown}");
}

#[test]
fn errors_in_envelopes_are_checked() {
    let answered = |error: Value| {
        let mut session = Session::opened();
        let id = session.sends(json!({ "type": "LCN-INF" }));
        session.answers(&id, json!({ "error": error }));
        violated_by(&session)
    };
    assert_eq!(answered(json!({ "code": 3, "message": "No" })), []);
    assert_eq!(answered(json!({ "code": "three" })), [("FW-ENV-12J", 1)]);
    assert_eq!(answered(json!({ "code": 3, "message": 4 })), [("FW-ENV-12J", 1)]);
    assert_eq!(answered(json!({ "code": null, "message": "No" })), [("FW-ENV-26", 1)]);
    assert_eq!(answered(json!({ "code": null })), [("FW-ENV-12", 1)]);
    assert_eq!(answered(json!("No")), [("FW-ENV-12", 1)]);
}

#[test]
fn results_of_operations_are_grouped_by_command() {
    let mut session = Session::opened();
    for (at, command) in ["UAV-LAND", "UAV-TAKEOFF", "UAV-LAND"].into_iter().enumerate() {
        let receipt = format!("r-{at}");
        let request = json!({ "type": command, "ids": ["kite"] });
        session.exchange(request, json!({ "receipt": { "kite": receipt } }));
        session.notify(json!({ "type": "ASYNC-RESP", "id": receipt, "result": null }));
    }
    let expected = [("ASYNC-RESP of UAV-LAND", 2), ("ASYNC-RESP of UAV-TAKEOFF", 1)];
    assert_eq!(groups(&session), expected.map(|(subject, count)| ("FW-ASY-22", subject.to_owned(), count)));
}

#[test]
fn accepts_what_the_descriptions_of_messages_allow() {
    let mut session = Session::opened();
    // ACK-ACK may replace a response that has no required fields, but no other response.
    session.exchange_with(json!({ "type": "RTK-SURVEY" }), json!({ "type": "ACK-ACK" }));
    session.notify(json!({ "type": "OBJ-CMD", "result": { "kite": "Flaps out" } }));
    let paths = json!({ "type": "DEV-UNSUB", "paths": ["/kite"], "includeSubtrees": true });
    session.exchange(paths, json!({ "success": ["/kite/vario"] }));
    assert_eq!(violated_by(&session), []);
    session.exchange_with(json!({ "type": "CONN-LIST" }), json!({ "type": "ACK-ACK" }));
    let paths = json!({ "type": "DEV-UNSUB", "paths": ["/kite"] });
    session.exchange(paths, json!({ "success": ["/kite/vario"] }));
    assert_eq!(violated_by(&session), [("FW-DEV-01", 1), ("FW-ENV-16", 1)]);
    let mut session = Session::opened();
    session.exchange_with(json!({ "type": "RTK-SURVEY" }), json!({ "type": "UAV-LIST", "ids": [] }));
    assert_eq!(violated_by(&session), [("FW-ENV-16", 1)]);
}

/// An empty filter may mean all types or none.
#[test]
fn lists_with_an_empty_filter_are_not_compared() {
    let mut session = Session::opened();
    let objects = |session: &mut Session, mut request: Value, ids: &[&str]| {
        request["type"] = "OBJ-LIST".into();
        session.exchange(request, json!({ "ids": ids }));
    };
    objects(&mut session, json!({}), &["kite"]);
    objects(&mut session, json!({ "filter": [] }), &["mast"]);
    objects(&mut session, json!({}), &["kite"]);
    assert_eq!(violated_by(&session), []);
    objects(&mut session, json!({ "filter": ["beacon"] }), &["mast"]);
    objects(&mut session, json!({}), &["kite"]);
    assert_eq!(violated_by(&session), [("FW-OBJ-LIST-04", 1)]);
}

/// Most checks skip the content of status reports that they have seen before.
#[test]
fn status_reports_are_messages_like_all_others() {
    let report = |session: &mut Session| {
        let state = json!({ "id": "kite", "timestamp": 1_790_000_000_000_u64 });
        session.notify(json!({ "type": "UAV-INF", "status": { "kite": state } }));
    };
    for (connection, rule) in [("tcp#1", "FW-TCP-01"), ("udp#1", "FW-UDP-01")] {
        let mut session = Session::opened();
        session.over(connection, |session| {
            session.sends(ping());
            (0..4).for_each(|_| report(session));
        });
        let result = checked(&session.to_bytes());
        assert_eq!(violated(&result).into_iter().collect::<Vec<_>>(), []);
        let counts = ["FW-ENV-01", "FW-TCP-01", "FW-UDP-01"].map(|rule| (rule, covered(&result, rule)));
        let expected = ["FW-ENV-01", rule].map(|rule| (rule, 4));
        assert!(
            counts.iter().all(|(id, count)| expected.contains(&(id, *count)) || *count == 0),
            "{counts:?}"
        );
        assert!(expected.iter().all(|pair| counts.contains(pair)), "{counts:?}");
    }
    let mut session = Session::opened();
    report(&mut session);
    report(&mut session);
    session.lines.last_mut().expect("a report")["msg"]["id"] = "say-1".into();
    assert_eq!(violated_by(&session), [("FW-ENV-04", 1)]);
    let result = checked(&session.to_bytes());
    let detail = &result.findings.groups().next().expect("a finding").examples[0].1;
    assert!(detail.to_string().contains("`say-1`"), "{detail}");
    session.notify(json!({ "type": "SYS-CLOSE", "reason": "Sunset" }));
    report(&mut session);
    assert_eq!(violated_by(&session), [("FW-ENV-04", 1), ("FW-SYS-CLOSE-02", 1)]);
}

/// Timestamps in responses and reports must not go back or be in the future. The server's clock may be wrong.
#[test]
fn timestamps_are_compared_with_earlier_timestamps_and_with_the_clock() {
    let stated = |ahead: u64, moves: [i64; 2], is_report: bool| {
        let mut session = Session::opened();
        let time = json!({ "timestamp": session.now() + ahead });
        session.exchange(json!({ "type": "SYS-TIME" }), time);
        for by in moves {
            let state =
                json!({ "id": "kite", "timestamp": (session.now() + ahead).saturating_add_signed(by) });
            let status = json!({ "type": "UAV-INF", "status": { "kite": state } });
            if is_report {
                session.notify(status);
            } else {
                session.exchange_with(json!({ "type": "UAV-INF", "ids": ["kite"] }), status);
            }
        }
        violated_by(&session)
    };
    for (ahead, is_report) in [(0, false), (0, true), (3_600_000, false), (3_600_000, true)] {
        assert_eq!(stated(ahead, [0, 0], is_report), [], "{ahead}");
        assert_eq!(stated(ahead, [0, -9000], is_report), [("FW-UAV-INF-08", 1)], "{ahead}");
        assert_eq!(stated(ahead, [0, 9000], is_report), [("FW-UAV-INF-09", 1)], "{ahead}");
    }
}

/// Adds a status report with this timestamp.
fn report(session: &mut Session, timestamp: u64) {
    let state = json!({ "id": "kite", "timestamp": timestamp });
    session.notify(json!({ "type": "UAV-INF", "status": { "kite": state } }));
}

/// The states may still have timestamps from before the adjustment.
#[test]
fn timestamps_are_not_compared_after_an_adjustment_of_the_clock() {
    let mut session = Session::opened();
    let (before, after) = (session.now(), session.now() - 3_600_000);
    report(&mut session, before);
    let adjustment = json!({ "type": "SYS-TIME", "adjustment": -3_600_000 });
    session.exchange(adjustment, json!({ "timestamp": after + 90 }));
    report(&mut session, before);
    report(&mut session, after);
    assert_eq!(violated_by(&session), []);
}

#[test]
fn timestamps_are_compared_after_the_clock_is_set_forward() {
    for adjustment in [json!(3_600_000), json!(0.5)] {
        let mut session = Session::opened();
        let now = session.now();
        report(&mut session, now);
        session.sends(json!({ "type": "SYS-TIME", "adjustment": adjustment }));
        report(&mut session, now - 60_000);
        assert_eq!(violated_by(&session), [("FW-UAV-INF-08", 1)], "{adjustment}");
    }
}

/// An hour, in milliseconds.
const HOUR: u64 = 3_600_000;

/// Adds a SYS-TIME response. `ahead` is the time by which the server's clock is ahead, in milliseconds.
fn answers_time(session: &mut Session, id: &str, ahead: u64) {
    let timestamp = session.now() + ahead;
    session.answers(id, json!({ "body": { "type": "SYS-TIME", "timestamp": timestamp } }));
}

/// Adds a SYS-TIME query and its response. `ahead` is the time by which the server's clock is ahead, in milliseconds.
fn queries_time(session: &mut Session, ahead: u64) {
    let id = session.sends(json!({ "type": "SYS-TIME" }));
    answers_time(session, &id, ahead);
}

/// Adds two SYS-TIME queries, between which the server's clock jumps. `ahead` is the time by which the clock is ahead
/// before the jump, in milliseconds.
fn clock_jumps(session: &mut Session, ahead: u64) {
    queries_time(session, ahead);
    queries_time(session, ahead + HOUR);
}

/// Adds a request that sets the server's clock forward by an hour. Returns the id of the request.
fn adjusts_clock(session: &mut Session) -> String {
    session.sends(json!({ "type": "SYS-TIME", "adjustment": HOUR }))
}

/// Adds a status report whose timestamp is ahead by `ahead` milliseconds.
fn report_ahead(session: &mut Session, ahead: u64) {
    let timestamp = session.now() + ahead;
    report(session, timestamp);
}

/// The server may handle requests in any order, and may send the answers in any order.
#[test]
fn answers_from_before_an_adjustment_do_not_state_the_time_after_it() {
    for (is_sent_first, is_answered_first) in [(true, true), (true, false), (false, true), (false, false)] {
        let mut session = Session::opened();
        let queries = |session: &mut Session| session.sends(json!({ "type": "SYS-TIME" }));
        let early = is_sent_first.then(|| queries(&mut session));
        let adjustment = adjusts_clock(&mut session);
        let query = early.unwrap_or_else(|| queries(&mut session));
        if is_answered_first {
            answers_time(&mut session, &query, 0);
            report_ahead(&mut session, HOUR);
            answers_time(&mut session, &adjustment, HOUR);
        } else {
            answers_time(&mut session, &adjustment, HOUR);
            answers_time(&mut session, &query, 0);
        }
        report_ahead(&mut session, HOUR);
        let case = format!("sent first: {is_sent_first}, answered first: {is_answered_first}");
        assert_eq!(violated_by(&session), [], "{case}");
        // The answer to the adjustment contains the new time.
        report_ahead(&mut session, 2 * HOUR);
        session.wait(61.0);
        queries_time(&mut session, 2 * HOUR);
        assert_eq!(violated_by(&session), [("FW-SYS-TIME-02", 1), ("FW-UAV-INF-09", 1)], "{case}");
    }
}

#[test]
fn an_adjustment_may_affect_other_connections() {
    let asked = |session: &mut Session, ahead: u64, reported: u64| {
        session.over("tcp#2", |session| {
            queries_time(session, ahead);
            report_ahead(session, reported);
        });
    };
    let mut session = Session::opened();
    asked(&mut session, 0, 0);
    let adjustment = adjusts_clock(&mut session);
    asked(&mut session, 0, HOUR);
    answers_time(&mut session, &adjustment, HOUR);
    asked(&mut session, HOUR, HOUR);
    session.wait(61.0);
    asked(&mut session, HOUR, HOUR);
    assert_eq!(violated_by(&session), []);
    asked(&mut session, HOUR, 2 * HOUR);
    assert_eq!(violated_by(&session), [("FW-UAV-INF-09", 1)]);
}

#[test]
fn an_answer_to_an_unknown_request_may_follow_an_adjustment() {
    // The recording starts after the request.
    let mut session = Session::opened();
    session.lines.clear();
    queries_time(&mut session, 0);
    answers_time(&mut session, "ask-0", HOUR);
    report_ahead(&mut session, HOUR);
    session.wait(1.0);
    queries_time(&mut session, HOUR);
    assert_eq!(violated_by(&session), []);
    queries_time(&mut session, 2 * HOUR);
    assert_eq!(violated_by(&session), [("FW-SYS-TIME-02", 1)]);
}

#[test]
fn an_unknown_adjustment_may_follow_a_known_one() {
    let mut session = Session::opened();
    session.lines.clear();
    let adjustment = adjusts_clock(&mut session);
    answers_time(&mut session, "ask-0", 2 * HOUR);
    answers_time(&mut session, &adjustment, HOUR);
    session.wait(61.0);
    queries_time(&mut session, 2 * HOUR);
    assert_eq!(violated_by(&session), []);
}

#[test]
fn an_adjustment_without_a_time_may_happen_at_any_time() {
    let mut session = Session::opened();
    adjusts_clock(&mut session);
    if let Some(line) = session.lines.last_mut().and_then(serde_json::Value::as_object_mut) {
        line.remove("t");
    }
    queries_time(&mut session, 0);
    report_ahead(&mut session, HOUR);
    assert_eq!(violated_by(&session), []);
}

#[test]
fn a_query_from_before_an_adjustment_may_be_recorded_late() {
    let mut session = Session::opened();
    let adjustment = adjusts_clock(&mut session);
    let query = session.sends(json!({ "type": "SYS-TIME" }));
    answers_time(&mut session, &adjustment, HOUR);
    let last = session.lines.len() - 1;
    session.lines.swap(last - 1, last);
    answers_time(&mut session, &query, 0);
    report_ahead(&mut session, HOUR);
    assert_eq!(violated_by(&session), []);
}

/// Covers adjustments that are refused, repeated or unanswered.
#[test]
fn the_clock_is_checked_again_some_time_after_any_adjustment() {
    type Adjust = fn(&mut Session);
    let refused: Adjust = |session| {
        let id = adjusts_clock(session);
        session.answers(&id, json!({ "body": { "type": "ACK-NAK", "reason": "The clock is fixed" } }));
    };
    // The server may adjust its clock once for each copy of the datagram.
    let repeated: Adjust = |session| {
        session.over("udp#1", |session| {
            let id = adjusts_clock(session);
            let repeated = session.lines.last().cloned();
            session.lines.extend(repeated);
            answers_time(session, &id, HOUR);
            report_ahead(session, 2 * HOUR);
        });
    };
    let with_the_id_of_a_query: Adjust = |session| {
        let id = session.sends(json!({ "type": "SYS-TIME" }));
        adjusts_clock(session);
        if let Some(line) = session.lines.last_mut() {
            line["msg"]["id"] = id.as_str().into();
        }
        answers_time(session, &id, 0);
        report_ahead(session, HOUR);
        answers_time(session, &id, HOUR);
    };
    let unanswered: Adjust = |session| {
        adjusts_clock(session);
    };
    let one_id = [("FW-ENV-19", 1)];
    for (adjust, soon, later) in [
        (refused, &[][..], &[][..]),
        (repeated, &[], &[]),
        (with_the_id_of_a_query, &one_id, &one_id),
        (unanswered, &[], &[("FW-ENV-07", 1)]),
    ] {
        let mut session = Session::opened();
        adjust(&mut session);
        clock_jumps(&mut session, HOUR);
        assert_eq!(violated_by(&session), soon);
        session.wait(61.0);
        clock_jumps(&mut session, HOUR);
        assert_eq!(violated_by(&session), [later, &[("FW-SYS-TIME-02", 1)]].concat());
    }
}

#[test]
fn another_uav_may_have_the_id_of_a_deleted_uav() {
    let mut session = Session::opened();
    let now = session.now();
    report(&mut session, now);
    session.notify(json!({ "type": "OBJ-DEL", "ids": ["kite"] }));
    report(&mut session, now - 60_000);
    assert_eq!(violated_by(&session), []);
    report(&mut session, now - 90_000);
    assert_eq!(violated_by(&session), [("FW-UAV-INF-08", 1)]);
}

/// The clocks of the client and the server may drift apart over a day.
#[test]
fn the_offset_of_the_clock_is_uncertain_after_a_long_time() {
    let mut session = Session::opened();
    let time = |session: &mut Session, ahead: u64| {
        let now = json!({ "timestamp": session.now() + 40 + ahead });
        session.exchange(json!({ "type": "SYS-TIME" }), now);
    };
    time(&mut session, 0);
    session.wait(86_400.0);
    let now = session.now();
    report(&mut session, now + 5_000);
    time(&mut session, 5_000);
    assert_eq!(violated_by(&session), []);
    let now = session.now();
    report(&mut session, now + 10_000);
    time(&mut session, 10_000);
    assert_eq!(violated_by(&session), [("FW-SYS-TIME-02", 1), ("FW-UAV-INF-09", 1)]);
}

#[test]
fn responses_to_earlier_requests_may_follow_the_announcement_of_the_end() {
    let mut session = Session::opened();
    let id = session.sends(ping());
    session.notify(json!({ "type": "SYS-CLOSE", "reason": "Sunset" }));
    session.answers(&id, done());
    assert_eq!(violated_by(&session), []);
    let id = session.sends(ping());
    session.answers(&id, done());
    assert_eq!(violated_by(&session), [("FW-SYS-CLOSE-02", 1)]);
}

#[test]
fn responses_to_unknown_requests_may_follow_the_announcement_of_the_end() {
    // The recording starts after the request.
    let mut session = Session::opened();
    session.lines.clear();
    session.notify(json!({ "type": "SYS-CLOSE", "reason": "Sunset" }));
    session.answers("ask-0", done());
    assert_eq!(violated_by(&session), []);
    session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
    assert_eq!(violated_by(&session), [("FW-SYS-CLOSE-02", 1)]);
}

#[test]
fn most_answers_are_due_after_30_seconds() {
    let waits_for = |request: Value, seconds: f64| {
        let mut session = Session::opened();
        session.sends(request);
        session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
        session.event("closed");
        for (line, time) in session.lines.iter_mut().zip([0.0, 0.0, seconds, seconds]) {
            line["t"] = json!(1_790_000_000.0 + time);
        }
        violated_by(&session)
    };
    let waits = |seconds| waits_for(ping(), seconds);
    assert_eq!((waits(30.0), waits(30.5)), (vec![], vec![("FW-ENV-07", 1)]));
    // The specification sets no time limit, and the response has no receipt.
    assert_eq!(waits_for(json!({ "type": "SHOW-CRTH-PLAN" }), 300.0), []);
}

#[test]
fn a_refused_message_without_an_id_may_have_no_refs() {
    for (is_after, expected) in [(true, vec![("FW-ENV-03", 1)]), (false, vec![("FW-ACK-01", 1)])] {
        let mut session = Session::opened();
        if is_after {
            session.send_raw(r#"{"$fw.version":"1.0","body":{"type":"SYS-PING"}}"#);
        }
        session.notify(json!({ "type": "ACK-NAK", "reason": "No id" }));
        assert_eq!(violated_by(&session), expected);
    }
}

#[test]
fn a_message_without_an_id_may_be_answered_without_refs() {
    let mut session = Session::opened();
    session.sends(json!({ "type": "UAV-LIST" }));
    session.notify(json!({ "type": "UAV-LIST", "ids": ["kite"] }));
    assert_eq!(violated_by(&session), [("FW-ENV-17", 1)]);
    session.lines[1]["msg"].as_object_mut().and_then(|message| message.remove("id"));
    assert_eq!(violated_by(&session), []);
    // Ordinary notifications aren't answers. A message gets one answer.
    session.lines.insert(2, session.lines[2].clone());
    session.lines[2]["msg"]["id"] = "say-0".into();
    session.lines[2]["msg"]["body"] = json!({ "type": "CONN-DEL", "ids": ["winch"] });
    assert_eq!(violated_by(&session), []);
    session.notify(json!({ "type": "UAV-LIST", "ids": ["kite"] }));
    assert_eq!(violated_by(&session), [("FW-ENV-17", 1)]);
}

#[test]
fn each_requested_station_or_target_is_in_the_response() {
    for (name, part) in [("DOCK-INF", "status"), ("FW-TARGET-INF", "result")] {
        let answered = |answer: Value| {
            let mut session = Session::opened();
            session.exchange(json!({ "type": name, "ids": ["base"] }), answer);
            violated_by(&session)
        };
        assert_eq!(answered(json!({ "error": { "base": "Unknown" } })), []);
        assert_eq!(answered(json!({ part: {} })), [("FW-INF-01", 1)], "{name}");
    }
}

#[test]
fn disputed_values_are_warnings() {
    let states = [
        json!({ "positionXYZ": [1.5, 0, 0], "velocity": [0.5, 0, 0], "velocityXYZ": [0, 0, 0.5] }),
        json!({ "position": [46.541, 11.552], "heading": null, "timestamp": 1_790_000_000_000.5 }),
        json!({ "position": [0, 1_800_000_000, 1.5] }),
    ];
    for state in states {
        let mut session = Session::opened();
        let mut whole = json!({ "id": "kite", "timestamp": 1_790_000_000_000_i64 });
        if let (Some(whole), Value::Object(state)) = (whole.as_object_mut(), state.clone()) {
            whole.extend(state);
        }
        session.notify(json!({ "type": "UAV-INF", "status": { "kite": whole } }));
        let found = violated_by(&session);
        assert!(matches!(found[..], [("FW-ENV-26", _)]), "{state}: {found:?}");
    }
}

/// Both paths for status reports find the same values.
#[test]
fn implausible_values_are_grouped_by_type_and_field() {
    let mut session = Session::opened();
    let state = |timestamp: i64, voltage: i64| json!({ "kite": { "id": "kite", "timestamp": timestamp, "battery": [voltage, 50] } });
    for _ in 0..6 {
        session.notify(json!({ "type": "UAV-INF", "status": state(1_790_000_000_000, 10_000) }));
    }
    assert_eq!(violated_by(&session), []);
    for _ in 0..6 {
        session.notify(json!({ "type": "UAV-INF", "status": state(1, 1_000_000_000) }));
    }
    session.exchange(json!({ "type": "UAV-INF", "ids": ["kite"] }), json!({ "status": state(1, 118) }));
    session.exchange(json!({ "type": "SYS-TIME" }), json!({ "timestamp": 1_790_000_000 }));
    let found: Vec<_> = groups(&session).into_iter().filter(|(id, ..)| *id == "FW-VAL-01").collect();
    let expected = [("SYS-TIME.timestamp", 1), ("UAV-INF.battery", 6), ("UAV-INF.timestamp", 7)];
    assert_eq!(found, expected.map(|(subject, count)| ("FW-VAL-01", subject.to_owned(), count)));
    let mut thorough = FlockwaveChecker::new(&DEFINITIONS).thorough();
    for (number, line) in (1..).zip(&session.lines) {
        thorough.line(line.to_string().as_bytes(), number, false);
    }
    assert_eq!(violated(&thorough.finish(0)), violated(&checked(&session.to_bytes())));
}
