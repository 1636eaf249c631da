//! Tests that rules store a bounded amount of state, and that data within the limits is checked.

use serde_json::{Value, json};
use uavspec_rules::flockwave::sample::Session;

use super::{checked, violated_by};

/// Adds a list of objects: of one type, or of all types if `kind` is `None`.
fn objects(session: &mut Session, kind: Option<&str>, ids: &[String]) {
    let mut request = json!({ "type": "OBJ-LIST" });
    if let Some(kind) = kind {
        request["filter"] = json!([kind]);
    }
    session.exchange(request, json!({ "ids": ids }));
}

fn names(number: usize) -> Vec<String> {
    (0..number).map(|at| format!("glider-with-a-long-name-{at:05}")).collect()
}

#[test]
fn lists_of_eight_object_types_are_compared() {
    let violations = |number: usize| {
        let mut session = Session::opened();
        for at in 1..number {
            objects(&mut session, Some(&format!("kind-{at}")), &[]);
        }
        objects(&mut session, Some("first"), &["kite".to_owned()]);
        objects(&mut session, Some("second"), &["kite".to_owned()]);
        violated_by(&session)
    };
    assert_eq!((violations(8), violations(9)), (vec![("FW-OBJ-LIST-02", 1)], vec![]));
}

#[test]
fn up_to_10_000_filtered_objects_are_compared() {
    let violations = |number: usize| {
        let short: Vec<String> = (0..number).map(|at| at.to_string()).collect();
        let mut session = Session::opened();
        objects(&mut session, None, &[]);
        objects(&mut session, Some("uav"), &short[..1]);
        objects(&mut session, Some("uav"), &short[1..]);
        objects(&mut session, None, &[]);
        violated_by(&session)
    };
    assert_eq!(violations(10_000), [("FW-OBJ-LIST-04", 1)]);
    // Only the object of the first list is stored.
    let mut session = Session::opened();
    let short: Vec<String> = (0..10_001).map(|at| at.to_string()).collect();
    objects(&mut session, None, &short[..1]);
    objects(&mut session, Some("uav"), &short[..1]);
    objects(&mut session, Some("uav"), &short[1..]);
    objects(&mut session, None, &short[..1]);
    assert_eq!(violated_by(&session), []);
}

#[test]
fn long_lists_are_compared() {
    let mut session = Session::opened();
    let ids = names(5_000);
    objects(&mut session, Some("uav"), &ids);
    objects(&mut session, Some("beacon"), &ids[4_999..]);
    assert_eq!(violated_by(&session), [("FW-OBJ-LIST-02", 1)]);
}

#[test]
fn findings_name_four_objects() {
    let actual = |number: usize| {
        let mut session = Session::opened();
        session.exchange(json!({ "type": "UAV-INF", "ids": names(number) }), json!({ "status": {} }));
        let result = checked(&session.to_bytes());
        let actual: Vec<String> =
            result.findings.groups().map(|group| group.examples[0].1.actual.clone()).collect();
        (actual.len(), actual.join("").matches("in none").count(), actual.join("").contains(" more"))
    };
    assert_eq!((actual(3), actual(4), actual(5)), ((1, 3, false), (1, 4, false), (1, 4, true)));
    let mut session = Session::opened();
    session.exchange(json!({ "type": "UAV-INF", "ids": names(6) }), json!({ "status": {} }));
    let result = checked(&session.to_bytes());
    let group = result.findings.groups().next().expect("a finding");
    assert!(group.examples[0].1.actual.ends_with(", 2 more"), "{}", group.examples[0].1.actual);
}

#[test]
fn four_lists_of_objects_are_compared_with_a_list_of_uavs() {
    let violations = |number: usize| {
        let mut session = Session::opened();
        let (kite, both) = (["kite".to_owned()], ["kite".to_owned(), "owl".to_owned()]);
        let uavs =
            |session: &mut Session| session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": kite }));
        uavs(&mut session);
        for _ in 1..number {
            objects(&mut session, Some("uav"), &kite);
        }
        objects(&mut session, Some("uav"), &both);
        uavs(&mut session);
        violated_by(&session)
    };
    assert_eq!((violations(4), violations(5)), (vec![("FW-UAV-LIST-02", 1)], vec![]));
}

#[test]
fn up_to_1_000_unknown_uavs_are_reported() {
    let violations = |number: usize| {
        let mut session = Session::opened();
        let ids = names(number);
        let unknown: Value = ids.iter().map(|id| (id.clone(), json!("Unknown"))).collect();
        session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": ids }));
        session.exchange(json!({ "type": "UAV-INF", "ids": ids }), json!({ "error": unknown }));
        session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": ids }));
        violated_by(&session)
    };
    assert_eq!(
        (violations(1_000), violations(1_001)),
        (vec![("FW-UAV-LIST-03", 1_000)], vec![("FW-UAV-LIST-03", 1_000)])
    );
}
