//! Tests of recorded Flockwave sessions: a violation is reported only if it is certain.

mod certain;
mod gaps;
mod limits;
mod operations;
mod service;
mod times;

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde_json::{Value, json};
use uavspec_check::{CaptureResult, Describe, FlockwaveSummary, Part, Summary, TypeCount, check_capture};
use uavspec_report::{CheckedCapture, Settings, Subject, subject_text};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::sample::Session;
use uavspec_rules::rule;
use uavspec_test_support::{extent, shared};

static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(Definitions::built_in);

fn checked(bytes: &[u8]) -> CaptureResult {
    check_capture(bytes, None, &DEFINITIONS).expect("bytes can be read")
}

/// The number of violations per rule.
fn violated(result: &CaptureResult) -> BTreeMap<&'static str, u64> {
    let mut counts = BTreeMap::new();
    for group in result.findings.groups() {
        *counts.entry(group.rule.id).or_default() += group.count;
    }
    counts
}

fn violated_by(session: &Session) -> Vec<(&'static str, u64)> {
    let result = checked(&session.to_bytes());
    assert_eq!(result.corruption, vec![]);
    violated(&result).into_iter().collect()
}

fn source(result: &CaptureResult) -> &FlockwaveSummary {
    match &result.summary {
        Summary::Flockwave(source) => source,
        other => panic!("expected a session, found {other:?}"),
    }
}

fn covered(result: &CaptureResult, id: &str) -> u64 {
    result.findings.covered(rule(id).expect("a rule"))
}

fn done() -> Value {
    json!({ "body": { "type": "ACK-ACK" } })
}

fn ping() -> Value {
    json!({ "type": "SYS-PING" })
}

fn land(gliders: &[&str]) -> Value {
    json!({ "type": "UAV-LAND", "ids": gliders })
}

/// The messages of a session, moved to another connection.
fn on_connection(connection: &str, session: &Session) -> Vec<Value> {
    let mut lines = session.lines.clone();
    for line in &mut lines {
        line["conn"] = connection.into();
    }
    lines
}

fn with_lines(lines: Vec<Value>) -> Session {
    let mut session = Session::opened();
    session.lines = lines;
    session
}

#[test]
fn accepts_answers_in_any_order() {
    let mut session = Session::opened();
    let first = session.sends(ping());
    let second = session.sends(json!({ "type": "UAV-LIST" }));
    let third = session.sends(json!({ "type": "UAV-INF", "ids": ["kite"] }));
    session.answers(&third, json!({ "body": { "type": "UAV-INF", "error": { "kite": "Lost" } } }));
    session.answers(&first, done());
    session.answers(&second, json!({ "body": { "type": "UAV-LIST", "ids": ["kite"] } }));
    assert_eq!(violated_by(&session), []);
    assert_eq!(covered(&checked(&session.to_bytes()), "FW-ENV-16"), 3);
}

#[test]
fn accepts_reuse_of_an_answered_id() {
    let mut session = Session::opened();
    for _ in 0..3 {
        let id = session.sends(ping());
        let request = session.lines.last_mut().expect("a request");
        request["msg"]["id"] = "again".into();
        assert_ne!(id, "again");
        session.answers("again", done());
    }
    assert_eq!(violated_by(&session), []);
    session.answers("again", done());
    assert_eq!(violated_by(&session), [("FW-ENV-08", 1)]);
}

/// If two requests have the same id, the answer belongs to neither request, so the answer's content isn't checked.
#[test]
fn reports_only_the_reuse_of_a_request_id() {
    for is_swapped in [false, true] {
        let mut session = Session::opened();
        let id = session.sends(land(&["kite"]));
        session.sends(json!({ "type": "UAV-INF", "ids": ["swift"] }));
        session.lines.last_mut().expect("a request")["msg"]["id"] = id.clone().into();
        let mut answers = [
            json!({ "body": { "type": "UAV-LAND", "result": { "kite": true } } }),
            json!({ "body": { "type": "UAV-INF", "error": { "swift": "Lost" } } }),
        ];
        if is_swapped {
            answers.reverse();
        }
        for answer in answers {
            session.answers(&id, answer);
        }
        assert_eq!(violated_by(&session), [("FW-ENV-19", 1)]);
    }
}

