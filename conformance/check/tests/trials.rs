//! Tests of rules on trials and connections: valid server behaviour has no findings.

use std::sync::LazyLock;

use serde_json::{Value, json};
use uavspec_check::{CaptureResult, check_capture};
use uavspec_model::Rule;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::sample::Session;
use uavspec_rules::rule;

static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(Definitions::built_in);

fn checked(session: &Session) -> CaptureResult {
    check_capture(&session.to_bytes()[..], None, &DEFINITIONS).expect("bytes can be read")
}

/// The number of violations per rule.
fn violated_by(session: &Session) -> Vec<(&'static str, u64)> {
    let result = checked(session);
    assert_eq!(result.corruption, vec![]);
    let mut counts = std::collections::BTreeMap::new();
    for group in result.findings.groups() {
        *counts.entry(group.rule.id).or_default() += group.count;
    }
    counts.into_iter().collect()
}

fn covered(session: &Session, id: &str) -> u64 {
    checked(session).findings.covered(rule(id).expect("a rule"))
}

/// A session with one connection. `say` adds the messages.
fn over(connection: &'static str, say: impl FnOnce(&mut Session)) -> Session {
    let mut session = Session::opened();
    session.over(connection, say);
    session
}

fn rule_of(id: &str) -> &'static Rule {
    rule(id).expect("a rule")
}

fn ping() -> Value {
    json!({ "type": "SYS-PING" })
}

fn uavs(session: &mut Session, ids: &[&str]) {
    session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": ids }));
}

fn objects(session: &mut Session, filter: &[&str], ids: &[&str]) {
    let mut request = json!({ "type": "OBJ-LIST" });
    if !filter.is_empty() {
        request["filter"] = filter.into();
    }
    session.exchange(request, json!({ "ids": ids }));
}

fn cancel(session: &mut Session, receipt: &str) -> String {
    session.sends(json!({ "type": "ASYNC-CANCEL", "ids": [receipt] }))
}

fn cancelled(session: &mut Session, id: &str, receipt: &str) {
    session.answers(id, json!({ "body": { "type": "ASYNC-CANCEL", "success": [receipt] } }));
}

/// A recording may end before the answer.
#[test]
fn reports_unanswered_trials_after_the_connection_has_ended() {
    for rule in ["FW-TCP-02", "FW-ENV-07", "FW-ENV-21", "FW-ENV-24", "FW-UAV-INF-06"] {
        let mut session = over("tcp#2", |session| _ = session.tries(rule_of(rule), "", ping()));
        // FW-ENV-24 checks only responses to the requests of its own trials.
        let reported = if rule == "FW-ENV-24" { "FW-ENV-07" } else { rule };
        assert_eq!(violated_by(&session), [(reported, 1)]);
        session.lines.pop();
        assert_eq!(
            violated_by(&session),
            [],
            "{rule}: the recording doesn't contain the end of the connection"
        );
    }
    let session = over("tcp#2", |session| session.refused(rule_of("FW-SIO-02"), "", "No such transport"));
    assert_eq!(violated_by(&session), [("FW-SIO-02", 1)]);
    let session = over("tcp#2", |session| {
        session.refused(rule_of("FW-SIO-02"), "", "No such rule");
        session.lines.last_mut().expect("a line")["trial"] = "FW-NONE-01".into();
    });
    assert_eq!(violated_by(&session), []);
}

