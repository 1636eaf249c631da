//! Tests of the rules that follow an operation until it ends: their limits, and what counts as the end.

use serde_json::{Value, json};
use uavspec_rules::flockwave::sample::Session;
use uavspec_rules::rule;

use super::{checked, violated, violated_by};

/// Adds a message about something other than the operation.
fn other(session: &mut Session) {
    session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
}

/// Adds a trial of `FW-ASY-10I`, which the server accepts.
fn short_operation(session: &mut Session) {
    let request = json!({ "type": "UAV-TEST", "ids": ["kite"], "component": "lamp" });
    let id = session.tries(rule("FW-ASY-10I").expect("a rule"), "", request);
    session.answers(&id, json!({ "body": { "type": "UAV-TEST", "receipt": { "kite": "r-1" } } }));
}

/// Adds operations with these receipts, which the client cancels.
fn cancelled(session: &mut Session, receipts: &[String]) {
    let by_uav: serde_json::Map<String, Value> =
        receipts.iter().map(|receipt| (format!("uav-{receipt}"), json!(receipt))).collect();
    let uavs: Vec<&String> = by_uav.keys().collect();
    session.exchange(
        json!({ "type": "OBJ-CMD", "ids": uavs, "command": "flaps" }),
        json!({ "receipt": by_uav }),
    );
    session.exchange(json!({ "type": "ASYNC-CANCEL", "ids": receipts }), json!({ "success": receipts }));
}

fn receipts(numbers: std::ops::Range<usize>) -> Vec<String> {
    numbers.map(|number| format!("r-{number}")).collect()
}

/// The violations of one rule in a session on this connection.
fn count(id: &str, connection: &'static str, add: impl FnOnce(&mut Session)) -> u64 {
    let mut session = Session::opened();
    session.over(connection, add);
    violated(&checked(&session.to_bytes())).get(id).copied().unwrap_or_default()
}

/// Sets the time between the last two records.
fn set_last_gap(session: &mut Session, seconds: u32) {
    let [.., before, last] = session.lines.as_mut_slice() else { return };
    // Whole seconds have no rounding errors.
    before["t"] = 1_790_000_100.into();
    last["t"] = (1_790_000_100 + u64::from(seconds)).into();
}

#[test]
fn an_ended_operation_is_not_overdue() {
    for end in [
        json!({ "type": "ASYNC-RESP", "id": "r-1", "result": true }),
        json!({ "type": "ASYNC-RESP", "id": "r-1", "error": "The lamp broke" }),
        json!({ "type": "ASYNC-TIMEOUT", "ids": ["r-1"] }),
        // A suspended operation waits for the client.
        json!({ "type": "ASYNC-ST", "id": "r-1", "progress": {}, "suspended": true }),
    ] {
        let mut session = Session::opened();
        short_operation(&mut session);
        session.notify(end.clone());
        session.wait(20.0);
        other(&mut session);
        assert_eq!(violated_by(&session), [], "{end}");
    }
}

#[test]
fn progress_extends_the_time_of_an_operation() {
    let mut session = Session::opened();
    short_operation(&mut session);
    for _ in 0..3 {
        session.wait(10.0);
        session.notify(json!({ "type": "ASYNC-ST", "id": "r-1", "progress": {} }));
    }
    assert_eq!(violated_by(&session), []);
    session.wait(20.0);
    other(&mut session);
    assert_eq!(violated_by(&session), [("FW-ASY-10I", 1)]);
}

#[test]
fn operations_are_overdue_only_after_the_limit() {
    for (id, limit, begin) in [
        ("FW-ASY-10I", 18, short_operation as fn(&mut Session)),
        ("FW-ASY-17", 10, |session| cancelled(session, &receipts(0..1))),
    ] {
        let overdue_after = |seconds| {
            count(id, "tcp#9", |session| {
                begin(session);
                other(session);
                set_last_gap(session, seconds);
                // The answer is the previous message.
            })
        };
        assert_eq!((overdue_after(limit), overdue_after(limit + 1)), (0, 1), "{id}");
    }
}

#[test]
fn status_reports_show_that_an_operation_is_overdue() {
    for (id, begin) in [
        ("FW-ASY-10I", short_operation as fn(&mut Session)),
        ("FW-ASY-17", |session| cancelled(session, &receipts(0..1))),
    ] {
        let overdue_over = |connection| {
            count(id, connection, |session| {
                session.report();
                begin(session);
                session.wait(20.0);
                session.report();
            })
        };
        assert_eq!((overdue_over("tcp#9"), overdue_over("udp#9")), (1, 0), "{id}");
    }
}

#[test]
fn operations_over_udp_are_never_overdue() {
    for (id, begin) in [
        ("FW-ASY-10I", short_operation as fn(&mut Session)),
        ("FW-ASY-17", |session| cancelled(session, &receipts(0..1))),
    ] {
        let overdue_over = |connection| {
            count(id, connection, |session| {
                begin(session);
                session.wait(20.0);
                other(session);
            })
        };
        assert_eq!((overdue_over("tcp#9"), overdue_over("udp#9")), (1, 0), "{id}");
    }
}