#[test]
fn distinguishes_connections() {
    let (hill, dale) = (on_connection("hill", &Session::new()), on_connection("dale", &Session::new()));
    // Two sessions with the same ids, interleaved and one after the other.
    let mixed = hill.iter().cloned().zip(dale.iter().cloned()).flat_map(|(one, other)| [one, other]);
    let mixed = with_lines(mixed.collect());
    assert_eq!(violated_by(&mixed), []);
    assert_eq!(source(&checked(&mixed.to_bytes())).connections, 2);
    assert_eq!(violated_by(&with_lines([hill, dale].concat())), []);

    let mut session = Session::opened();
    let id = session.sends(ping());
    let mut other = Session::opened();
    other.answers(&id, done());
    let lines = [on_connection("hill", &session), on_connection("dale", &other)].concat();
    assert_eq!(violated_by(&with_lines(lines)), [("FW-ENV-06", 1)], "the answer comes on another connection");
}

#[test]
fn a_reopened_connection_starts_a_new_session() {
    let session = Session::new();
    let twice = with_lines([session.lines.clone(), session.lines.clone()].concat());
    assert_eq!(violated_by(&twice), []);
    // A new session starts even if the recording doesn't contain the end of the old connection.
    let mut session = Session::opened();
    let id = session.sends(ping());
    session.event("connect");
    session.answers(&id, done());
    assert_eq!(violated_by(&session), [("FW-ENV-06", 1)]);
}

#[test]
fn accepts_recordings_of_parts_of_a_session() {
    let session = Session::new();
    for at in (0..=session.lines.len()).step_by(extent(1, 17)) {
        let (before, after) = session.lines.split_at(at);
        for part in [before, after] {
            assert_eq!(violated_by(&with_lines(part.to_vec())), [], "cut before line {}", at + 1);
        }
    }
}

#[test]
fn reports_only_lost_answers() {
    let session = Session::new();
    let lines: Vec<String> = session.lines.iter().map(ToString::to_string).collect();
    let junk = [
        "{\"t\":1,\"conn\":\"hill\",\"dir\":\"in\",\"msg\":{\"$fw.ver",
        "no JSON",
        "7",
        "{\"dir\":\"up\",\"msg\":{}}",
    ];
    // Even the larger step of quick mode includes each kind of junk.
    for (at, junk) in (1..lines.len()).zip(junk.into_iter().cycle()).step_by(extent(1, 15)) {
        let mut lines = lines.clone();
        lines[at] = junk.to_owned();
        let result = checked(lines.join("\n").as_bytes());
        assert_eq!(violated(&result), BTreeMap::new(), "line {} is `{junk}`", at + 1);
        assert_eq!(result.corruption.len(), 1, "line {} is `{junk}`", at + 1);
    }
}

#[test]
fn reports_an_unanswered_request_if_the_server_sends_messages_much_later() {
    let mut session = Session::opened();
    session.sends(ping());
    session.wait(20.0);
    session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
    session.wait(600.0);
    session.event("closed");
    assert_eq!(violated_by(&session), [], "20 s after the request the server fell silent");

    let mut session = Session::opened();
    session.sends(ping());
    let answered_late = session.sends(ping());
    session.wait(60.0);
    session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
    session.answers(&answered_late, done());
    assert_eq!(violated_by(&session), [("FW-ENV-07", 1)], "without the end of the connection as well");
    let location = checked(&session.to_bytes()).findings.groups().next().expect("a finding").examples[0].0;
    assert_eq!(location.to_string(), "line 2", "the location of the request");

    session.lines[3]["t"] = 0.into();
    assert_eq!(violated_by(&session), [], "the duration is unknown if time goes back");
}