/// Datagrams may get lost.
#[test]
fn one_answer_is_sufficient_over_udp() {
    let rules = ["FW-UDP-02", "FW-UDP-03"];
    for rule in rules {
        for answered in [None, Some(0), Some(1), Some(2)] {
            let session = over("udp#1", |session| {
                session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": [] }));
                for attempt in 0..3 {
                    let id = session.tries(rule_of(rule), "three times", ping());
                    if answered == Some(attempt) {
                        session.answers(&id, json!({ "body": { "type": "ACK-ACK" } }));
                    }
                }
            });
            let expected = if answered.is_none() { vec![(rule, 1)] } else { vec![] };
            assert_eq!(violated_by(&session), expected, "{rule}, {answered:?}");
        }
    }
    // The lost part of a recording may contain the other answers. The first request was answered.
    let session = over("udp#1", |session| {
        let id = session.tries(rule_of("FW-UDP-03"), "twice", ping());
        session.answers(&id, json!({ "body": { "type": "ACK-ACK" } }));
        session.tries(rule_of("FW-UDP-03"), "twice", ping());
    });
    let mut lines: Vec<String> = session.lines.iter().map(ToString::to_string).collect();
    lines.insert(lines.len() - 2, "{\"t\":1790000001,\"conn\"".to_owned());
    let result = check_capture(lines.join("\n").as_bytes(), None, &DEFINITIONS);
    let result = result.expect("bytes can be read");
    assert_eq!((result.corruption.len(), result.findings.groups().count()), (1, 0));
    // A status report shows that the server sends messages over UDP.
    let session = over("udp#1", |session| {
        let state = json!({ "id": "kite", "timestamp": 1_790_000_000_000_u64 });
        let report = json!({ "type": "UAV-INF", "status": { "kite": state } });
        (0..3).for_each(|_| session.notify(report.clone()));
        session.tries(rule_of("FW-UDP-03"), "", ping());
    });
    assert_eq!(violated_by(&session), [("FW-UDP-03", 1)]);
    // Without any answer, it is unknown whether the service has ended.
    let silence =
        over("udp#1", |session| rules.iter().for_each(|rule| _ = session.tries(rule_of(rule), "", ping())));
    assert_eq!(violated_by(&silence), [("FW-UDP-02", 1)]);
    // Other trials over UDP may get lost as well.
    for rule in ["FW-ENV-07", "FW-ENV-21", "FW-SYS-PING-01"] {
        assert_eq!(violated_by(&over("udp#1", |session| _ = session.tries(rule_of(rule), "", ping()))), []);
    }
}

/// A client sends a datagram again if no answer arrives in time.
#[test]
fn one_answer_is_sufficient_for_a_request_that_was_sent_twice_over_udp() {
    let answered = |times: u32| {
        let session = over("udp#1", |session| {
            let id = session.tries(rule_of("FW-UDP-02"), "before the login", json!({ "type": "SYS-VER" }));
            let again = session.lines.last().cloned();
            session.lines.extend(again);
            for _ in 0..times {
                let version = json!({ "type": "SYS-VER", "software": "Windward", "version": "3.1" });
                session.answers(&id, json!({ "body": version }));
            }
        });
        violated_by(&session)
    };
    assert_eq!((answered(0), answered(1), answered(2)), (vec![("FW-UDP-02", 1)], vec![], vec![]));
    // Different requests with the same id share their answers.
    let session = over("udp#1", |session| {
        let id = session.sends(json!({ "type": "UAV-INF", "ids": ["kite"] }));
        session.sends(json!({ "type": "UAV-INF", "ids": ["swift"] }));
        session.lines.last_mut().expect("a request")["msg"]["id"] = id.clone().into();
        session.answers(&id, json!({ "body": { "type": "UAV-INF", "error": { "swift": "Lost" } } }));
    });
    assert_eq!(violated_by(&session), []);
}

#[test]
fn up_to_64_trials_over_udp_are_separate() {
    let subjects = |number: usize| {
        let session = over("udp#1", |session| {
            for at in 0..number {
                session.tries(rule_of("FW-UDP-02"), &format!("trial {at}"), ping());
            }
        });
        let result = checked(&session);
        let subjects: Vec<String> = result.findings.groups().map(|group| group.subject.clone()).collect();
        (subjects.len(), subjects.contains(&"message".to_owned()))
    };
    assert_eq!((subjects(64), subjects(65), subjects(66)), ((64, false), (65, true), (65, true)));
}

#[test]
fn an_error_without_a_body_does_not_count_as_an_answer() {
    let session = over("tcp#2", |session| {
        let id = session.tries(rule_of("FW-TCP-03"), "after a line that is not JSON", ping());
        session.answers(&id, json!({ "error": { "message": "No JSON" } }));
    });
    assert_eq!(violated_by(&session), [("FW-TCP-03", 1)]);
}