/// The lost part may contain the end of the operation.
#[test]
fn operations_before_a_gap_are_not_overdue() {
    for begin in [short_operation as fn(&mut Session), |session| cancelled(session, &receipts(0..1))] {
        let mut session = Session::opened();
        begin(&mut session);
        let mut bytes = session.to_bytes();
        bytes.extend(b"{\"t\":1790000001,\"conn\":\"hill\",\"dir\"\n");
        let before = session.lines.len();
        session.wait(20.0);
        other(&mut session);
        session.lines.drain(..before);
        bytes.extend(session.to_bytes());
        let result = checked(&bytes);
        assert_eq!(result.corruption.len(), 1);
        assert_eq!(violated(&result).into_iter().collect::<Vec<_>>(), []);
    }
}

#[test]
fn an_operation_that_ended_before_the_answer_is_not_overdue() {
    let mut session = Session::opened();
    session.exchange(json!({ "type": "UAV-LAND", "ids": ["kite"] }), json!({ "receipt": { "kite": "r-1" } }));
    let id = session.sends(json!({ "type": "ASYNC-CANCEL", "ids": ["r-1"] }));
    session.notify(json!({ "type": "ASYNC-RESP", "id": "r-1", "result": true }));
    session.answers(&id, json!({ "body": { "type": "ASYNC-CANCEL", "success": ["r-1"] } }));
    session.wait(20.0);
    other(&mut session);
    assert_eq!(violated_by(&session), []);
}

#[test]
fn a_cancelled_operation_may_end_with_an_error_and_a_result() {
    let mut session = Session::opened();
    cancelled(&mut session, &receipts(0..1));
    session.notify(json!({ "type": "ASYNC-RESP", "id": "r-0", "error": "Cancelled", "result": false }));
    assert_eq!(violated_by(&session), [("FW-ASY-07", 1)]);
}

#[test]
fn follows_a_limited_number_of_cancelled_operations() {
    let overdue = |first: usize, second: usize| {
        count("FW-ASY-17", "tcp#9", |session| {
            cancelled(session, &receipts(0..first));
            for receipt in receipts(0..first.min(second)) {
                session.notify(json!({ "type": "ASYNC-RESP", "id": receipt, "error": "Cancelled" }));
            }
            cancelled(session, &receipts(first..first + second));
            session.wait(20.0);
            other(session);
        })
    };
    assert_eq!(overdue(1_000, 0), 1_000);
    assert_eq!(overdue(1_001, 0), 1_000);
    assert_eq!(overdue(10, 7), 10);
}

#[test]
fn an_overdue_operation_is_reported_with_its_time() {
    let mut session = Session::opened();
    cancelled(&mut session, &receipts(0..1));
    session.wait(30.0);
    other(&mut session);
    let result = checked(&session.to_bytes());
    let group = result.findings.groups().next().expect("a finding");
    let text = group.examples[0].1.to_string();
    assert!(text.starts_with("`r-0` was cancelled but did not end within 30 s"), "{text}");
}

/// Adds a request to resume an operation, and its response.
fn resume(session: &mut Session, answer: &Value) {
    session.exchange(json!({ "type": "ASYNC-RESUME", "ids": ["r-1"] }), answer.clone());
}

/// Some servers accept a request to resume an operation that isn't suspended.
#[test]
fn a_resumed_operation_was_suspended_if_the_server_refused_to_resume_it_before() {
    let resumed = |is_refused: bool| {
        let mut session = Session::opened();
        session.command("r-1");
        if is_refused {
            resume(&mut session, &json!({ "error": { "r-1": "It isn't suspended" } }));
        }
        resume(&mut session, &json!({ "success": ["r-1"] }));
        violated_by(&session)
    };
    assert_eq!((resumed(false), resumed(true)), (vec![], vec![("FW-ASY-13", 1)]));
}

/// A server may report on an operation just before the response that contains its receipt.
#[test]
fn a_notification_may_overtake_the_response() {
    let overtaken = |early: Value, then: fn(&mut Session)| {
        let mut session = Session::opened();
        let id = session.sends(json!({ "type": "UAV-TEST", "ids": ["kite"], "component": "lamp" }));
        session.notify(early);
        session.answers(&id, json!({ "body": { "type": "UAV-TEST", "receipt": { "kite": "r-1" } } }));
        then(&mut session);
        violated_by(&session)
    };
    let [early, unknown] = [("FW-ASY-06", 1), ("FW-ASY-09", 1)];
    let suspended = json!({ "type": "ASYNC-ST", "id": "r-1", "progress": {}, "suspended": true });
    let resumes = |session: &mut Session| {
        resume(session, &json!({ "error": { "r-1": "Not now" } }));
        resume(session, &json!({ "success": ["r-1"] }));
    };
    assert_eq!(overtaken(suspended, resumes), [early, unknown]);
    let progress = json!({ "type": "ASYNC-ST", "id": "r-1", "progress": {} });
    assert_eq!(overtaken(progress, resumes), [early, unknown, ("FW-ASY-13", 1)]);
    // A server may use a receipt again after its operation has ended.
    let ended = json!({ "type": "ASYNC-RESP", "id": "r-1", "result": true });
    assert_eq!(overtaken(ended, short_operation), [early, unknown]);
}