/// A message that isn't a Flockwave request doesn't need an answer, even if its time is unreadable.
#[test]
fn ignores_messages_that_may_not_need_an_answer() {
    let changes: [fn(&mut Value); 4] = [
        |line| line["msg"]["$fw.version"] = json!(null),
        |line| line["msg"]["body"] = json!({}),
        |line| line["msg"]["id"] = json!(7),
        |line| line["t"] = json!("14:13:28"),
    ];
    let mut session = Session::opened();
    session.sends(ping());
    session.wait(60.0);
    session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
    assert_eq!(violated_by(&session), [("FW-ENV-07", 1)]);
    for change in changes {
        let mut session = session.clone();
        change(&mut session.lines[1]);
        assert_eq!(violated_by(&session), []);
    }
}

/// Datagrams may be lost, duplicated or reordered.
#[test]
fn does_not_check_order_over_udp() {
    let session = Session::new();
    let mut lines = on_connection("udp#1", &session);
    assert_eq!(violated_by(&with_lines(lines.clone())), []);
    lines[1..].reverse();
    assert_eq!(violated_by(&with_lines(lines.clone())), []);
    lines.extend(lines.clone());
    assert_eq!(violated_by(&with_lines(lines)), []);
    let thinned = on_connection("udp#1", &session).into_iter().enumerate().filter(|(at, _)| at % 3 > 0);
    assert_eq!(violated_by(&with_lines(thinned.map(|(_, line)| line).collect())), []);
    let changed = session.errors(&[0]).expect("a report");
    assert_eq!(violated_by(&with_lines(on_connection("UDP", &changed))), [("FW-ERR-02", 1)]);
}

#[test]
fn receipts_end_once_with_a_result_or_a_timeout() {
    let mut session = Session::opened();
    let receipts = json!({ "receipt": { "kite": "r-1", "swift": "r-2", "owl": "r-3" } });
    session.exchange(land(&["kite", "swift", "owl"]), receipts);
    session.notify(json!({ "type": "ASYNC-RESP", "id": "r-2", "result": true }));
    session.notify(json!({ "type": "ASYNC-TIMEOUT", "ids": ["r-1", "r-3"] }));
    assert_eq!(violated_by(&session), []);

    // A receipt may be reused after its operation has ended.
    let mut again = session.clone();
    again.exchange(land(&["kite"]), json!({ "receipt": { "kite": "r-1" } }));
    again.notify(json!({ "type": "ASYNC-RESP", "id": "r-1", "error": "A thermal carries it" }));
    assert_eq!(violated_by(&again), []);

    session.notify(json!({ "type": "ASYNC-ST", "id": "r-1", "progress": {} }));
    session.notify(json!({ "type": "ASYNC-RESP", "id": "r-3", "result": true }));
    session.notify(json!({ "type": "ASYNC-TIMEOUT", "ids": ["r-2"] }));
    assert_eq!(violated_by(&session), [("FW-ASY-10", 2), ("FW-ASY-11", 1)]);
}

#[test]
fn suspended_operations_continue_only_after_a_request() {
    let suspended = || {
        let mut session = Session::opened();
        session.exchange(land(&["kite"]), json!({ "receipt": { "kite": "r-1" } }));
        session.notify(json!({ "type": "ASYNC-ST", "id": "r-1", "progress": {}, "suspended": true }));
        session
    };
    let ended = json!({ "type": "ASYNC-RESP", "id": "r-1", "result": true });
    for request in ["ASYNC-RESUME", "ASYNC-CANCEL"] {
        // The end of an operation may precede the answer to the request that resumes the operation.
        let mut session = suspended();
        let id = session.sends(json!({ "type": request, "ids": ["r-1"] }));
        session.notify(ended.clone());
        session.answers(&id, json!({ "body": { "type": request, "success": ["r-1"] } }));
        assert_eq!(violated_by(&session), [], "{request}");
    }
    let mut session = suspended();
    session.notify(json!({ "type": "ASYNC-ST", "id": "r-1", "progress": { "percentage": null } }));
    session.notify(ended);
    assert_eq!(violated_by(&session), [("FW-ASY-14", 1)]);
    for end in [
        json!({ "type": "ASYNC-TIMEOUT", "ids": ["r-1"] }),
        json!({ "type": "ASYNC-RESP", "id": "r-1", "error": "The glider is lost" }),
    ] {
        let mut session = suspended();
        session.notify(end.clone());
        assert_eq!(violated_by(&session), [], "{end}");
    }
}