#[test]
fn a_ping_may_be_rejected_before_the_login() {
    let refused = || json!({ "type": "ACK-NAK", "reason": "Log in first" });
    let session = over("tcp#2", |session| session.exchange_with(ping(), refused()));
    assert_eq!((violated_by(&session), covered(&session, "FW-SYS-PING-01")), (vec![], 1));
}

/// Before login, a server may reject all requests in the same way.
#[test]
fn detects_supported_families_by_their_rejections() {
    let session_with = |login: Option<bool>, reasons: [&str; 3]| {
        over("tcp#2", |session| {
            if let Some(is_needed) = login {
                session
                    .exchange(json!({ "type": "AUTH-INF" }), json!({ "methods": [], "required": is_needed }));
            }
            let kinds = [("FW-ENV-07", "UAV-SOAR"), ("FW-ENV-24", "DEV-LIST"), ("FW-ENV-24", "DEV-SUB")];
            for ((rule, kind), reason) in kinds.into_iter().zip(reasons) {
                let refused = json!({ "type": "ACK-NAK", "reason": reason });
                session.tries_and_receives(rule_of(rule), "", json!({ "type": kind }), refused);
            }
        })
    };
    let alike = ["No UAV-SOAR here", "No DEV-LIST here", "No DEV-SUB here"];
    let other = ["No UAV-SOAR here", "No DEV-LIST here", "DEV-SUB has no paths"];
    assert_eq!(violated_by(&session_with(None, alike)), [("FW-ENV-24", 1)]);
    assert_eq!(violated_by(&session_with(Some(false), alike)), [("FW-ENV-24", 1)]);
    assert_eq!(violated_by(&session_with(Some(true), alike)), []);
    assert_eq!(violated_by(&session_with(None, other)), []);
    // Other answers may be missing: without the end of the connection, after unreadable data, and after a gap.
    let mut unreadable = session_with(None, alike);
    let text = json!({ "t": 1_790_000_009.0, "conn": "tcp#2", "dir": "in", "raw": "No such type" });
    unreadable.lines.insert(unreadable.lines.len() - 1, text);
    assert_eq!(violated_by(&unreadable), [("FW-ENV-01", 1)]);
    let mut reopened = session_with(None, alike);
    reopened.lines.pop();
    reopened.over("tcp#2", |_| ());
    assert_eq!(violated_by(&reopened), []);
    let mut bytes = session_with(None, alike).to_bytes();
    let end = bytes.iter().take(bytes.len() - 1).rposition(|byte| *byte == b'\n').expect("lines") + 1;
    bytes.splice(end..end, *b"{\"t\":1790000001,\"conn\"\n");
    let result = check_capture(&bytes[..], None, &DEFINITIONS).expect("bytes can be read");
    assert_eq!((result.corruption.len(), result.findings.groups().count()), (1, 0));
}

/// A server may refuse unknown objects as it refuses unknown types, or serve only some types of a family.
#[test]
fn a_family_is_absent_only_if_nothing_else_explains_the_refusals() {
    let refused = |kind: &str, reason: &str, ids: Option<&[&str]>| {
        let mut request = json!({ "type": kind });
        if let Some(ids) = ids {
            request["ids"] = json!(ids);
        }
        let session = over("tcp#2", |session| {
            let refusal = |kind: &str| json!({ "type": "ACK-NAK", "reason": reason.replace("TYPE", kind) });
            let soar = json!({ "type": "UAV-SOAR" });
            session.tries_and_receives(rule_of("FW-ENV-07"), "", soar, refusal("UAV-SOAR"));
            session.tries_and_receives(rule_of("FW-ENV-24"), "", request, refusal(kind));
            if kind == "CONN-INF" {
                session.exchange(json!({ "type": "CONN-LIST" }), json!({ "ids": [] }));
            }
        });
        violated_by(&session)
    };
    let named = Some(&["r-1"][..]);
    assert_eq!(refused("ASYNC-RESUME", "No", named), []);
    assert_eq!(refused("ASYNC-RESUME", "No such thing…", named), []);
    assert_eq!(refused("ASYNC-RESUME", "No TYPE here", named), [("FW-ENV-24", 1)]);
    assert_eq!(refused("ASYNC-RESUME", "No", Some(&[])), [("FW-ENV-24", 1)]);
    assert_eq!(refused("ASYNC-RESUME", "No", None), [("FW-ENV-24", 1)]);
    assert_eq!(refused("CONN-INF", "No TYPE here", named), []);
}