#[test]
fn checks_results_against_the_command_of_the_receipt() {
    let mut session = Session::opened();
    let value = json!({ "type": "PRM-GET", "ids": ["kite"], "name": "FLAPS" });
    session.exchange(value, json!({ "receipt": { "kite": "r-1" } }));
    session.notify(json!({ "type": "ASYNC-RESP", "id": "r-1", "result": null }));
    assert_eq!(violated_by(&session), [], "parameters may have any value");
    session.exchange(land(&["kite"]), json!({ "receipt": { "kite": "r-2" } }));
    session.notify(json!({ "type": "ASYNC-RESP", "id": "r-2", "result": null }));
    session.notify(json!({ "type": "ASYNC-RESP", "id": "r-3", "result": null }));
    assert_eq!(violated_by(&session), [("FW-ASY-09", 1), ("FW-ASY-22", 1)]);
}

/// With a shared receipt, a result may belong to any of the operations.
#[test]
fn does_not_check_results_of_a_receipt_of_several_types() {
    let mut session = Session::opened();
    let value = json!({ "type": "PRM-GET", "ids": ["kite"], "name": "FLAPS" });
    session.exchange(value, json!({ "receipt": { "kite": "r-1" } }));
    session.exchange(land(&["kite"]), json!({ "receipt": { "kite": "r-1" } }));
    session.notify(json!({ "type": "ASYNC-RESP", "id": "r-1", "result": 7 }));
    assert_eq!(violated_by(&session), [("FW-ASY-04I", 1)]);
}

#[test]
fn a_rejection_is_not_an_incomplete_answer() {
    let mut session = Session::opened();
    session.exchange_with(land(&["kite"]), json!({ "type": "ACK-NAK", "reason": "Log in first" }));
    let id = session.sends(land(&["kite"]));
    session.answers(&id, json!({ "error": { "message": "Too windy" } }));
    assert_eq!(violated_by(&session), []);
}

/// The ids in a request must be unique, so a server may refuse a repeated id in any way.
#[test]
fn accepts_a_refused_repeated_id() {
    for answer in [
        json!({ "type": "ACK-NAK", "reason": "Repeated id" }),
        json!({ "type": "UAV-INF", "error": { "kite": "Repeated id" } }),
    ] {
        let mut session = Session::opened();
        session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": ["kite"] }));
        session.exchange_with(json!({ "type": "UAV-INF", "ids": ["kite", "kite"] }), answer);
        session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": ["kite"] }));
        assert_eq!(violated_by(&session), []);
    }
}

/// Unknown types are only counted, since their messages have no definition.
#[test]
fn counts_unknown_types_as_unsupported() {
    let mut session = Session::opened();
    session.exchange(json!({ "type": "SOAR-LIST" }), json!({ "ids": 7, "receipt": 9 }));
    session.notify(json!({ "type": "SOAR-INF", "status": 7 }));
    session.exchange_with(json!({ "type": "SOAR-NOW" }), json!({ "type": "SOAR-DONE" }));
    let result = checked(&session.to_bytes());
    assert_eq!(violated(&result), BTreeMap::new());
    assert_eq!((result.records, result.checked), (3, 0));
    let source = source(&result);
    assert_eq!((source.requests, source.responses, source.notifications), (2, 2, 1));
    let list = TypeCount { name: "SOAR-LIST".to_owned(), from_client: 1, from_server: 1 };
    assert!(source.unknown.contains(&list), "{:?}", source.unknown);
    assert_eq!(source.unknown.len(), 4);
    assert!(source.types.is_empty());
}