/// If a server states more reasons than the check stores, it handles the family.
#[test]
fn compares_up_to_16_reasons_for_rejections() {
    let rejected = |number: usize| {
        let session = over("tcp#2", |session| {
            let kinds = [("FW-ENV-07", "UAV-SOAR", number), ("FW-ENV-24", "DEV-LIST", 1)];
            for (rule, kind, number) in kinds {
                for at in (0..number).rev() {
                    let refused = json!({ "type": "ACK-NAK", "reason": format!("reason {at}") });
                    session.tries_and_receives(rule_of(rule), "", json!({ "type": kind }), refused);
                }
            }
        });
        violated_by(&session)
    };
    assert_eq!((rejected(16), rejected(17)), (vec![("FW-ENV-24", 1)], vec![]));
}

#[test]
fn accepts_pipelined_answers() {
    let in_order = over("tcp#2", |session| session.pipelines(rule_of("FW-ENV-25"), &[0, 1, 2]));
    assert_eq!((violated_by(&in_order), covered(&in_order, "FW-ENV-25")), (vec![], 3));
    let reversed = over("tcp#2", |session| session.pipelines(rule_of("FW-ENV-25"), &[2, 1, 0]));
    assert_eq!(violated_by(&reversed), [("FW-ENV-25", 1)], "once a connection");
    let untried = over("tcp#2", |session| session.pipelines(rule_of("FW-TCP-02"), &[2, 1, 0]));
    assert_eq!(violated_by(&untried), []);
    let unordered = over("udp#2", |session| session.pipelines(rule_of("FW-ENV-25"), &[2, 1, 0]));
    assert_eq!((violated_by(&unordered), covered(&unordered, "FW-ENV-25")), (vec![], 0));
    // A missing answer has no position in the order.
    let first_missing = over("tcp#2", |session| session.pipelines(rule_of("FW-ENV-25"), &[1, 5]));
    assert_eq!((violated_by(&first_missing), covered(&first_missing, "FW-ENV-25")), (vec![], 1));
}

/// FW-ENV-25 checks only the order of answers, so FW-ENV-07 reports missing answers.
#[test]
fn reports_a_missing_answer_to_a_trial_once() {
    for (rule, expected) in [("FW-ENV-25", vec![("FW-ENV-07", 1)]), ("FW-TCP-02", vec![("FW-TCP-02", 1)])] {
        let session = over("tcp#2", |session| {
            session.tries(rule_of(rule), "", ping());
            session.wait(60.0);
            session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
        });
        assert_eq!(violated_by(&session), expected, "{rule}");
    }
}

#[test]
fn only_a_refused_connection_is_a_missing_connection() {
    let session = over("tcp#2", |session| {
        session.event("connect");
        let line = session.lines.last_mut().expect("an event");
        line["trial"] = "FW-SIO-02".into();
    });
    assert_eq!(violated_by(&session), []);
}

/// FW-ENV-10 reports a message with both members.
#[test]
fn an_error_next_to_a_body_is_not_a_refusal() {
    let session = over("tcp#2", |session| {
        let id = session.tries(rule_of("FW-TCP-03"), "after a line that is not JSON", ping());
        session.answers(&id, json!({ "body": { "type": "ACK-ACK" }, "error": { "message": "No JSON" } }));
    });
    assert_eq!(violated_by(&session), [("FW-ENV-10", 1)]);
}