/// If a type has no definition for a direction, the bodies of its messages in that direction aren't checked.
#[test]
fn messages_in_an_undefined_direction_do_not_count_as_checked() {
    let mut session = Session::opened();
    session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": [] }));
    session.notify(json!({ "type": "UAV-LIST", "ids": 7 }));
    let result = checked(&session.to_bytes());
    assert_eq!((result.records, result.checked), (2, 1));
    let records = |part: &Part| (part.name.clone(), part.records.checked, part.records.total);
    let parts: Vec<_> = result.coverage.parts.iter().map(records).collect();
    let expected = [("UAV-LIST".to_owned(), 1, Some(1)), ("UAV-LIST (notification)".to_owned(), 0, Some(1))];
    assert_eq!(parts, expected);
    assert!(!result.coverage.is_full());
    let list = TypeCount { name: "UAV-LIST".to_owned(), from_client: 1, from_server: 2 };
    assert!(source(&result).types.contains(&list));
    assert!(source(&result).unknown.is_empty());
}

/// A long type name isn't listed. If a client sent it, it isn't counted either: probes send such names on purpose.
#[test]
fn counts_long_unknown_type_names_from_the_server_only() {
    let long = "SOAR-".repeat(100);
    let mut session = Session::opened();
    session.exchange_with(json!({ "type": long }), json!({ "type": "SOAR-DONE" }));
    assert_eq!(source(&checked(&session.to_bytes())).uncounted, 0);
    session.notify(json!({ "type": long }));
    let result = checked(&session.to_bytes());
    assert_eq!(source(&result).uncounted, 1);
    let is_listed = |part: &Part| part.name == "types not listed by name" && part.records.total == Some(1);
    assert!(result.coverage.parts.iter().any(is_listed), "{:?}", result.coverage.parts);
    let lines = source(&result).lines();
    let line = lines.last().expect("the unsupported types");
    assert_eq!(line.text, "2 messages without a definition: SOAR-DONE, types not listed by name");
}

/// Messages without the recording's envelope have no connection.
#[test]
fn checks_bare_messages_alone_and_with_their_requests() {
    let session = Session::new();
    let bare = |session: &Session| -> Vec<u8> {
        let messages = session.lines.iter().filter_map(|line| line.get("msg"));
        messages.map(|message| format!("{message}\n")).collect::<String>().into_bytes()
    };
    let result = checked(&bare(&session));
    assert_eq!(violated(&result), BTreeMap::new());
    assert_eq!((covered(&result, "FW-ENV-06"), covered(&result, "FW-ENV-04")), (0, 0));
    assert!(covered(&result, "FW-UST-ID") > 0 && covered(&result, "FW-ASY-02") > 0);
    let recorded = checked(&session.to_bytes());
    // Without a direction, requests from the server look like requests from a client.
    assert_eq!(result.records, recorded.records);
    let changed =
        session.errors(&[0]).expect("a report").reply("UAV-TAKEOFF", |body| body["error"] = json!({}));
    let changed = changed.expect("an answer");
    assert_eq!(violated(&checked(&bare(&changed))), BTreeMap::from([("FW-ASY-02", 1), ("FW-ERR-02", 1)]));
    // Two recordings in the same file may use the same ids.
    assert_eq!(violated(&checked(&[bare(&Session::new()), bare(&Session::new())].concat())), BTreeMap::new());
}

#[test]
fn detects_a_recording_by_its_first_object() {
    let session = Session::new();
    let text = String::from_utf8(session.to_bytes()).expect("text");
    assert!(matches!(checked(format!("half a li\n{text}").as_bytes()).summary, Summary::Flockwave(_)));
    let array = Value::Array(session.lines.clone()).to_string();
    let result = checked(array.as_bytes());
    assert_eq!((source(&result).connections, violated(&result)), (10, BTreeMap::new()));
    let pretty = serde_json::to_string_pretty(&session.lines).expect("JSON");
    assert_eq!(checked(pretty.as_bytes()).checked, result.checked);
    for other in
        ["{\"type\":\"px4/Event\",\"message\":{}}", "{\"op\":\"publish\",\"dir\":7,\"msg\":{}}", "[7]"]
    {
        assert!(matches!(checked(other.as_bytes()).summary, Summary::Json(_)), "{other}");
    }
}

/// Text that one program rejects may be valid JSON for another program.
#[test]
fn parses_raw_text_as_a_message_if_possible() {
    let mut session = Session::opened();
    let id = session.sends(ping());
    let raw = format!(
        "{{\"$fw.version\":\"1.0\",\"id\":\"a\",\"refs\":\"{id}\",\"body\":{{\"type\":\"ACK-ACK\",\"gust\":NaN}}}}"
    );
    let line = json!({ "t": 1.8e9, "conn": "hill", "dir": "in", "raw": raw });
    session.lines.push(line);
    assert_eq!(violated_by(&session), [("FW-ACK-03", 1), ("FW-ENV-23", 1)]);
    let line = json!({ "t": 1.8e9, "conn": "hill", "dir": "out", "raw": "who is there?" });
    session.lines.push(line);
    assert_eq!(
        violated_by(&session),
        [("FW-ACK-03", 1), ("FW-ENV-23", 1)],
        "messages of clients aren't checked"
    );
}

#[test]
fn accepts_integers_with_a_zero_fraction() {
    let session = Session::new().state(|kite| kite["heading"] = json!(2710.0)).expect("a report");
    assert_eq!(violated_by(&session), []);
}

#[test]
fn reads_hostile_recordings() {
    let session = Session::new();
    let bytes = session.to_bytes();
    for end in (0..bytes.len()).step_by(211 * extent(1, 29)) {
        let result = checked(&bytes[..end]);
        assert_eq!(violated(&result), BTreeMap::new(), "cut after {end} bytes");
    }
    let mut random = 0x9e37_79b9_u64;
    for _ in 0..extent(200, 12) {
        let mut changed = bytes.clone();
        for _ in 0..8 {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let at = usize::try_from(random >> 33).expect("31 bits") % changed.len();
            changed[at] = random.to_be_bytes()[3];
        }
        checked(&changed);
    }
    let long = "x".repeat(100_000);
    let mut session = Session::opened();
    for body in [
        json!({ "type": long, "ids": [long], "status": { long.clone(): { "errors": [long] } } }),
        json!({ "type": "UAV-INF", "status": { long.clone(): 7, "": [], "~/": { "id": long } } }),
        json!({ "type": "ASYNC-TIMEOUT", "ids": vec!["r"; 20_000] }),
        json!({ "type": "ASYNC-RESP", "id": long, "result": vec![7; 100_000] }),
        json!({ "type": "UAV-LAND", "receipt": { "a": long, "b": { "c": 7 } } }),
    ] {
        session.notify(body.clone());
        session.exchange(body.clone(), body);
    }
    let mut lines = session.lines.clone();
    for line in &mut lines {
        line["msg"]["refs"] = long.clone().into();
    }
    session.lines.extend(lines);
    session.lines.push(json!({ "dir": "in", "msg": null }));
    session.lines.push(json!({ "dir": "event", "event": long, "conn": ["a"], "t": "now" }));
    session.lines.push(json!({ "dir": "in", "conn": long, "msg": {} }));
    let result = checked(&session.to_bytes());
    assert!(result.findings.groups().count() > 5);
    let reported = result.findings.groups().flat_map(|group| &group.examples);
    assert!(reported.map(|(_, detail)| detail.to_string().len()).max() < Some(2_000), "messages are short");
}

/// Requests that were dropped to save memory cause no findings.
#[test]
fn stores_a_bounded_number_of_requests() {
    let mut text = String::from("{\"conn\":\"hill\",\"dir\":\"event\",\"event\":\"connect\"}\n");
    let line = |direction: &str, message: Value| {
        format!("{}\n", json!({ "conn": "hill", "dir": direction, "msg": message }))
    };
    let id = |number: u32| format!("{number:0>200}");
    let request = |number| json!({ "$fw.version": "1.0", "id": id(number), "body": { "type": "SYS-PING" } });
    let answer = |number| json!({ "$fw.version": "1.0", "id": format!("a{number}"), "refs": id(number), "body": { "type": "ACK-ACK" } });
    text.push_str(&line("in", answer(0)));
    // With the overhead of each request, this is more than the limit.
    let count = extent(40_000, 16_000);
    for number in 0..count {
        text.push_str(&line("out", request(number)));
    }
    // The first request was dropped, the last one wasn't.
    text.push_str(&line("in", answer(1)));
    text.push_str(&line("in", answer(count - 1)));
    let result = checked(text.as_bytes());
    assert_eq!(violated(&result).into_iter().collect::<Vec<_>>(), [("FW-ENV-06", 1)]);
    assert_eq!(covered(&result, "FW-ENV-16"), 1);
    // The number of requests is limited as well.
    let many: String = (0..extent(11_000, 10_100))
        .map(|number| format!("{{\"conn\":{number},\"dir\":\"event\",\"event\":\"connect\"}}\n"))
        .collect();
    let result = checked(many.as_bytes());
    assert_eq!(source(&result).connections, 10_000);
    assert_eq!(result.corruption.len(), 1);
}