#[test]
fn a_trial_of_a_ping_needs_the_usual_answer() {
    let answered = |answer: Value| {
        let session = over("tcp#2", |session| {
            let id = session.tries(rule_of("FW-SYS-PING-01"), "", ping());
            session.answers(&id, json!({ "body": answer }));
        });
        violated_by(&session)
    };
    assert_eq!(answered(json!({ "type": "ACK-ACK" })), []);
    assert_eq!(answered(json!({ "type": "ACK-NAK", "reason": "No" })), [("FW-SYS-PING-01", 1)]);
    assert_eq!(answered(json!({ "type": "UAV-LIST", "ids": [] })), [("FW-SYS-PING-01", 1)]);
}

#[test]
fn accepts_changing_objects() {
    let mast = ["kite", "mast"];
    // Objects may appear or disappear before the last list.
    for (before, after) in [(&["kite"][..], &mast[..]), (&mast[..], &["kite"][..])] {
        let session = over("tcp#2", |session| {
            objects(session, &[], before);
            objects(session, &["beacon"], &["mast"]);
            objects(session, &[], after);
        });
        assert_eq!(violated_by(&session), []);
    }
    // Notifications may report that an object disappears and reappears.
    let session = over("tcp#2", |session| {
        objects(session, &[], &["kite"]);
        objects(session, &["beacon"], &["mast"]);
        session.notify(json!({ "type": "OBJ-DEL", "ids": ["mast"] }));
        objects(session, &[], &["kite"]);
        let state = json!({ "id": "mast", "timestamp": 1_790_000_000_000_u64 });
        session.notify(json!({ "type": "UAV-INF", "status": { "mast": state } }));
        objects(session, &["uav"], &["mast"]);
    });
    assert_eq!(violated_by(&session), []);
    // Lists with several filters may share objects.
    let session = over("tcp#2", |session| {
        objects(session, &["uav", "beacon"], &mast);
        objects(session, &["uav"], &["kite"]);
        objects(session, &["beacon"], &["mast"]);
    });
    assert_eq!(violated_by(&session), []);
}

#[test]
fn accepts_changing_uavs() {
    for (before, between, after) in [
        (&["kite"][..], &["kite", "owl"][..], &["kite", "owl"][..]),
        (&["kite", "owl"], &["kite"], &["kite"]),
        (&["kite"], &["owl"], &["swift"]),
    ] {
        let session = over("tcp#2", |session| {
            uavs(session, before);
            objects(session, &["uav"], between);
            session.exchange(
                json!({ "type": "UAV-INF", "ids": ["owl"] }),
                json!({ "error": { "owl": "Unknown" } }),
            );
            uavs(session, after);
        });
        assert_eq!(violated_by(&session), [], "{before:?} {between:?} {after:?}");
    }
    let session = over("tcp#2", |session| {
        uavs(session, &["kite"]);
        session.notify(json!({ "type": "OBJ-DEL", "ids": ["kite"] }));
        session
            .exchange(json!({ "type": "UAV-INF", "ids": ["kite"] }), json!({ "error": { "kite": "Gone" } }));
        objects(session, &["uav"], &[]);
        session.notify(json!({ "type": "UAV-INF", "status": { "kite": { "id": "kite", "timestamp": 1_790_000_000_000_u64 } } }));
        uavs(session, &["kite"]);
    });
    assert_eq!(violated_by(&session), []);
}

/// A server need not report that an object has disappeared.
#[test]
fn lists_are_compared_only_within_ten_seconds() {
    let compared = |pause: f64| {
        let session = over("tcp#2", |session| {
            uavs(session, &["kite"]);
            objects(session, &[], &["kite"]);
            session.wait(pause);
            objects(session, &["uav"], &["kite", "owl"]);
            session.wait(pause);
            uavs(session, &["kite"]);
            objects(session, &[], &["kite"]);
        });
        violated_by(&session)
    };
    assert_eq!((compared(4.5), compared(5.5)), (vec![("FW-OBJ-LIST-04", 1), ("FW-UAV-LIST-02", 1)], vec![]));
}