#[test]
fn reports_describe_the_recording() {
    let definitions = Definitions::built_in();
    let mut session = Session::new();
    session = session.then(|session| session.exchange(json!({ "type": "SOAR-LIST" }), json!({ "ids": [] })));
    let result = checked(&session.to_bytes());
    let checked = CheckedCapture {
        path: "hill.jsonl".to_owned(),
        result,
        notes: Vec::new(),
        requests: Vec::new(),
        cut_short: Vec::new(),
        elapsed: 1,
    };
    let subject = Subject::from_capture(checked, &definitions, &Settings::default());
    let text = subject_text(&subject);
    for part in ["Flockwave, 10 connections, 1 min", "UAV-INF 32", "SOAR-LIST", "40 of 41 types"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let value = serde_json::to_value(&subject).expect("JSON");
    assert_eq!((&value["kind"], &value["connections"]), (&json!("flockwave"), &json!(10)));
    // Only the client sends UAV-SOAR, and its messages aren't checked.
    let unsupported = json!([{ "name": "SOAR-LIST", "from_client": 1, "from_server": 1 }]);
    assert_eq!(value["unsupported"], unsupported);
    assert!(value["types"].as_array().is_some_and(|types| types.len() > 30));
}

/// The traffic of a real server, with findings that were verified by hand. The server deviates as follows:
///
/// - It writes null instead of other values in the states of UAVs, in connection descriptions and in a weather position.
/// - It omits the holder of a license.
/// - The components of a magnetic field have fractions.
/// - It uses another name for preflight checks.
/// - It writes connection purposes as numbers, includes 0 in lists of error codes, and writes seconds instead of
///   milliseconds.
/// - It doesn't report the end of a cancelled operation.
/// - It sends error codes that a client set for the server's gliders.
#[test]
fn reports_the_deviations_of_real_servers() {
    let Some(corpus) = shared("corpus/flockwave") else { return };
    let found = |name: &str| {
        let bytes = std::fs::read(corpus.join(name)).expect("a recording");
        let result = checked(&bytes);
        assert_eq!(result.corruption, vec![], "{name}");
        violated(&result).into_iter().collect::<Vec<_>>()
    };
    assert_eq!(
        found("clean.jsonl"),
        [
            ("FW-ASY-22", 12),
            ("FW-CONN-INF-03", 58),
            ("FW-ENV-26", 2884),
            ("FW-ERR-02", 48),
            ("FW-ERR-07", 6),
            ("FW-ERR-09", 1),
        ]
    );
    assert_eq!(
        found("main.jsonl"),
        [
            ("FW-ASY-17", 1),
            ("FW-ASY-22", 28),
            ("FW-CONN-INF-03", 197),
            ("FW-ENV-15", 1),
            ("FW-ENV-18", 3),
            ("FW-ENV-26", 11_048),
            ("FW-ERR-01", 3),
            ("FW-ERR-02", 2890),
            ("FW-ERR-03", 14),
            ("FW-ERR-04", 35),
            ("FW-ERR-07", 76),
            ("FW-ERR-08", 4),
            ("FW-ERR-09", 11),
            ("FW-ERR-10", 20),
            ("FW-INF-01", 1),
            ("FW-WTH-01", 2),
        ]
    );
}