#[test]
fn requests_and_lists_without_objects_cover_no_rule_on_objects() {
    let answered = |ids: &[&str]| {
        let session = over("tcp#2", |session| {
            let errors: Value = ids.iter().map(|id| ((*id).to_owned(), json!("Lost"))).collect();
            session.exchange(json!({ "type": "UAV-INF", "ids": ids }), json!({ "error": errors }));
            objects(session, &["uav"], ids);
            objects(session, &["beacon"], &[]);
            let state =
                json!({ "id": "kite", "timestamp": 1_790_000_000_000_u64, "errors": vec![1; ids.len()] });
            session.notify(json!({ "type": "UAV-INF", "status": { "kite": state } }));
        });
        assert_eq!(violated_by(&session), []);
        ["FW-UAV-INF-01", "FW-OBJ-LIST-02", "FW-ERR-01", "FW-ERR-04"].map(|id| covered(&session, id))
    };
    assert_eq!((answered(&[]), answered(&["kite"])), ([0; 4], [1; 4]));
}

#[test]
fn cancelled_operations_may_end_later() {
    let ended = |error: bool| {
        let what = if error { "error" } else { "result" };
        json!({ "type": "ASYNC-RESP", "id": "r-1", what: "Flaps out" })
    };
    let report = || json!({ "type": "CONN-DEL", "ids": ["winch"] });
    let mut slow = over("tcp#2", |session| {
        session.command("r-1");
        let id = cancel(session, "r-1");
        cancelled(session, &id, "r-1");
        session.notify(json!({ "type": "ASYNC-ST", "id": "r-1", "progress": {} }));
        session.wait(8.0);
        session.notify(report());
        session.notify(ended(true));
        session.wait(60.0);
        session.notify(report());
    });
    assert_eq!((violated_by(&slow), covered(&slow, "FW-ASY-17")), (vec![], 1));
    // Without the end of the operation, and with a time that goes backwards.
    slow.lines.retain(|line| line["msg"]["body"]["type"] != "ASYNC-RESP");
    assert_eq!(violated_by(&slow), [("FW-ASY-17", 1)]);
    slow.lines[2]["t"] = json!(1.85e9);
    assert_eq!(violated_by(&slow), []);
    // The operation ends before the answer, and another operation reuses the receipt.
    let session = over("tcp#2", |session| {
        session.command("r-1");
        let id = cancel(session, "r-1");
        session.notify(ended(false));
        cancelled(session, &id, "r-1");
        session.command("r-1");
        session.wait(60.0);
        session.notify(report());
        session.notify(ended(false));
    });
    assert_eq!(violated_by(&session), []);
    // The server sends nothing more.
    let session = over("tcp#2", |session| {
        session.command("r-1");
        let id = cancel(session, "r-1");
        cancelled(session, &id, "r-1");
    });
    assert_eq!(violated_by(&session), []);
}

#[test]
fn accepts_resuming_an_operation_that_was_suspended_meanwhile() {
    let session = over("tcp#2", |session| {
        session.command("r-1");
        let resume = json!({ "type": "ASYNC-RESUME", "ids": ["r-1"] });
        let id = session.tries(rule_of("FW-ASY-19"), "a running operation", resume);
        session.notify(json!({ "type": "ASYNC-ST", "id": "r-1", "progress": {}, "suspended": true }));
        session.answers(&id, json!({ "body": { "type": "ASYNC-RESUME", "success": ["r-1"] } }));
    });
    assert_eq!(violated_by(&session), []);
}

/// The clock jumps or stops around an adjustment of zero.
#[test]
fn distinguishes_clock_errors_from_adjustments_of_zero() {
    let times = |adjustments: [Option<i64>; 3], seconds: [u64; 3], pause: f64| {
        over("tcp#2", |session| {
            for (adjustment, seconds) in adjustments.into_iter().zip(seconds) {
                let mut request = json!({ "type": "SYS-TIME" });
                if let Some(adjustment) = adjustment {
                    request["adjustment"] = adjustment.into();
                }
                session.exchange(request, json!({ "timestamp": 1_790_000_000_000 + seconds * 1000 }));
                session.wait(pause);
            }
        })
    };
    let none = [None, Some(0), None];
    assert_eq!(violated_by(&times(none, [0, 0, 0], 0.1)), []);
    assert_eq!(violated_by(&times(none, [0, 3600, 3600], 0.1)), [("FW-SYS-TIME-03", 1)]);
    assert_eq!(violated_by(&times(none, [0, 0, 3600], 0.1)), [("FW-SYS-TIME-03", 1)]);
    // The clock stands still.
    assert_eq!(violated_by(&times(none, [0, 0, 0], 5.0)), [("FW-SYS-TIME-02", 2)]);
    assert_eq!(violated_by(&times([None, None, None], [0, 3600, 3600], 0.1)), [("FW-SYS-TIME-02", 1)]);
    // The clock is adjusted as well.
    assert_eq!(violated_by(&times([None, Some(0), Some(3_600_000)], [0, 0, 3600], 0.1)), []);
}

/// A message split into several lines is one deviation. Invalid text is a separate deviation.
#[test]
fn recognizes_the_lines_of_a_split_message() {
    let message = json!({
        "$fw.version": "1.0", "id": "a", "body": { "type": "OBJ-DEL", "ids": ["vane", "}{"], "n": [1, 2] },
    });
    let pretty = serde_json::to_string_pretty(&message).expect("JSON");
    let count = pretty.lines().count() as u64;
    let says = |connection: &'static str, lines: &str| {
        let session = over(connection, |session| lines.lines().for_each(|line| session.send_raw(line)));
        violated_by(&session)
    };
    assert_eq!(says("tcp#2", &pretty), [("FW-TCP-01", 1)]);
    assert_eq!(says("TCP", &format!("{pretty}\n{pretty}")), [("FW-TCP-01", 2)]);
    assert_eq!(says("hill", &pretty), [("FW-ENV-01", count)], "a transport other than TCP");
    let half: String = pretty.lines().take(4).map(|line| format!("{line}\n")).collect();
    assert_eq!(says("tcp#2", &half), [], "the session ends before the rest");
    assert_eq!(says("tcp#2", &format!("{half}\n{message}")), [("FW-ENV-01", 5)]);
    assert_eq!(says("tcp#2", "}\nwho is there?\n[\n1\n]"), [("FW-ENV-01", 5)]);
    assert_eq!(says("tcp#2", "{\n\"wind\" 7\n}"), [("FW-ENV-01", 3)]);
    let two = format!("{message} {message}");
    assert_eq!(says("tcp#2", &two), [("FW-TCP-01", 1)]);
    assert_eq!(says("udp#2", &two), [("FW-UDP-01", 1)]);
    assert_eq!(says("hill", &two), [("FW-ENV-01", 1)]);
    assert_eq!(says("udp#2", &format!("{message} and more")), [("FW-ENV-01", 1)]);
}

#[test]
fn checks_ports_of_the_transport_in_use() {
    let listed = |connection: &'static str, ports: Value| {
        over(connection, |session| {
            session.exchange(json!({ "type": "SYS-PORTS" }), json!({ "ports": ports }));
        })
    };
    for (connection, ports) in [
        ("tcp#2", json!({ "tcp": 7001, "udp": 9 })),
        ("udp#2", json!({ "tcp": 9, "udp": 7002 })),
        ("socketio#2", json!({ "http": 9 })),
    ] {
        assert_eq!(violated_by(&listed(connection, ports)), []);
    }
    let wrong = listed("udp#2", json!({ "tcp": 7001, "udp": 7001 }));
    assert_eq!(violated_by(&wrong), [("FW-SYS-PORTS-02", 1)]);
    // Only the start of a connection contains the port.
    let mut paused = listed("tcp#2", json!({ "tcp": 9 }));
    paused
        .lines
        .insert(2, json!({ "t": 1_790_000_000.2, "conn": "tcp#2", "dir": "event", "event": "paused" }));
    assert_eq!(violated_by(&paused), [("FW-SYS-PORTS-02", 1)]);
    let mut unknown = listed("tcp#2", json!({ "tcp": 9 }));
    unknown.lines[1]["url"] = "hill".into();
    assert_eq!(violated_by(&unknown), []);
}
